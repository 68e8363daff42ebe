//! Samples: points of the body's surface on which contacts act, grouped by lattice cell.
//!
//! A *row* is an index into `SampleCells::vertices`, the lattice vertices that move samples. A *slot* is the
//! index of a lattice vertex in the storage of the state; see `simd::lanes`.

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

use nalgebra::{Point3, Vector3};

use crate::lattice::{Embedding, Lattice};
use crate::mesh::Mesh;
use crate::simd::lanes::LANES;

/// Number of cells in a strip. A strip consists of consecutive cells, most of which are adjacent.
const STRIP: usize = 32;

/// Maximum number of samples per lattice vertex, beside the mesh vertices. Only surfaces that overlap themselves
/// many times have more: a plane through a cell has about two.
const MAX_SAMPLES: usize = 64;

/// Sample points embedded in lattice cells.
#[derive(Clone, Debug)]
pub struct SampleCells {
    /// Rows of the corners of each cell that contains a sample.
    pub(crate) corners: Vec<[u32; 8]>,
    /// Index in `blocks` of the first block of each cell, then the number of blocks (CSR offsets).
    first: Vec<u32>,
    /// Blocks of samples, in the order of the cells.
    blocks: Vec<SampleBlock>,
    /// Number of samples.
    count: usize,
    /// Rows of the corners of each strip of [`STRIP`] cells. Detection tests a strip before its cells.
    strips: Vec<Vec<u32>>,
    /// Lattice vertices at the corners of the cells, in increasing order.
    pub(crate) vertices: Vec<u32>,
    /// Slot of each of `vertices`.
    pub(super) slots: Vec<u32>,
    /// Inverse mass of each of `vertices`, in units of 1 / (mass of a full cell).
    pub(super) mobilities: Vec<f32>,
}

/// Up to eight samples of one cell that have the same nearest corner, one per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleBlock {
    /// Nearest corner, 0..8.
    pub(super) corner: u8,
    /// Positions within the cell: x, y and z of each sample, in [0, 1]. Padding lanes repeat the last sample.
    pub(crate) positions: [[f32; LANES]; 3],
    /// Fraction of each sample that counts at this corner: 1/k for a sample with k equally near corners,
    /// which is in a block of each of these corners; 0 for padding lanes.
    pub(super) fractions: [f32; LANES],
}

