//! The surface of a body at rest, as contact between bodies needs it: trees of its triangles, and samples of it.
//! For rest coordinates see [`RestSurface::at_rest`].

use std::ops::Range;
use std::sync::OnceLock;

use nalgebra::{Point3, Vector3};

use super::joined_cells::{JoinedCells, TouchableCells, are_of_two_parts};
use super::rest_distance::RestDistances;
use crate::contact::sampler::{PartSurface, RestSurface};
use crate::lattice::{Lattice, trilinear_weights};
use crate::mesh::SurfaceTree;

/// Greatest distance of samples within a triangle, in cells. The samples of the other body lie as densely, and both
/// bodies are searched for the samples of the other.
const SPACING: f64 = 0.5;

/// Least weight of a lattice vertex that moves a sample noticeably.
const LEAST_WEIGHT: f32 = 0.02;

/// Number of [`side`]s of normals.
pub(crate) const SIDES: usize = 6;

/// Surface of a body at rest.
#[derive(Debug)]
pub(crate) struct ContactSurface {
    /// The triangles of each part, in rest coordinates; `None` if they have no area. Both sides of a crack have the
    /// same rest coordinates.
    trees: Vec<Option<SurfaceTree>>,
    /// The part of each cell; empty if there is one part.
    parts: Vec<u32>,
    /// Whether the surface encloses a volume. Otherwise contacts act on both sides of it, but where it broke.
    pub(super) is_closed: bool,
    /// The samples, by cell.
    pub(super) samples: Vec<Sample>,
    /// The cells that contain samples.
    pub(super) cells: Vec<SampledCell>,
    /// Signed distances at rest in `cells`; empty until a sample is searched.
    distances: OnceLock<RestDistances>,
    /// Empty until the body is searched for contact with itself.
    joined: OnceLock<JoinedCells>,
    /// Lattice vertices at the corners of each cell of the lattice.
    pub(super) corners: Vec<[u32; 8]>,
    /// The sides of each cell that were joined to another part, one bit for each of the sides at -x, +x, -y, +y, -z,
    /// +z; empty if there is one part. Some of the smooth surface of a crack lies beyond them.
    pub(super) continued_sides: Vec<u8>,
}

