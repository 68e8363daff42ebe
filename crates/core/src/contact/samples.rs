//! Samples: points of the body's surface on which contacts act, grouped by lattice cell.
//!
//! A *row* is an index into `SampleCells::vertices`, the lattice vertices that move samples. A *slot* is the
//! index of a lattice vertex in the storage of the state; see `simd::lanes`.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use super::sampler::RestSurface;
#[cfg(feature = "internals")]
use crate::lattice::Embedding;
use crate::lattice::{Lattice, Stencil, trilinear_weights};
#[cfg(feature = "internals")]
use crate::mesh::Mesh;
use crate::mesh::distinct;
use crate::simd::lanes::LANES;

/// Number of cells in a strip. A strip consists of consecutive cells, most of which are adjacent.
const STRIP: usize = 32;

/// Sample points embedded in lattice cells.
#[derive(Clone, Debug)]
pub struct SampleCells {
    /// Rows of the corners of each cell that contains a sample.
    pub(super) corners: Vec<[u32; 8]>,
    /// Index in `blocks` of the first block of each cell, then the number of blocks (CSR offsets).
    first: Vec<u32>,
    /// Blocks of samples, in the order of the cells.
    blocks: Vec<SampleBlock>,
    /// Number of samples.
    count: usize,
    /// Rows of the corners of each strip of [`STRIP`] cells. Detection tests a strip before its cells.
    strips: Vec<Vec<u32>>,
    /// Lattice vertices at the corners of the cells, in increasing order.
    pub(super) vertices: Vec<u32>,
    /// Slot of each of `vertices`.
    pub(super) slots: Vec<u32>,
    /// Inverse mass of each of `vertices`, in units of 1 / (mass of a full cell).
    pub(super) mobilities: Vec<f32>,
    /// The stencil of each row, in rows, if the skin is smooth. `vertices` then includes the neighbors of the corners,
    /// whose own stencils have no neighbors.
    stencils: Option<Vec<Stencil>>,
}

/// Up to eight samples of one cell that have the same nearest corner, one per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleBlock {
    /// Nearest corner, 0..8.
    pub(super) corner: u8,
    /// Positions within the cell: x, y and z of each sample, in [0, 1]. Padding lanes repeat the last sample.
    pub(super) positions: [[f32; LANES]; 3],
    /// Fraction of each sample that counts at this corner: 1/k for a sample with k equally near corners,
    /// which is in a block of each of these corners; 0 for padding lanes.
    pub(super) fractions: [f32; LANES],
}

impl SampleBlock {
    /// Returns the number of halves of the lanes that have samples: 1 or 2.
    pub(super) fn halves(&self) -> usize {
        if self.fractions[LANES / 2] > 0.0 { 2 } else { 1 }
    }
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