impl SampleCells {
    /// Groups samples by cell: sample `i` lies in lattice cell `cells[i]` at `local[i]`.
    ///
    /// `corners` returns the eight lattice vertices of a cell, and `slots` has the slot of each lattice
    /// vertex. A sample outside its cell is clamped to the cell. Every vertex gets the mass of a full cell.
    ///
    /// # Panics
    /// If `cells` and `local` differ in length.
    pub fn new(cells: &[u32], local: &[[f32; 3]], corners: impl Fn(u32) -> [u32; 8], slots: &[u32]) -> Self {
        assert_eq!(cells.len(), local.len(), "`cells` and `local` differ in length");
        let local = |sample: u32| local[sample as usize].map(|x| x.clamp(0.0, 1.0));
        // Entries of cell, corner and sample: one for each nearest corner of a sample.
        let mut order: Vec<(u32, u8, u32)> = Vec::with_capacity(cells.len());
        for (sample, &cell) in (0u32..).zip(cells) {
            order.extend(nearest_corners(local(sample)).map(|corner| (cell, corner, sample)));
        }
        order.sort_unstable();

        let (mut cell_corners, mut first, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
        for cell in order.chunk_by(|a, b| a.0 == b.0) {
            cell_corners.push(corners(cell[0].0));
            first.push(blocks.len() as u32);
            for corner in cell.chunk_by(|a, b| a.1 == b.1) {
                blocks.extend(corner.chunks(LANES).map(|samples| {
                    let local = |lane: usize| local(samples[lane.min(samples.len() - 1)].2);
                    let fraction = |lane| match lane < samples.len() {
                        true => 1.0 / nearest_corners(local(lane)).count() as f32,
                        false => 0.0,
                    };
                    SampleBlock {
                        corner: samples[0].1,
                        positions: std::array::from_fn(|a| std::array::from_fn(|lane| local(lane)[a])),
                        fractions: std::array::from_fn(fraction),
                    }
                }));
            }
        }
        first.push(blocks.len() as u32);
        blocks.shrink_to_fit();

        let vertices = sorted_unique(&cell_corners);
        let mut row_of = vec![0; slots.len()];
        (0u32..).zip(&vertices).for_each(|(row, &vertex)| row_of[vertex as usize] = row);
        for corner in cell_corners.iter_mut().flatten() {
            *corner = row_of[*corner as usize];
        }
        Self {
            strips: cell_corners.chunks(STRIP).map(sorted_unique).collect(),
            slots: vertices.iter().map(|&v| slots[v as usize]).collect(),
            mobilities: vec![1.0; vertices.len()],
            count: cells.len(),
            corners: cell_corners,
            first,
            blocks,
            vertices,
        }
    }

    /// Creates the samples of a mesh in its lattice: points of the surface that are at most one cell apart, or
    /// farther if that gives more than [`MAX_SAMPLES`].
    ///
    /// Mesh and lattice are in the model frame. `slots` has the slot of each lattice vertex.
    pub fn of_mesh(mesh: &Mesh, lattice: &Lattice, slots: &[u32]) -> Self {
        let points = surface_points(
            mesh.vertices(),
            mesh.triangles(),
            mesh.weld(),
            lattice.cell_size(),
            MAX_SAMPLES * lattice.len(),
        );
        let embedding = Embedding::new(lattice, &points);
        let (cells, local): (Vec<_>, Vec<_>) =
            (0..embedding.len()).map(|i| (embedding.cell(i), embedding.local(i))).unzip();
        Self::new(&cells, &local, |cell| lattice.cell_corners(cell), slots).with_masses(lattice)
    }

    /// Creates the samples of a bare lattice (without a mesh): its vertices with fewer than eight occupied
    /// cells, which lie on the surface of the lattice.
    ///
    /// `slots` has the slot of each lattice vertex.
    pub fn of_lattice(lattice: &Lattice, slots: &[u32]) -> Self {
        let (mut cells, mut local) = (Vec::new(), Vec::new());
        let boundary =
            lattice.occupied_cells().iter().zip(lattice.indices()).filter(|(count, _)| **count < 8);
        for (_, index) in boundary {
            // Any of the vertex's occupied cells serves, because the vertex has the weight 1 in each of them.
            let found = (0..8).find_map(|k| {
                let offset: [i32; 3] = std::array::from_fn(|a| k >> a & 1);
                let cell = lattice.cell_at(std::array::from_fn(|a| index[a] - offset[a]))?;
                Some((cell, offset.map(|o| o as f32)))
            });
            if let Some((cell, position)) = found {
                cells.push(cell);
                local.push(position);
            }
        }
        Self::new(&cells, &local, |cell| lattice.cell_corners(cell), slots).with_masses(lattice)
    }

    /// Sets the inverse masses. A vertex has an eighth of the mass of each of its occupied cells.
    fn with_masses(mut self, lattice: &Lattice) -> Self {
        let mobility = |&vertex: &u32| 8.0 / f32::from(lattice.occupied_cells()[vertex as usize]);
        self.mobilities = self.vertices.iter().map(mobility).collect();
        self
    }

    /// Returns the number of samples.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the memory of the samples in bytes.
    pub(super) fn bytes(&self) -> usize {
        let cells = size_of_val(&*self.corners) + size_of_val(&*self.first) + size_of_val(&*self.blocks);
        let strips: usize = self.strips.iter().map(|rows| size_of_val(rows) + size_of_val(&**rows)).sum();
        let vertices = [&self.vertices, &self.slots].map(|list| size_of_val(&**list)).iter().sum::<usize>();
        cells + strips + vertices + size_of_val(&*self.mobilities)
    }

    /// Iterates over the strips: the rows of the corners of the strip's cells, and the range of these cells.
    pub(crate) fn strips(&self) -> impl Iterator<Item = (&[u32], Range<usize>)> {
        let cells = (0..self.corners.len()).step_by(STRIP);
        let cells = cells.map(|first| first..(first + STRIP).min(self.corners.len()));
        self.strips.iter().map(Vec::as_slice).zip(cells)
    }

    /// Returns the sample blocks of one cell.
    pub(crate) fn cell_blocks(&self, cell: usize) -> &[SampleBlock] {
        &self.blocks[self.first[cell] as usize..self.first[cell + 1] as usize]
    }
}

/// Returns the corners of a cell that are nearest to a position in the cell: one corner, or several at equal
/// distance.
fn nearest_corners(local: [f32; 3]) -> impl Iterator<Item = u8> {
    let nearest = move |corner: u8| {
        (0..3).all(|a| if corner >> a & 1 == 1 { local[a] >= 0.5 } else { local[a] <= 0.5 })
    };
    (0..8).filter(move |&corner| nearest(corner))
}

/// Returns the corners of all cells in increasing order, without duplicates.
fn sorted_unique(corners: &[[u32; 8]]) -> Vec<u32> {
    let mut vertices: Vec<u32> = corners.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.shrink_to_fit();
    vertices
}

/// Returns points of a surface that are dense enough to detect contacts of large faces.
///
/// The points are, in this order: the welded vertices that triangles use, points on the edges longer than
/// `spacing`, and points within the triangles with such an edge. They are at most `spacing` apart along each
/// edge, and within a triangle along and across its longest edge. If these are more than `max_points` points
/// beside the vertices, the spacing is doubled until they are not. Of triangles with the same corners only the
/// first one is filled.
///
/// * `weld`: for each vertex, the first vertex at the same position.
/// * `spacing`: a length > 0.
fn surface_points(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    weld: &[u32],
    mut spacing: f64,
    max_points: usize,
) -> Vec<Point3<f64>> {
    let triangles = distinct(triangles, weld);
    let mut used = vec![false; vertices.len()];
    triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut points: Vec<_> = vertices.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p).collect();
    let vertex_count = points.len();
    while !add_points(vertices, &triangles, spacing, vertex_count + max_points, &mut points) {
        points.truncate(vertex_count);
        spacing *= 2.0;
    }
    points
}

