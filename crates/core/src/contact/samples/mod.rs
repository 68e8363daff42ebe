//! Points of the visible surface on which contacts act, grouped by the lattice cell that moves them.

mod points;
mod trilinear;

use std::ops::Range;

pub use points::surface_points;
pub(in crate::contact) use trilinear::{corner_sums, monomials, value};

use crate::simd::lanes::LANES;
use crate::{Embedding, Lattice, Mesh};

/// Cells in a strip: consecutive ones, which lie side by side for the most part.
const STRIP: usize = 32;

/// Sample points embedded in lattice cells: which cells hold any, and where in each they lie.
#[derive(Clone, Debug)]
pub struct SampleCells {
    /// Rows of `vertices` at the corners of each cell that holds a sample.
    pub(super) corners: Vec<[u32; 8]>,
    /// Where the blocks of each cell begin in `blocks`; one more than there are cells.
    first: Vec<u32>,
    blocks: Vec<SampleBlock>,
    count: usize,
    /// Rows of `vertices` at the corners of each strip, a run of [`STRIP`] cells: what is tested before its cells.
    strips: Vec<Vec<u32>>,
    /// The lattice vertices that move samples, in increasing order.
    pub(super) vertices: Vec<u32>,
    /// Their slots.
    pub(super) slots: Vec<u32>,
    /// Their inverse masses, in full cells.
    pub(super) mobilities: Vec<f32>,
}

/// Up to eight samples of a cell that are nearest to the same corner of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleBlock {
    /// The corner.
    pub(super) corner: u8,
    /// Places within the cell, [0, 1] along each axis; where there are fewer than eight, the last one again.
    pub(super) places: [[f32; LANES]; 3],
    /// What of each sample counts here: all, an equal share of one that is as near to other corners, nothing of those
    /// that fill up the block.
    pub(super) shares: [f32; LANES],
}

impl SampleCells {
    /// Groups samples by cell: sample `i` lies in lattice cell `cells[i]` at `local[i]`.
    ///
    /// `corners` gives the eight lattice vertices of a cell, `slots` the slot of each lattice vertex. A
    /// sample outside its cell is taken to the nearest place in it. All vertices count as
    /// of equal mass.
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

        let mut grouped = Self {
            corners: Vec::new(),
            first: Vec::new(),
            blocks: Vec::new(),
            count: cells.len(),
            strips: Vec::new(),
            vertices: Vec::new(),
            slots: Vec::new(),
            mobilities: Vec::new(),
        };
        for group in order.chunk_by(|a, b| a.0 == b.0) {
            grouped.corners.push(corners(group[0].0));
            grouped.first.push(grouped.blocks.len() as u32);
            for patch in group.chunk_by(|a, b| a.1 == b.1) {
                grouped.blocks.extend(patch.chunks(LANES).map(|samples| {
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
        grouped.first.push(grouped.blocks.len() as u32);

        let vertices = sorted_once(&grouped.corners);
        let mut row_of = vec![0; slots.len()];
        (0u32..).zip(&vertices).for_each(|(row, &vertex)| row_of[vertex as usize] = row);
        for corner in grouped.corners.iter_mut().flatten() {
            *corner = row_of[*corner as usize];
        }
        grouped.strips = grouped.corners.chunks(STRIP).map(sorted_once).collect();
        grouped.slots = vertices.iter().map(|&v| slots[v as usize]).collect();
        grouped.mobilities = vec![1.0; vertices.len()];
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

    /// How many samples there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The strips: rows of the vertices at their corners, and their cells.
    pub(super) fn strips(&self) -> impl Iterator<Item = (&[u32], Range<usize>)> {
        let cells = (0..self.corners.len()).step_by(STRIP);
        let cells = cells.map(|first| first..(first + STRIP).min(self.corners.len()));
        self.strips.iter().map(Vec::as_slice).zip(cells)
    }

    /// The samples of one cell.
    pub(super) fn of_cell(&self, cell: usize) -> &[SampleBlock] {
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
    vertices
}
