//! The surface of a body at rest, as contact between bodies needs it: a tree of its triangles, and samples of it.
//!
//! Rest coordinates are positions in the model's frame, in cells from the origin of the lattice: a point of the cell with
//! the index i and the local coordinates u has the rest coordinates i + u, however the body is deformed.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use super::super::surface_points::{MAX_SAMPLES, surface_points};
use crate::lattice::{Embedding, Lattice, trilinear_weights};
use crate::mesh::{Mesh, SurfaceTree};

/// Greatest distance of samples within a triangle, in cells. The samples of the other body lie as densely, and both
/// bodies are searched for the samples of the other.
const SPACING: f64 = 0.5;

/// Least weight of a lattice vertex that moves a sample noticeably.
const LEAST_WEIGHT: f32 = 0.02;

/// Surface of a body at rest.
#[derive(Debug)]
pub(crate) struct ContactSurface {
    /// The triangles, in rest coordinates.
    pub(super) tree: SurfaceTree,
    /// Whether the surface encloses a volume. Otherwise contacts act on both sides of it.
    pub(super) is_closed: bool,
    /// The samples, by cell.
    pub(super) samples: Vec<Sample>,
    /// The cells that contain samples.
    pub(super) cells: Vec<SampledCell>,
    /// Lattice vertices at the corners of each cell of the lattice.
    pub(super) corners: Vec<[u32; 8]>,
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
    /// Creates the surface of a mesh in its lattice, both in the model's frame. Returns `None` if no triangle has an area.
    pub(crate) fn of_mesh(mesh: &Mesh, lattice: &Lattice) -> Option<Self> {
        let (origin, scale) = (lattice.origin(), 1.0 / lattice.cell_size());
        let vertices: Vec<_> = mesh.vertices().iter().map(|p| Point3::from((p - origin) * scale)).collect();
        let weld = mesh.weld();
        let triangles: Vec<_> =
            mesh.triangles().iter().map(|triangle| triangle.map(|v| weld[v as usize])).collect();
        Self::new(lattice, &vertices, &triangles, mesh.is_closed())
    }

    /// Creates the surface of a bare lattice: the faces of its cells that no other cell shares.
    pub(crate) fn of_lattice(lattice: &Lattice) -> Option<Self> {
        let vertices: Vec<_> = lattice.indices().iter().map(|index| index.map(f64::from).into()).collect();
        let mut triangles = Vec::new();
        for (cell, index) in (0..).zip(lattice.cells()) {
            let corners = lattice.cell_corners(cell);
            for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
                let mut neighbor = *index;
                neighbor[axis] += 2 * side - 1;
                if lattice.cell_at(neighbor).is_none() {
                    let [a, b, c, d] = outward_face(axis, side == 1).map(|corner| corners[corner]);
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        Self::new(lattice, &vertices, &triangles, true)
    }

    fn new(
        lattice: &Lattice,
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        is_closed: bool,
    ) -> Option<Self> {
        let tree = SurfaceTree::new(vertices, triangles.iter().copied())?;
        let own: Vec<u32> = (0..vertices.len() as u32).collect();
        let points = surface_points(vertices, triangles, &own, SPACING, MAX_SAMPLES * lattice.len());
        let in_model: Vec<_> =
            points.iter().map(|p| lattice.origin() + p.coords * lattice.cell_size()).collect();
        let embedding = Embedding::new(lattice, &in_model);
        let mut order: Vec<(u32, u32)> = (0..points.len()).map(|i| (embedding.cell(i), i as u32)).collect();
        order.sort_unstable();
        let sample = |&(_, point): &(u32, u32)| {
            let closest = tree.closest(&points[point as usize], f64::MAX, |_| true);
            let normal = closest.map_or_else(Vector3::x, |closest| closest.normal);
            let local = embedding.local(point as usize).map(|x| x.clamp(0.0, 1.0));
            Sample { local, normal: normal.map(|x| x as f32).into() }
        };
        let samples = order.iter().map(sample).collect();
        let mut cells = Vec::new();
        let mut start = 0;
        for group in order.chunk_by(|a, b| a.0 == b.0) {
            let end = start + group.len() as u32;
            cells.push(SampledCell { cell: group[0].0, samples: start..end });
            start = end;
        }
        let corners = (0..lattice.cells().len() as u32).map(|cell| lattice.cell_corners(cell)).collect();
        Some(Self { tree, is_closed, samples, cells, corners })
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
        let lists = size_of_val(&*self.samples) + size_of_val(&*self.cells) + size_of_val(&*self.corners);
        self.tree.bytes() + lists
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
        assert_eq!(surface.tree.len(), 2 * 14);
        let side = |point: [f64; 3]| {
            let point = Point3::from(point);
            surface.tree.closest(&point, f64::MAX, |_| true).unwrap().is_inside(&point)
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
