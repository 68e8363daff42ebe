//! Points of the surface of a body that broke, in the cells of their pieces.

use std::collections::HashMap;

use nalgebra::Point3;

use super::surface_points::surface_points;
use crate::lattice::{Embedding, Lattice};
use crate::mesh::{SurfaceTree, flip_needles};

/// The surface of a body that broke.
pub(super) struct PieceSurface<'a> {
    /// Positions at rest.
    pub(super) vertices: &'a [Point3<f64>],
    pub(super) triangles: &'a [[u32; 3]],
    /// The first vertex at the position of each vertex.
    pub(super) weld: &'a [u32],
    /// 1 / the distance up to which vertices are at the same place.
    pub(super) scale: f64,
    /// The cell that each vertex follows.
    pub(super) hosts: &'a dyn Fn(u32) -> u32,
}

impl PieceSurface<'_> {
    /// 1 / the distance in cells up to which vertices are at the same place.
    pub(super) const SCALE: f64 = 1048576.0;

    /// Returns the triangles of each piece. Vertices of a piece at the same place are one, and there are no needles, so
    /// that the pseudonormals of [`SurfaceTree`] are right.
    pub(super) fn triangles_of_pieces(&self, lattice: &Lattice) -> Vec<Vec<[u32; 3]>> {
        let mut pieces = vec![Vec::new(); lattice.components().count];
        let mut first = HashMap::new();
        for triangle in self.triangles {
            let piece = lattice.component_of_cell((self.hosts)(triangle[0]));
            let corners = triangle.map(|corner| {
                let place = (self.vertices[corner as usize].coords * self.scale).map(|x| x.round() as i64);
                *first.entry((piece, place)).or_insert(corner)
            });
            if corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0] {
                pieces[piece as usize].push(corners);
            }
        }
        for of_piece in &mut pieces {
            flip_needles(self.vertices, of_piece, 1.0 / self.scale);
        }
        pieces
    }

    /// Returns points of the surface, as [`surface_points`] does, and their embedding. `to_model`: returns a position
    /// at rest in the model's frame.
    ///
    /// The surface of a crack is smooth, so that a part of it lies in cells of the other side. Such points follow a
    /// cell of their own piece.
    pub(super) fn points(
        &self,
        lattice: &Lattice,
        (spacing, limit): (f64, usize),
        to_model: impl Fn(&Point3<f64>) -> Point3<f64>,
    ) -> (Vec<Point3<f64>>, Embedding) {
        let (mut points, mut in_model, mut cells) = (Vec::new(), Vec::new(), Vec::new());
        for (piece, of_piece) in (0..).zip(self.triangles_of_pieces(lattice)) {
            let Some(tree) = SurfaceTree::new(self.vertices, of_piece.iter().copied()) else { continue };
            let found = surface_points(self.vertices, &of_piece, self.weld, spacing, limit);
            let positions: Vec<_> = found.iter().map(&to_model).collect();
            let located = Embedding::new(lattice, &positions);
            cells.extend(found.iter().zip(&positions).enumerate().map(|(index, (point, position))| {
                let cell = located.cell(index);
                nearest_of_piece(lattice, cell, piece, position).unwrap_or_else(|| {
                    let closest = tree.closest(point, f64::MAX, |_| true);
                    closest.map_or(cell, |closest| (self.hosts)(tree.triangle(closest.triangle)[0]))
                })
            }));
            points.extend(found);
            in_model.extend(positions);
        }
        let embedding = Embedding::in_cells(lattice, &in_model, &cells);
        (points, embedding)
    }
}

/// Returns the cell of a piece that is nearest to a point in the model's frame, among a cell and those around it.
fn nearest_of_piece(lattice: &Lattice, cell: u32, piece: u32, point: &Point3<f64>) -> Option<u32> {
    if lattice.component_of_cell(cell) == piece {
        return Some(cell);
    }
    let local = (point - lattice.origin()) / lattice.cell_size();
    let center = lattice.cells()[cell as usize];
    let around = (0..27).filter_map(|k| {
        let index = [0, 1, 2].map(|a| center[a] + k / [1, 3, 9][a] % 3 - 1);
        let cell = lattice.cell_at(index).filter(|&cell| lattice.component_of_cell(cell) == piece)?;
        let outside = |a: usize| (f64::from(index[a]) - local[a]).max(local[a] - f64::from(index[a]) - 1.0);
        Some(((0..3).map(|a| outside(a).max(0.0).powi(2)).sum::<f64>(), cell))
    });
    around.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, cell)| cell)
}
