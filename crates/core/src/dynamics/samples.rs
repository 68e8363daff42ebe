//! Points of the visible surface on which contacts act, grouped by the lattice cell that moves them.

use std::collections::BTreeMap;
use std::ops::{Add, Mul, Sub};

use nalgebra::{Point3, Vector3};

use crate::{Embedding, Lattice, Mesh};

/// Points of a surface, dense enough that a coarse face is felt: its welded vertices, and on edges and in
/// triangles longer than `spacing` further ones, no more than `spacing` apart along and across.
///
/// `weld` maps each vertex to the one that stands for its place; vertices of no triangle are left out. The
/// order is fixed: vertices, points on edges, points within triangles. `spacing` is a length > 0.
pub fn surface_points(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    weld: &[u32],
    spacing: f64,
) -> Vec<Point3<f64>> {
    let welded = || triangles.iter().map(|t| t.map(|v| weld[v as usize]));
    let mut used = vec![false; vertices.len()];
    welded().flatten().for_each(|v| used[v as usize] = true);
    let mut points: Vec<_> = vertices.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p).collect();

    let place = |v: u32| vertices[v as usize];
    let mut long_edges = BTreeMap::new();
    for [a, b, c] in welded() {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let steps = steps_of((place(p) - place(q)).norm(), spacing);
            if steps > 1 {
                long_edges.insert((p.min(q), p.max(q)), steps);
            }
        }
    }
    for ((p, q), steps) in long_edges {
        points.extend((1..steps).map(|k| between(&place(p), &place(q), k, steps)));
    }
    for [a, b, c] in welded() {
        fill_triangle([place(a), place(b), place(c)], spacing, &mut points);
    }
    points
}

/// Points strictly within a triangle: on lines parallel to its longest edge, `spacing` or less apart, and so
/// far apart on each line. A sliver gets one short row of points and not a square of them.
fn fill_triangle(corners: [Point3<f64>; 3], spacing: f64, points: &mut Vec<Point3<f64>>) {
    let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm();
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [a, b, top] = [corners[longest], corners[(longest + 1) % 3], corners[(longest + 2) % 3]];
    let base: Vector3<f64> = b - a;
    if base.norm() <= spacing {
        return;
    }
    let height = base.cross(&(top - a)).norm() / base.norm();
    let rows = steps_of(height, spacing);
    for row in 1..rows {
        let (left, right) = (between(&a, &top, row, rows), between(&b, &top, row, rows));
        let steps = steps_of((right - left).norm(), spacing);
        points.extend((1..steps).map(|k| between(&left, &right, k, steps)));
    }
}

/// The least number of equal steps of at most `spacing` that cover `length`; at least 1.
fn steps_of(length: f64, spacing: f64) -> usize {
    (length / spacing).ceil().max(1.0) as usize
}

fn between(a: &Point3<f64>, b: &Point3<f64>, step: usize, steps: usize) -> Point3<f64> {
    a + (b - a) * (step as f64 / steps as f64)
}

/// Cells in a strip: consecutive ones, which lie side by side for the most part.
pub(super) const STRIP: usize = 32;

/// Sample points embedded in lattice cells: which cells hold any, and where in each they lie.
#[derive(Clone, Debug)]
pub struct SampleCells {
    /// Rows of `vertices` at the corners of each cell that holds a sample.
    pub(super) corners: Vec<[u32; 8]>,
    /// Where the samples of each cell begin in `local`; one more than there are cells.
    pub(super) first: Vec<u32>,
    /// Place of each sample within its cell, [0, 1] along each axis.
    pub(super) local: Vec<[f32; 3]>,
    /// Rows of `vertices` at the corners of each strip, a run of [`STRIP`] cells: what is tested before its cells.
    pub(super) strips: Vec<Vec<u32>>,
    /// The lattice vertices that move samples, in increasing order.
    pub(super) vertices: Vec<u32>,
    /// Their slots.
    pub(super) slots: Vec<u32>,
}

