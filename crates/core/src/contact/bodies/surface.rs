//! The surface of a body at rest, as contact between bodies needs it: trees of its triangles, and samples of it.
//!
//! Rest coordinates are positions in the model's frame, in cells from the origin of the lattice: a point of the cell
//! with the index i and the local coordinates u has the rest coordinates i + u, however the body is deformed.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use super::super::piece_points::{PiecePoints, PieceSurface};
use super::super::surface_points::{MAX_SAMPLES, surface_points};
use crate::lattice::{Embedding, Lattice, trilinear_weights};
use crate::mesh::{Mesh, SurfaceTree};

/// Greatest distance of samples within a triangle, in cells. The samples of the other body lie as densely, and both
/// bodies are searched for the samples of the other.
const SPACING: f64 = 0.5;

/// Greatest distance of cells of one body, in cells along an axis, that are connected and do not touch each other.
const NEIGHBORHOOD: i32 = 2;

/// Least weight of a lattice vertex that moves a sample noticeably.
const LEAST_WEIGHT: f32 = 0.02;

/// Surface of a body at rest.
#[derive(Debug)]
pub(crate) struct ContactSurface {
    /// The triangles of each piece, in rest coordinates; `None` if they have no area. Both sides of a crack have the
    /// same rest coordinates. A body that did not break is one piece.
    trees: Vec<Option<SurfaceTree>>,
    /// The piece of each cell; empty if the body did not break.
    pieces: Vec<u32>,
    /// Whether the surface encloses a volume. Otherwise contacts act on both sides of it, but where it broke.
    pub(super) is_closed: bool,
    /// The samples, by cell.
    pub(super) samples: Vec<Sample>,
    /// The cells that contain samples.
    pub(super) cells: Vec<SampledCell>,
    /// Lattice vertices at the corners of each cell of the lattice.
    pub(super) corners: Vec<[u32; 8]>,
    /// The sides of each cell that were joined to another piece, one bit for each of the sides at -x, +x, -y, +y, -z,
    /// +z; empty if the body did not break. A part of the smooth surface of a crack lies beyond them.
    pub(super) continued_sides: Vec<u8>,
}

/// A point of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Local coordinates in its cell, in [0, 1].
    pub(super) local: [f32; 3],
    /// Unit normal at rest.
    pub(super) normal: [f32; 3],
}

/// A cell with samples.
#[derive(Clone, Debug)]
pub(super) struct SampledCell {
    pub(super) cell: u32,
    /// Its samples, as a range of `ContactSurface::samples`.
    pub(super) samples: Range<u32>,
}

impl ContactSurface {
    /// Creates the surface of a mesh in its lattice, both in the model's frame. Returns `None` if no triangle has an
    /// area.
    ///
    /// `embedding`: of the vertices of the mesh.
    pub(crate) fn of_mesh(mesh: &Mesh, lattice: &Lattice, embedding: &Embedding) -> Option<Self> {
        let (origin, scale) = (lattice.origin(), 1.0 / lattice.cell_size());
        let vertices: Vec<_> = mesh.vertices().iter().map(|p| Point3::from((p - origin) * scale)).collect();
        let weld = mesh.weld();
        let triangles: Vec<_> =
            mesh.surface().iter().map(|triangle| triangle.map(|v| weld[v as usize])).collect();
        let host = |vertex: u32| embedding.cell(vertex as usize);
        Self::new(lattice, &vertices, &triangles, mesh.is_closed(), host)
    }