/// Returns the welded triangles, without those whose corners are those of an earlier one.
fn distinct(triangles: &[[u32; 3]], weld: &[u32]) -> Vec<[u32; 3]> {
    let welded = triangles.iter().map(|t| t.map(|v| weld[v as usize]));
    let mut corners = HashSet::new();
    let is_first = |triangle: &[u32; 3]| {
        let mut sorted = *triangle;
        sorted.sort_unstable();
        corners.insert(sorted)
    };
    welded.filter(is_first).collect()
}

/// Adds the points on long edges and within large triangles. Returns false once there are more than `limit`.
fn add_points(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    spacing: f64,
    limit: usize,
    points: &mut Vec<Point3<f64>>,
) -> bool {
    let position = |v: u32| vertices[v as usize];
    let mut long_edges = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let steps = step_count((position(p) - position(q)).norm(), spacing);
            if steps > 1 {
                long_edges.insert((p.min(q), p.max(q)), steps);
            }
        }
    }
    for ((p, q), steps) in long_edges {
        if points.len() + steps - 1 > limit {
            return false;
        }
        points.extend((1..steps).map(|k| between(&position(p), &position(q), k, steps)));
    }
    triangles.iter().all(|triangle| fill_triangle(triangle.map(position), spacing, limit, points))
}

