//! Samples: points of the visible surface on which contacts act, grouped by the lattice cell that moves them.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{Point3, Vector3};

use crate::lattice::{Embedding, Lattice};
use crate::mesh::Mesh;
use crate::simd::lanes::LANES;

/// Cells in a strip: consecutive ones, which lie side by side for the most part.
const STRIP: usize = 32;

/// Sample points embedded in lattice cells: which cells hold any, and where in each they lie.
#[derive(Clone, Debug)]
pub struct SampleCells {
    /// Rows of `vertices` at the corners of each cell that holds a sample.
    pub(crate) corners: Vec<[u32; 8]>,
    /// Where the blocks of each cell begin in `blocks`; one more than there are cells.
    first: Vec<u32>,
    blocks: Vec<SampleBlock>,
    count: usize,
    /// Rows of `vertices` at the corners of each strip, a run of [`STRIP`] cells: tested before its cells.
    strips: Vec<Vec<u32>>,
    /// The lattice vertices that move samples, in increasing order.
    pub(crate) vertices: Vec<u32>,
    /// Their slots.
    pub(super) slots: Vec<u32>,
    /// Their inverse masses, in full cells.
    pub(super) mobilities: Vec<f32>,
}

/// Up to eight samples of a cell that are nearest to the same corner of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleBlock {
    /// The corner.
    pub(super) corner: u8,
    /// Places within the cell, [0, 1] along each axis; where there are fewer than eight, the last one again.
    pub(crate) places: [[f32; LANES]; 3],
    /// Share of each sample that counts at this corner: one over the number of corners that are as near; zero for the
    /// lanes that only fill the block.
    pub(super) shares: [f32; LANES],
}

impl SampleCells {
    /// Groups samples by cell: sample `i` lies in lattice cell `cells[i]` at `local[i]`.
    ///
    /// `corners` gives the eight lattice vertices of a cell, `slots` the slot of each lattice vertex. A sample outside
    /// its cell is moved to the nearest place in it. All vertices have equal mass.
    ///
    /// # Panics
    /// If `cells` and `local` differ in length.
    pub fn new(cells: &[u32], local: &[[f32; 3]], corners: impl Fn(u32) -> [u32; 8], slots: &[u32]) -> Self {
        assert_eq!(cells.len(), local.len(), "each sample needs a cell and a place in it");
        let local = |sample: u32| local[sample as usize].map(|x| x.clamp(0.0, 1.0));
        // Cell, corner and sample; the same sample for each of several corners that are as near.
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
                    let share = |lane| match lane < samples.len() {
                        true => 1.0 / nearest_corners(local(lane)).count() as f32,
                        false => 0.0,
                    };
                    SampleBlock {
                        corner: samples[0].1,
                        places: std::array::from_fn(|a| std::array::from_fn(|lane| local(lane)[a])),
                        shares: std::array::from_fn(share),
                    }
                }));
            }
        }
        first.push(blocks.len() as u32);
        blocks.shrink_to_fit();

        let vertices = sorted_once(&cell_corners);
        let mut row_of = vec![0; slots.len()];
        (0u32..).zip(&vertices).for_each(|(row, &vertex)| row_of[vertex as usize] = row);
        for corner in cell_corners.iter_mut().flatten() {
            *corner = row_of[*corner as usize];
        }
        Self {
            strips: cell_corners.chunks(STRIP).map(sorted_once).collect(),
            slots: vertices.iter().map(|&v| slots[v as usize]).collect(),
            mobilities: vec![1.0; vertices.len()],
            count: cells.len(),
            corners: cell_corners,
            first,
            blocks,
            vertices,
        }
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
        Self::new(&cells, &local, |cell| lattice.cell_corners(cell), slots).with_masses(lattice)
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
        Self::new(&cells, &local, |cell| lattice.cell_corners(cell), slots).with_masses(lattice)
    }

    fn with_masses(mut self, lattice: &Lattice) -> Self {
        let mobility = |&vertex: &u32| 8.0 / f32::from(lattice.occupied_cells()[vertex as usize]);
        self.mobilities = self.vertices.iter().map(mobility).collect();
        self
    }

    /// Number of samples.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let cells = size_of_val(&*self.corners) + size_of_val(&*self.first) + size_of_val(&*self.blocks);
        let strips: usize = self.strips.iter().map(|rows| size_of_val(rows) + size_of_val(&**rows)).sum();
        let vertices = [&self.vertices, &self.slots].map(|list| size_of_val(&**list)).iter().sum::<usize>();
        cells + strips + vertices + size_of_val(&*self.mobilities)
    }

    /// The strips: rows of the vertices at their corners, and their cells.
    pub(crate) fn strips(&self) -> impl Iterator<Item = (&[u32], Range<usize>)> {
        let cells = (0..self.corners.len()).step_by(STRIP);
        let cells = cells.map(|first| first..(first + STRIP).min(self.corners.len()));
        self.strips.iter().map(Vec::as_slice).zip(cells)
    }

    /// The samples of one cell.
    pub(crate) fn of_cell(&self, cell: usize) -> &[SampleBlock] {
        &self.blocks[self.first[cell] as usize..self.first[cell + 1] as usize]
    }
}

/// The corners of a cell that are nearest to a place in it: one, or more that are as near.
fn nearest_corners(local: [f32; 3]) -> impl Iterator<Item = u8> {
    let nearest = move |corner: u8| {
        (0..3).all(|a| if corner >> a & 1 == 1 { local[a] >= 0.5 } else { local[a] <= 0.5 })
    };
    (0..8).filter(move |&corner| nearest(corner))
}

/// The vertices of some cells in increasing order, each once.
fn sorted_once(corners: &[[u32; 8]]) -> Vec<u32> {
    let mut vertices: Vec<u32> = corners.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.shrink_to_fit();
    vertices
}

/// Points of a surface, dense enough to detect contacts of a coarse face: its welded vertices, and on edges and
/// triangles longer than `spacing` further points, no more than `spacing` apart along and across.
///
/// `weld` maps each vertex to the one that stands for its place; vertices of no triangle are left out. The
/// order is fixed: vertices, points on edges, points within triangles. `spacing` is a length > 0.
fn surface_points(
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

/// The point that lies `step` of `steps` on the way from `a` to `b`.
fn between(a: &Point3<f64>, b: &Point3<f64>, step: usize, steps: usize) -> Point3<f64> {
    a + (b - a) * (step as f64 / steps as f64)
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
}