        let vertices_of = |cells: &[[u32; 8]]| {
            let mut vertices = distinct(cells.as_flattened().iter().copied());
            vertices.shrink_to_fit();
            vertices
        };
        let vertices = vertices_of(&cell_corners);
        let mut row_of = vec![0; slots.len()];
        (0u32..).zip(&vertices).for_each(|(row, &vertex)| row_of[vertex as usize] = row);
        for corner in cell_corners.iter_mut().flatten() {
            *corner = row_of[*corner as usize];
        }
        Self {
            strips: cell_corners.chunks(STRIP).map(vertices_of).collect(),
            slots: vertices.iter().map(|&v| slots[v as usize]).collect(),
            mobilities: vec![1.0; vertices.len()],
            count: cells.len(),
            corners: cell_corners,
            first,
            blocks,
            vertices,
            stencils: None,
        }
    }

    /// Makes the positions of the samples smooth; see [`Embedding::smoothed`](crate::lattice::Embedding::smoothed).
    ///
    /// `slots` has the slot of each lattice vertex, and `masses` its mass in units of a full cell's mass.
    #[must_use]
    pub fn smoothed(mut self, lattice: &Lattice, slots: &[u32], masses: &[f32]) -> Self {
        let stencil = |&vertex: &u32| Stencil::new(lattice, vertex);
        let around = |vertex: &u32| stencil(vertex).vertices();
        let vertices = distinct(self.vertices.iter().flat_map(around));
        let is_corner = |vertex: &u32| self.vertices.binary_search(vertex).is_ok();
        let row = |vertex: u32| vertices.partition_point(|&other| other < vertex) as u32;
        // The neighbors of a row that is not a corner may have no rows. Its slopes are zero.
        let renumbered = |vertex: &u32| match is_corner(vertex) {
            true => stencil(vertex).renumbered(row),
            false => Stencil::isolated(row(*vertex)),
        };
        self.stencils = Some(vertices.iter().map(renumbered).collect());
        let rows: Vec<u32> = self.vertices.iter().map(|&vertex| row(vertex)).collect();
        let corners = self.corners.iter_mut().flatten().chain(self.strips.iter_mut().flatten());
        corners.for_each(|corner| *corner = rows[*corner as usize]);
        self.slots = vertices.iter().map(|&vertex| slots[vertex as usize]).collect();
        self.vertices = vertices;
        self.with_masses(masses)
    }

    /// Returns the stencil of each row, in rows; `None` if the skin is linear.
    pub(super) fn stencils(&self) -> Option<&[Stencil]> {
        self.stencils.as_deref()
    }

    /// Creates the samples of a mesh in its lattice, at most one cell apart, as bodies have them.
    #[cfg(feature = "internals")]
    pub fn of_mesh(mesh: &Mesh, lattice: &Lattice, slots: &[u32], masses: &[f32]) -> Self {
        let embedding = Embedding::new(lattice, mesh.vertices());
        Self::of_surface(&RestSurface::of_mesh(mesh, lattice, &embedding), 1.0, slots, masses)
    }

    /// Creates the samples of a bare lattice (without a mesh), one cell apart: see
    /// [`of_lattice_within`](Self::of_lattice_within).
    #[cfg(feature = "internals")]
    pub fn of_lattice(lattice: &Lattice, slots: &[u32], masses: &[f32]) -> Self {
        Self::of_lattice_within(1.0, lattice, slots, masses)
    }

    /// Creates the samples of the surface of a mesh, at most `spacing` cells apart: see [`RestSurface::sample`].
    ///
    /// `slots` has the slot of each lattice vertex, and `masses` its mass in units of a full cell's mass. A piece of a
    /// few cells can be without a surface: the centers of its cells are samples, so that it does not fall through
    /// colliders.
    pub(crate) fn of_surface(surface: &RestSurface<'_>, spacing: f64, slots: &[u32], masses: &[f32]) -> Self {
        let parts = surface.parts;
        let samples = surface.sample(&surface.of_parts(), spacing);
        let mut has_samples = vec![false; parts.count];
        samples.iter().for_each(|sample| has_samples[parts.of_cell(sample.cell) as usize] = true);
        let centers = (0..parts.lattice.cells().len() as u32)
            .filter(|&cell| !has_samples[parts.of_cell(cell) as usize])
            .map(|cell| (cell, [0.5; 3]));
        let on_surface = samples.iter().map(|sample| (sample.cell, sample.local));
        let (cells, local): (Vec<_>, Vec<_>) = on_surface.chain(centers).unzip();
        Self::new(&cells, &local, |cell| parts.lattice.cell_corners(cell), slots).with_masses(masses)
    }

    /// Creates the samples of a bare lattice: its vertices with fewer than eight occupied cells, which lie on the
    /// surface of the lattice, and points of the faces of its cells there, at most `spacing` cells apart.
    ///
    /// `slots` has the slot of each lattice vertex, and `masses` its mass in units of a full cell's mass.
    pub(crate) fn of_lattice_within(spacing: f64, lattice: &Lattice, slots: &[u32], masses: &[f32]) -> Self {
        let (mut cells, mut local) = (Vec::new(), Vec::new());
        let boundary = (0..)
            .zip(lattice.occupied_cells().iter().zip(lattice.indices()))
            .filter(|(_, (count, _))| **count < 8);
        for (vertex, (_, index)) in boundary {
            // Any of the vertex's occupied cells serves, because the vertex has the weight 1 in each of them.
            let found = (0..8).find_map(|k| {
                let cell = lattice.cell_around(*index, 7 - k)?;
                let is_corner = lattice.cell_corners(cell)[k] == vertex;
                is_corner.then(|| (cell, std::array::from_fn(|a| (k >> a & 1) as f32)))
            });
            if let Some((cell, position)) = found {
                cells.push(cell);
                local.push(position);
            }
        }
        let steps = (1.0 / spacing).ceil() as u32;
        for cell in 0..lattice.cells().len() as u32 {
            for (axis, side) in (0..6).map(|k| (k / 2, k % 2)).filter(|_| steps > 1) {
                if lattice.joined_cell(cell, 2 * axis + side).is_some() {
                    continue;
                }
                // Points on edges that two faces share occur twice, which does no harm: weights are relative.
                for k in 0..(steps + 1) * (steps + 1) {
                    let along = [k % (steps + 1), k / (steps + 1)];
                    if along.iter().any(|k| k % steps > 0) {
                        let mut position = [side as f32; 3];
                        position[(axis + 1) % 3] = along[0] as f32 / steps as f32;
                        position[(axis + 2) % 3] = along[1] as f32 / steps as f32;
                        cells.push(cell);
                        local.push(position);
                    }
                }
            }
        }
        Self::new(&cells, &local, |cell| lattice.cell_corners(cell), slots).with_masses(masses)
    }

    /// Sets the inverse masses.
    fn with_masses(mut self, masses: &[f32]) -> Self {
        let mobility = |&vertex: &u32| 1.0 / masses[vertex as usize];
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
        let stencils = self.stencils.as_deref().map_or(0, size_of_val);
        cells + strips + vertices + size_of_val(&*self.mobilities) + stencils
    }

    /// Iterates over the strips: the rows of the corners of the strip's cells, and the range of these cells.
    pub(super) fn strips(&self) -> impl Iterator<Item = (&[u32], Range<usize>)> {
        let cells = (0..self.corners.len()).step_by(STRIP);
        let cells = cells.map(|first| first..(first + STRIP).min(self.corners.len()));
        self.strips.iter().map(Vec::as_slice).zip(cells)
    }

    /// Returns the trilinear position of each sample, with a lattice vertex of its cell. `position` returns the
    /// position of a slot. A sample at equal distance from several corners occurs several times.
    pub(crate) fn positions(
        &self,
        position: impl Fn(u32) -> Vector3<f64>,
    ) -> impl Iterator<Item = (u32, Point3<f64>)> {
        (0..self.corners.len()).flat_map(move |cell| {
            let rows = self.corners[cell].map(|row| row as usize);
            let corners = rows.map(|row| position(self.slots[row]));
            let lanes = self.cell_blocks(cell).iter().flat_map(|block| {
                let lanes = (0..LANES).filter(|&lane| block.fractions[lane] > 0.0);
                lanes.map(|lane| block.positions.map(|axis| axis[lane]))
            });
            lanes.map(move |local| {
                let weighted = corners.iter().zip(trilinear_weights(local));
                let sum = weighted.map(|(corner, weight)| corner * f64::from(weight)).sum::<Vector3<f64>>();
                (self.vertices[rows[0]], sum.into())
            })
        })
    }

    /// Returns the place of each sample at rest in thousandths of a cell, by the index of its block times eight plus
    /// its lane; `None` for padding. `rest_position` returns the rest position of a vertex.
    pub(super) fn places(
        &self,
        rest_position: impl Fn(u32) -> Point3<f64>,
        cell_size: f64,
    ) -> Vec<Option<[i64; 3]>> {
        let mut places = Vec::with_capacity(self.blocks.len() * LANES);
        for cell in 0..self.corners.len() {
            let first = rest_position(self.vertices[self.corners[cell][0] as usize]) / cell_size;
            for block in self.cell_blocks(cell) {
                places.extend((0..LANES).map(|lane| {
                    let place = |axis: usize| first[axis] + f64::from(block.positions[axis][lane]);
                    (block.fractions[lane] > 0.0)
                        .then(|| std::array::from_fn(|axis| (place(axis) * 1e3).round() as i64))
                }));
            }
        }
        places
    }

    /// Returns the range of the indices of the blocks of a range of cells.
    pub(super) fn block_range(&self, cells: Range<usize>) -> Range<u32> {
        self.first[cells.start]..self.first[cells.end]
    }

    /// Returns the number of blocks.
    pub(super) fn block_count(&self) -> usize {
        self.blocks.len()
    }

    /// Returns the sample blocks of one cell.
    pub(super) fn cell_blocks(&self, cell: usize) -> &[SampleBlock] {
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