/// Adds points strictly inside a triangle, on lines parallel to its longest edge.
///
/// The points are at most `spacing` apart along the lines and across them. The number of points in a sliver
/// is proportional to its length, not to the square of its length. Returns false once there are more than
/// `limit` points.
fn fill_triangle(
    corners: [Point3<f64>; 3],
    spacing: f64,
    limit: usize,
    points: &mut Vec<Point3<f64>>,
) -> bool {
    let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm();
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [a, b, top] = [corners[longest], corners[(longest + 1) % 3], corners[(longest + 2) % 3]];
    let base: Vector3<f64> = b - a;
    if base.norm() <= spacing {
        return true;
    }
    let height = base.cross(&(top - a)).norm() / base.norm();
    let lines = step_count(height, spacing);
    for line in 1..lines {
        let (left, right) = (between(&a, &top, line, lines), between(&b, &top, line, lines));
        let steps = step_count((right - left).norm(), spacing);
        if points.len() + steps - 1 > limit {
            return false;
        }
        points.extend((1..steps).map(|k| between(&left, &right, k, steps)));
    }
    true
}

/// Returns the smallest number of equal steps of at most `spacing` that cover `length`; at least 1.
fn step_count(length: f64, spacing: f64) -> usize {
    (length / spacing).ceil().max(1.0) as usize
}

/// Returns the point at the fraction `step / steps` of the segment from `a` to `b`.
fn between(a: &Point3<f64>, b: &Point3<f64>, step: usize, steps: usize) -> Point3<f64> {
    a + (b - a) * (step as f64 / steps as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_triangles_are_sampled_at_their_welded_vertices_only() {
        let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [9.0; 3]].map(Point3::from);
        // Vertex 3 duplicates vertex 0 at a seam; vertex 4 belongs to no face.
        let points = surface_points(&vertices, &[[0, 1, 2], [3, 2, 1]], &[0, 1, 2, 0, 4], 1.5, 1000);
        assert_eq!(points, vertices[..3]);
    }

    #[test]
    fn every_point_of_a_large_face_has_a_sample_within_the_spacing() {
        let spacing = 0.3;
        for corners in [
            [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 4.0, 0.5]],
            [[0.0, 0.0, 0.0], [9.0, 0.1, 0.0], [4.0, 0.2, 0.0]],
            [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 1.0, 0.0]],
        ] {
            let corners = corners.map(Point3::from);
            let points = surface_points(&corners, &[[0, 1, 2]], &[0, 1, 2], spacing, 10_000);
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let (u, v) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
                    let p = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
                    let distance = points.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
                    assert!(distance <= spacing, "{p} is {distance} from the nearest sample");
                }
            }
            let mut sorted: Vec<[f64; 3]> = points.iter().map(|&p| p.into()).collect();
            sorted.sort_by(|a, b| a.partial_cmp(b).unwrap());
            sorted.dedup();
            assert_eq!(sorted.len(), points.len(), "duplicate samples");
        }
    }

    #[test]
    fn sample_count_of_a_sliver_is_linear_in_its_length() {
        let corners = [[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [500.0, 1e-3, 0.0]].map(Point3::from);
        assert!(surface_points(&corners, &[[0, 1, 2]], &[0, 1, 2], 1.0, 10_000).len() < 2100);
    }

    #[test]
    fn equal_triangles_are_sampled_once_and_the_number_of_samples_is_limited() {
        let corners = [[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]].map(Point3::from);
        let sample = |faces: &[[u32; 3]], limit| surface_points(&corners, faces, &[0, 1, 2], 0.5, limit);
        let one = sample(&[[0, 1, 2]], 10_000);
        assert_eq!(sample(&[[0, 1, 2], [1, 2, 0], [2, 1, 0]], 10_000), one);
        let few = sample(&[[0, 1, 2]], 100);
        assert!(few.len() <= 103 && one.len() > 103, "{} {}", few.len(), one.len());
    }
}