/// A point of the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Local coordinates in its cell, in [0, 1]; at the smooth surface of a crack in [-1, 2].
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
    /// Creates the surface of a body. Returns `None` if no triangle has an area.
    pub(crate) fn new(surface: RestSurface<'_>) -> Option<Self> {
        let surface = surface.at_rest();
        let lattice = surface.parts.lattice;
        let parts = surface.of_parts();
        let tree = |part: &PartSurface| SurfaceTree::new(&part.vertices, part.triangles.iter().copied());
        let trees: Vec<_> = parts.iter().map(tree).collect();
        if trees.iter().all(Option::is_none) {
            return None;
        }
        let mut found = surface.sample(&parts, SPACING);
        found.sort_by_key(|sample| sample.cell);
        let of_cell = surface.parts.of_cells();
        let continued_sides = continued_sides(lattice, &of_cell);
        let (samples, cells) = (Vec::with_capacity(found.len()), Vec::new());
        let (is_closed, corners) = (surface.is_closed, lattice.corner_table().into_owned());
        let (distances, joined) = (OnceLock::new(), OnceLock::new());
        let mut surface = Self {
            trees,
            parts: of_cell,
            is_closed,
            samples,
            cells,
            distances,
            joined,
            corners,
            continued_sides,
        };
        for group in found.chunk_by(|a, b| a.cell == b.cell) {
            let (cell, start) = (group[0].cell, surface.samples.len() as u32);
            for sample in group {
                let tree = surface.tree_at(cell);
                let closest = tree.and_then(|tree| tree.closest(&sample.point, f64::MAX, |_| true));
                let normal = closest.map_or_else(Vector3::x, |closest| closest.normal).map(|x| x as f32);
                // The smooth surface of a crack lies outside the cells of its part.
                let local = sample.local.map(|u| u.clamp(-1.0, 2.0));
                surface.samples.push(Sample { local, normal: normal.into() });
            }
            surface.cells.push(SampledCell { cell, samples: start..surface.samples.len() as u32 });
        }
        Some(surface)
    }

    /// Returns a lower and an upper bound of the signed distance of a point at rest from the triangles `tree` of its cell:
    /// see [`RestDistances::bounds`]. They are infinite if the cell has no samples. `index`: grid index of the cell.
    pub(super) fn distance_bounds(
        &self,
        (cell, index): (u32, [i32; 3]),
        point: &Point3<f64>,
        tree: &SurfaceTree,
    ) -> [f64; 2] {
        let Ok(group) = self.cells.binary_search_by_key(&cell, |group| group.cell) else {
            return [f64::NEG_INFINITY, f64::INFINITY];
        };
        let distances = self.distances.get_or_init(|| RestDistances::new(self.cells.len()));
        distances.bounds((group, index), point, tree)
    }

    /// Returns the triangles of the part that contains a cell, in rest coordinates; `None` if they have no area.
    pub(super) fn tree_at(&self, cell: u32) -> Option<&SurfaceTree> {
        let part = self.parts.get(cell as usize).map_or(0, |part| *part as usize);
        self.trees[part].as_ref()
    }

    /// Returns the cells of the body that the `group`-th of `cells` can touch. `with_itself`: whether a part touches itself.
    pub(super) fn touchable_cells<'a>(
        &'a self,
        lattice: &'a Lattice,
        with_itself: bool,
        group: usize,
    ) -> TouchableCells<'a> {
        let create = || JoinedCells::new(lattice, self.cells.iter().map(|group| group.cell));
        let joined = with_itself.then(|| self.joined.get_or_init(create).of(group));
        TouchableCells { lattice, parts: &self.parts, cell: self.cells[group].cell, joined }
    }

    /// Returns whether two cells of the body are of different parts, which fit together where it broke.
    pub(super) fn are_of_two_parts(&self, cells: [u32; 2]) -> bool {
        are_of_two_parts(&self.parts, cells)
    }

    /// Returns whether two cells of the body are of different parts, and one of them was joined to another part.
    pub(super) fn are_at_crack(&self, cells: [u32; 2]) -> bool {
        self.are_of_two_parts(cells) && cells.iter().any(|&cell| self.continued_sides_of(cell) != 0)
    }

    /// Returns the sides of a cell that were joined to another part: see [`continued_sides`](Self::continued_sides).
    pub(super) fn continued_sides_of(&self, cell: u32) -> u8 {
        self.continued_sides.get(cell as usize).copied().unwrap_or(0)
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
    pub(in crate::contact) fn bytes(&self) -> usize {
        let Self { trees, parts, samples, cells, distances, joined, corners, continued_sides, .. } = self;
        let lists = size_of_val(&**samples) + size_of_val(&**cells) + size_of_val(&**corners);
        let of_parts = size_of_val(&**trees) + size_of_val(&**parts) + size_of_val(&**continued_sides);
        trees.iter().flatten().map(SurfaceTree::bytes).sum::<usize>()
            + distances.get().map_or(0, RestDistances::bytes)
            + joined.get().map_or(0, JoinedCells::bytes)
            + lists
            + of_parts
    }
}

/// Returns the side of a unit normal: its dominant axis, plus 3 if it is negative along it.
pub(crate) fn side(normal: &Vector3<f64>) -> usize {
    let axis = normal.iamax();
    axis + if normal[axis] < 0.0 { 3 } else { 0 }
}

/// Returns the sides of each cell that were joined to another part: see [`ContactSurface::continued_sides`].
/// `of_cell`: the part of each cell; empty if there is one part.
fn continued_sides(lattice: &Lattice, of_cell: &[u32]) -> Vec<u8> {
    let sides = |(cell, part): (u32, &u32)| {
        let is_other = |side: u8| {
            let beyond = lattice.cell_beyond(cell, side / 2, if side % 2 == 1 { 1 } else { -1 });
            beyond.is_some_and(|beyond| of_cell[beyond as usize] != *part)
        };
        (0..6).filter(|side| is_other(*side)).fold(0, |sides, side| sides | 1 << side)
    };
    (0..).zip(of_cell).map(sides).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn surface_of_a_lattice_is_closed_and_faces_outwards() {
        let lattice =
            Lattice::from_cells(&[[0, 0, 0], [1, 0, 0], [1, 1, 0]], 0.5, Point3::origin(), false).unwrap();
        let surface = ContactSurface::new(RestSurface::of_lattice(&lattice)).unwrap();
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
        let surface = ContactSurface::new(RestSurface::of_lattice(&lattice)).unwrap();
        // Each corner, and points between corners on every edge and face.
        assert!(surface.sample_count() >= 8 + 12 + 6);
        for Sample { local, normal } in &surface.samples {
            let on = |a: usize| if local[a] == 0.0 || local[a] == 1.0 { 2.0 * local[a] - 1.0 } else { 0.0 };
            let expected = Vector3::new(on(0), on(1), on(2)).normalize();
            assert!((Vector3::from(*normal) - expected).norm() < 1e-6, "{local:?} {normal:?}");
        }
    }
}