impl SampleCells {
    /// Groups samples by cell: sample `i` lies in lattice cell `cells[i]` at `local[i]`.
    ///
    /// `corners` gives the eight lattice vertices of a cell, `slots` the slot of each lattice vertex. Within a
    /// cell samples keep their order; one outside its cell is taken to the nearest place in it.
    ///
    /// # Panics
    /// If `cells` and `local` differ in length.
    pub fn new(cells: &[u32], local: &[[f32; 3]], corners: impl Fn(u32) -> [u32; 8], slots: &[u32]) -> Self {
        assert_eq!(cells.len(), local.len(), "each sample needs a cell and a place in it");
        let mut order: Vec<u32> = (0..cells.len() as u32).collect();
        order.sort_by_key(|&i| cells[i as usize]);

        let mut grouped = Self {
            corners: Vec::new(),
            first: Vec::new(),
            local: Vec::with_capacity(local.len()),
            strips: Vec::new(),
            vertices: Vec::new(),
            slots: Vec::new(),
        };
        for group in order.chunk_by(|&a, &b| cells[a as usize] == cells[b as usize]) {
            grouped.corners.push(corners(cells[group[0] as usize]));
            grouped.first.push(grouped.local.len() as u32);
            grouped.local.extend(group.iter().map(|&i| local[i as usize].map(|x| x.clamp(0.0, 1.0))));
        }
        grouped.first.push(grouped.local.len() as u32);

        let vertices = sorted_once(&grouped.corners);
        let mut row_of = vec![0; slots.len()];
        (0u32..).zip(&vertices).for_each(|(row, &vertex)| row_of[vertex as usize] = row);
        for corner in grouped.corners.iter_mut().flatten() {
            *corner = row_of[*corner as usize];
        }
        grouped.strips = grouped.corners.chunks(STRIP).map(sorted_once).collect();
        grouped.slots = vertices.iter().map(|&v| slots[v as usize]).collect();
        grouped.vertices = vertices;
        grouped
    }

    /// The samples of a mesh in its lattice, both in the model frame: [`surface_points`] no farther apart than a
    /// cell.
    ///
    /// `slots` has the slot of each lattice vertex.
    pub fn of_mesh(mesh: &Mesh, lattice: &Lattice, slots: &[u32]) -> Self {
        let points = surface_points(mesh.vertices(), mesh.triangles(), mesh.weld(), lattice.cell_size());
        let embedding = Embedding::new(lattice, &points);
        let (cells, local): (Vec<_>, Vec<_>) =
            (0..embedding.len()).map(|i| (embedding.cell(i), embedding.local(i))).unzip();
        Self::new(&cells, &local, |cell| lattice.cell_corners(cell), slots)
    }

    /// The samples of a bare lattice: its boundary vertices, those with fewer than eight occupied cells.
    ///
    /// `slots` has the slot of each lattice vertex.
    pub fn of_lattice(lattice: &Lattice, slots: &[u32]) -> Self {
        let (mut cells, mut local) = (Vec::new(), Vec::new());
        let boundary =
            lattice.occupied_cells().iter().zip(lattice.indices()).filter(|(count, _)| **count < 8);
        for (_, index) in boundary {
            // Any cell at the vertex will do: all give it the weight 1.
            let found = (0..8).find_map(|k| {
                let offset: [i32; 3] = std::array::from_fn(|a| k >> a & 1);
                let cell = lattice.cell_at(std::array::from_fn(|a| index[a] - offset[a]))?;
                Some((cell, offset.map(|o| o as f32)))
            });
            if let Some((cell, place)) = found {
                cells.push(cell);
                local.push(place);
            }
        }
        Self::new(&cells, &local, |cell| lattice.cell_corners(cell), slots)
    }

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.local.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.local.is_empty()
    }

    /// Places within the cell of the samples of one cell.
    pub(super) fn of_cell(&self, cell: usize) -> &[[f32; 3]] {
        &self.local[self.first[cell] as usize..self.first[cell + 1] as usize]
    }
}