    /// Creates the surface of a bare lattice: the faces of its cells that no other cell shares.
    pub(crate) fn of_lattice(lattice: &Lattice) -> Option<Self> {
        let vertices: Vec<_> = lattice.indices().iter().map(|index| index.map(f64::from).into()).collect();
        let mut triangles = Vec::new();
        for cell in 0..lattice.cells().len() as u32 {
            let corners = lattice.cell_corners(cell);
            for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
                if lattice.joined_cell(cell, 2 * axis + side).is_none() {
                    let [a, b, c, d] = outward_face(axis, side == 1).map(|corner| corners[corner]);
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        let mut hosts = vec![0; lattice.len()];
        for cell in 0..lattice.cells().len() as u32 {
            lattice.cell_corners(cell).into_iter().for_each(|corner| hosts[corner as usize] = cell);
        }
        Self::new(lattice, &vertices, &triangles, true, |vertex| hosts[vertex as usize])
    }

    fn new(
        lattice: &Lattice,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        is_closed: bool,
        host: impl Fn(u32) -> u32,
    ) -> Option<Self> {
        let limit = MAX_SAMPLES * lattice.len();
        let in_model = |p: &Point3<f64>| lattice.origin() + p.coords * lattice.cell_size();
        let is_broken = !lattice.broken_joints().is_empty();
        let (PiecePoints { points, embedding, trees }, pieces) = if is_broken {
            let surface = PieceSurface { vertices, triangles, scale: PieceSurface::SCALE, hosts: &host };
            let of_cell = (0..lattice.cells().len() as u32).map(|cell| lattice.component_of_cell(cell));
            (surface.points(lattice, (SPACING, limit), in_model), of_cell.collect())
        } else {
            let own: Vec<u32> = (0..vertices.len() as u32).collect();
            let points = surface_points(vertices, triangles, &own, SPACING, limit);
            let embedding = Embedding::new(lattice, &points.iter().map(in_model).collect::<Vec<_>>());
            let trees = vec![SurfaceTree::new(vertices, triangles.iter().copied())];
            (PiecePoints { points, embedding, trees }, Vec::new())
        };
        if trees.iter().all(Option::is_none) {
            return None;
        }
        let continued_sides = continued_sides(lattice, &pieces);
        let mut surface = Self {
            trees,
            pieces,
            is_closed,
            samples: Vec::new(),
            cells: Vec::new(),
            corners: Vec::new(),
            continued_sides,
        };
        let mut order: Vec<(u32, u32)> = (0..points.len()).map(|i| (embedding.cell(i), i as u32)).collect();
        order.sort_unstable();
        // The smooth surface of a crack lies outside the cells of its piece in part.
        let (least, greatest) = if is_broken { (-1.0, 2.0) } else { (0.0, 1.0) };
        let sample = |&(cell, point): &(u32, u32)| {
            let tree = surface.tree_at(cell);
            let closest = tree.and_then(|tree| tree.closest(&points[point as usize], f64::MAX, |_| true));
            let normal = closest.map_or_else(Vector3::x, |closest| closest.normal);
            let local = embedding.local(point as usize).map(|x| x.clamp(least, greatest));
            Sample { local, normal: normal.map(|x| x as f32).into() }
        };
        surface.samples = order.iter().map(sample).collect();
        let mut start = 0;
        for group in order.chunk_by(|a, b| a.0 == b.0) {
            let end = start + group.len() as u32;
            surface.cells.push(SampledCell { cell: group[0].0, samples: start..end });
            start = end;
        }
        surface.corners = lattice.corner_table().into_owned();
        Some(surface)
    }

    /// Returns the triangles of the piece that contains a cell, in rest coordinates; `None` if they have no area.
    pub(super) fn tree_at(&self, cell: u32) -> Option<&SurfaceTree> {
        let piece = self.pieces.get(cell as usize).map_or(0, |piece| *piece as usize);
        self.trees[piece].as_ref()
    }

    /// Returns whether two cells of the body touch each other: cells of different pieces, and cells of connected parts
    /// if `connected_parts_touch`, unless they are the same or joined by at most [`NEIGHBORHOOD`] steps through cells
    /// with common corners.
    pub(super) fn cells_touch(
        &self,
        lattice: &Lattice,
        connected_parts_touch: bool,
        [a, b]: [u32; 2],
    ) -> bool {
        if self.pieces.get(a as usize) != self.pieces.get(b as usize) {
            return true;
        }
        connected_parts_touch && !are_near(lattice, a, b)
    }

    /// Returns whether two cells of the body are of different pieces, and one of them was joined to another piece.
    pub(super) fn are_at_crack(&self, cells: [u32; 2]) -> bool {
        let [a, b] = cells.map(|cell| self.pieces.get(cell as usize));
        a != b
            && cells
                .iter()
                .any(|&cell| self.continued_sides.get(cell as usize).is_some_and(|sides| *sides != 0))
    }

    /// Returns the lattice vertices that move a sample noticeably; none if there is no such sample.
    pub(crate) fn vertices_of(&self, sample: u32) -> impl Iterator<Item = u32> + use<> {
        let found = self.samples.get(sample as usize).map(|found| {
            let group = self.cells.partition_point(|cell| cell.samples.end <= sample);
            (self.corners[self.cells[group].cell as usize], trilinear_weights(found.local))
        });
        found.into_iter().flat_map(|(corners, weights)| {
            corners
                .into_iter()
                .zip(weights)
                .filter(|(_, weight)| *weight > LEAST_WEIGHT)
                .map(|(vertex, _)| vertex)
        })
    }

    /// Returns the number of samples.
    pub(crate) fn sample_count(&self) -> usize {
        self.samples.len()
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { trees, pieces, samples, cells, corners, continued_sides, .. } = self;
        let lists = size_of_val(&**samples) + size_of_val(&**cells) + size_of_val(&**corners);
        let of_pieces = size_of_val(&**trees) + size_of_val(&**pieces) + size_of_val(&**continued_sides);
        trees.iter().flatten().map(SurfaceTree::bytes).sum::<usize>() + lists + of_pieces
    }
}

/// Returns the sides of each cell that were joined to another piece: see [`ContactSurface::continued_sides`].
/// `of_cell`: the piece of each cell; empty if the body did not break.
fn continued_sides(lattice: &Lattice, of_cell: &[u32]) -> Vec<u8> {
    let sides = |(cell, piece): (u32, &u32)| {
        let is_other = |side: u8| {
            let beyond = lattice.cell_beyond(cell, side / 2, if side % 2 == 1 { 1 } else { -1 });
            beyond.is_some_and(|beyond| of_cell[beyond as usize] != *piece)
        };
        (0..6).filter(|side| is_other(*side)).fold(0, |sides, side| sides | 1 << side)
    };
    (0..).zip(of_cell).map(sides).collect()
}

/// Returns whether two cells are the same or joined by at most [`NEIGHBORHOOD`] steps through cells with common
/// corners.
fn are_near(lattice: &Lattice, a: u32, b: u32) -> bool {
    let [a, b] = [a, b].map(|cell| lattice.cells()[cell as usize]);
    let distance = |a: [i32; 3], b: [i32; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).max().unwrap_or(0);
    match distance(a, b) {
        ..=1 => true,
        NEIGHBORHOOD => {
            let common = |c: usize| a[c].max(b[c]) - 1..=a[c].min(b[c]) + 1;
            common(0).any(|x| common(1).any(|y| common(2).any(|z| lattice.cell_at([x, y, z]).is_some())))
        }
        _ => false,
    }
}

/// Returns the corners of a face of a cell, counter-clockwise seen from outside the cell.
fn outward_face(axis: usize, is_high: bool) -> [usize; 4] {
    let (next, last) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
    match is_high {
        true => [0, next, next | last, last].map(|corner| corner | 1 << axis),
        false => [0, last, next | last, next],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surface_of_a_lattice_is_closed_and_faces_outwards() {
        let lattice =
            Lattice::from_cells(&[[0, 0, 0], [1, 0, 0], [1, 1, 0]], 0.5, Point3::origin(), false).unwrap();
        let surface = ContactSurface::of_lattice(&lattice).unwrap();
        let tree = surface.tree_at(0).unwrap();
        assert_eq!(tree.len(), 2 * 14);
        let side = |point: [f64; 3]| {
            let point = Point3::from(point);
            tree.closest(&point, f64::MAX, |_| true).unwrap().is_inside(&point)
        };
        assert!(side([0.5, 0.4, 0.5]) && side([1.5, 1.6, 0.9]));
        assert!(!side([0.5, 1.1, 0.5]) && !side([1.5, 1.6, 1.1]) && !side([-0.1, 0.5, 0.5]));
    }

    #[test]
    fn samples_lie_on_the_surface_with_its_normals() {
        let lattice = Lattice::from_cells(&[[0, 0, 0]], 2.0, Point3::new(3.0, 0.0, 0.0), false).unwrap();
        let surface = ContactSurface::of_lattice(&lattice).unwrap();
        // Each corner, and points between corners on every edge and face.
        assert!(surface.sample_count() >= 8 + 12 + 6);
        for Sample { local, normal } in &surface.samples {
            let on = |a: usize| if local[a] == 0.0 || local[a] == 1.0 { 2.0 * local[a] - 1.0 } else { 0.0 };
            let expected = Vector3::new(on(0), on(1), on(2)).normalize();
            assert!((Vector3::from(*normal) - expected).norm() < 1e-6, "{local:?} {normal:?}");
        }
    }
}
