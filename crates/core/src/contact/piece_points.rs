//! Points of the surface of a body that broke, in the cells of their pieces.

use nalgebra::Point3;

use super::surface_points::surface_points;
use crate::lattice::{Embedding, Lattice};
use crate::mesh::{SurfaceTree, flip_needles};

/// The surface of a body that broke.
pub(super) struct PieceSurface<'a> {
    /// Positions at rest.
    pub(super) vertices: &'a [Point3<f64>],
    pub(super) triangles: &'a [[u32; 3]],
    /// 1 / the distance up to which vertices are at the same place.
    pub(super) scale: f64,
    /// The cell that each vertex follows.
    pub(super) hosts: &'a dyn Fn(u32) -> u32,
}

/// Points of the surface of a body that broke.
pub(super) struct PiecePoints {
    /// Positions at rest, piece by piece.
    pub(super) points: Vec<Point3<f64>>,
    /// The cells of the points, each of the point's own piece.
    pub(super) embedding: Embedding,
    /// The triangles of each piece; `None` if they have no area.
    pub(super) trees: Vec<Option<SurfaceTree>>,
}

/// The surface of one piece. Vertices at the same place are one, and there are no needles, so that the pseudonormals of
/// [`SurfaceTree`] are right.
struct Piece {
    vertices: Vec<Point3<f64>>,
    /// The cell that each vertex follows.
    hosts: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl PieceSurface<'_> {
    /// 1 / the distance in cells up to which vertices are at the same place.
    pub(super) const SCALE: f64 = 1048576.0;

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
    ) -> PiecePoints {
        let (mut points, mut in_model, mut cells) = (Vec::new(), Vec::new(), Vec::new());
        let mut trees = Vec::new();
        for (number, piece) in (0..).zip(self.pieces(lattice)) {
            let tree = SurfaceTree::new(&piece.vertices, piece.triangles.iter().copied());
            if let Some(tree) = &tree {
                let own: Vec<u32> = (0..piece.vertices.len() as u32).collect();
                let found = surface_points(&piece.vertices, &piece.triangles, &own, spacing, limit);
                let positions: Vec<_> = found.iter().map(&to_model).collect();
                let located = Embedding::new(lattice, &positions);
                cells.extend(found.iter().zip(&positions).enumerate().map(|(index, (point, position))| {
                    let cell = located.cell(index);
                    nearest_of_piece(lattice, cell, number, position).unwrap_or_else(|| {
                        let closest = tree.closest(point, f64::MAX, |_| true);
                        closest
                            .map_or(cell, |closest| piece.hosts[tree.triangle(closest.triangle)[0] as usize])
                    })
                }));
                points.extend(found);
                in_model.extend(positions);
            }
            trees.push(tree);
        }
        let embedding = Embedding::in_cells(lattice, &in_model, &cells);
        PiecePoints { points, embedding, trees }
    }

    /// Returns the surface of each piece.
    fn pieces(&self, lattice: &Lattice) -> Vec<Piece> {
        let mut of_pieces = vec![Vec::new(); lattice.components().count];
        for triangle in self.triangles {
            let piece = lattice.component_of_cell((self.hosts)(triangle[0]));
            of_pieces[piece as usize].push(*triangle);
        }
        of_pieces.into_iter().map(|triangles| self.piece(&triangles)).collect()
    }

    /// Welds the vertices of the triangles of a piece, and removes needles.
    fn piece(&self, triangles: &[[u32; 3]]) -> Piece {
        let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let position = |vertex: u32| self.vertices[vertex as usize];
        let place = |&vertex: &u32| {
            let place = (position(vertex).coords * self.scale).map(|x| x.round() as i64);
            (<[i64; 3]>::from(place), vertex)
        };
        let mut places: Vec<([i64; 3], u32)> = used.iter().map(place).collect();
        places.sort_unstable();
        // The lowest vertex at each place stands for the others.
        let same = places.chunk_by(|a, b| a.0 == b.0);
        let mut lowest: Vec<(u32, u32)> =
            same.flat_map(|same| same.iter().map(|&(_, vertex)| (vertex, same[0].1))).collect();
        lowest.sort_unstable();
        let kept: Vec<u32> =
            lowest.iter().filter(|(vertex, first)| vertex == first).map(|(vertex, _)| *vertex).collect();
        let number = |vertex: u32| {
            let (_, first) = lowest[used.partition_point(|&other| other < vertex)];
            kept.partition_point(|&other| other < first) as u32
        };
        let vertices: Vec<_> = kept.iter().map(|&vertex| position(vertex)).collect();
        let mut triangles: Vec<[u32; 3]> = triangles
            .iter()
            .map(|triangle| triangle.map(number))
            .filter(|&[a, b, c]| a != b && b != c && c != a)
            .collect();
        flip_needles(&vertices, &mut triangles, 1.0 / self.scale);
        Piece { hosts: kept.iter().map(|&vertex| (self.hosts)(vertex)).collect(), vertices, triangles }
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