/// The vertices of some cells in increasing order, each once.
fn sorted_once(corners: &[[u32; 8]]) -> Vec<u32> {
    let mut vertices: Vec<u32> = corners.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// Trilinear weights of the corners of a cell; corner k lies at (k & 1, k >> 1 & 1, k >> 2 & 1).
#[inline]
pub(super) fn trilinear(local: [f32; 3]) -> [f64; 8] {
    let t = local.map(f64::from);
    std::array::from_fn(|k| (0..3).map(|a| if k >> a & 1 == 1 { t[a] } else { 1.0 - t[a] }).product())
}

/// The trilinear map of values at the corners of a cell as a polynomial of the place in it: half the work of
/// weights where a cell has many samples. Coefficients of 1, x, y, xy, z, xz, yz, xyz.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellMap<T>(pub(super) [T; 8]);

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> CellMap<T> {
    /// The map with these values at the corners.
    pub(super) fn new(mut terms: [T; 8]) -> Self {
        // Differences along x, then y, then z: of the corners that have the bit set to those that do not.
        for bit in [1, 2, 4] {
            for k in (0..8).filter(|k| k & bit != 0) {
                terms[k] = terms[k] - terms[k - bit];
            }
        }
        Self(terms)
    }

    /// The value at a place within the cell.
    #[inline]
    pub(super) fn at(&self, local: [f32; 3]) -> T {
        let [x, y, z] = local.map(f64::from);
        let t = &self.0;
        let lower = (t[0] + t[1] * x) + (t[2] + t[3] * x) * y;
        let upper = (t[4] + t[5] * x) + (t[6] + t[7] * x) * y;
        lower + upper * z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_triangles_give_their_welded_vertices_alone() {
        let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [9.0; 3]].map(Point3::from);
        // Vertex 3 repeats vertex 0 at a seam, vertex 4 belongs to no face.
        let points = surface_points(&vertices, &[[0, 1, 2], [3, 2, 1]], &[0, 1, 2, 0, 4], 1.5);
        assert_eq!(points, vertices[..3]);
    }

    #[test]
    fn no_place_of_a_coarse_face_is_farther_than_the_spacing() {
        let spacing = 0.3;
        for corners in [
            [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 4.0, 0.5]],
            [[0.0, 0.0, 0.0], [9.0, 0.1, 0.0], [4.0, 0.2, 0.0]],
            [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 1.0, 0.0]],
        ] {
            let corners = corners.map(Point3::from);
            let points = surface_points(&corners, &[[0, 1, 2]], &[0, 1, 2], spacing);
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let (u, v) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
                    let p = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
                    let near = points.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
                    assert!(near <= spacing, "{p} is {near} from every sample");
                }
            }
            let mut sorted: Vec<[f64; 3]> = points.iter().map(|&p| p.into()).collect();
            sorted.sort_by(|a, b| a.partial_cmp(b).unwrap());
            sorted.dedup();
            assert_eq!(sorted.len(), points.len(), "each place once");
        }
    }

    #[test]
    fn a_sliver_costs_a_row_and_not_a_square() {
        let corners = [[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [500.0, 1e-3, 0.0]].map(Point3::from);
        assert!(surface_points(&corners, &[[0, 1, 2]], &[0, 1, 2], 1.0).len() < 2100);
    }

    #[test]
    fn weights_are_those_of_the_corners() {
        let mut expected = [0.0; 8];
        expected[5] = 1.0;
        assert_eq!(trilinear([1.0, 0.0, 1.0]), expected);
        assert_eq!(trilinear([0.5; 3]), [0.125; 8]);
        let corners = [5.0, -1.0, 2.0, 0.5, 8.0, 3.0, -4.0, 1.5].map(|c: f32| [c, c * c, 1.0 - c]);
        for local in [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.875], [1.0, 0.0, 0.375]] {
            let place = CellMap::new(corners.map(|c| Vector3::from(c.map(f64::from)))).at(local);
            for a in 0..3 {
                let sum: f64 = trilinear(local).iter().zip(&corners).map(|(w, c)| w * f64::from(c[a])).sum();
                assert!((place[a] - sum).abs() < 1e-13);
            }
        }
    }
}
