//! Stores numbers of lattice vertices in blocks of eight along x, in which sums over links run on all lanes.
//!
//! A *slot* is the index `8 * block + lane` of a vertex. The blocks are in the order of the vertices, and all vertices
//! of a block are in the same component. Lanes without a vertex contain zeros, and so does one more block at the end of
//! each array, the *zero block*. It replaces missing neighbors of blocks, so that sums over links need masks only where
//! neighboring slots are not linked.

use std::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8, mask32x8};

use super::adjacency::Adjacency;
use crate::lattice::Lattice;
use crate::simd::lanes::{Block, LANES, Row, block_and_lane};

/// Least number of blocks in a [`Chunk`], except in the last one.
const CHUNK_BLOCKS: usize = 512;

/// The blocks of a lattice.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    /// Slot of each vertex.
    pub(super) slots: Vec<u32>,
    /// Bit `l` of the entry of a block is set iff lane `l` has a vertex.
    occupied: Vec<u8>,
    /// Neighbors of each block, in neighbor order. The zero block replaces a block without links to this one.
    neighbors: Vec<[u32; 6]>,
    /// For each block and each side: the lanes whose neighboring slot has a vertex without a link to them.
    gaps: Vec<[u8; 6]>,
    /// Number of links of each vertex.
    links: Vec<Row>,
    /// Component of each block.
    pub(super) components: Vec<u32>,
    /// The chunks, in order. Their division does not depend on the number of threads.
    pub(super) chunks: Vec<Chunk>,
}

/// Consecutive blocks and their vertices, which are consecutive as well.
#[derive(Clone, Debug)]
pub(super) struct Chunk {
    pub(super) blocks: Range<usize>,
    pub(super) vertices: Range<usize>,
}

impl Blocks {
    pub(super) fn new(lattice: &Lattice, adjacency: &Adjacency) -> Self {
        let indices = lattice.indices();
        let offset = best_offset(indices);
        let mut this = Self { slots: Vec::with_capacity(indices.len()), ..Self::default() };
        // The eight places in the grid of the present vertex, and the first of their blocks.
        let (mut place, mut first) = ([i32::MIN; 3], 0);
        let mut begin = Chunk { blocks: 0..0, vertices: 0..0 };
        for (vertex, (&[x, y, z], &component)) in
            indices.iter().zip(&adjacency.component_of_vertex).enumerate()
        {
            let shifted = x + offset;
            if place != [shifted.div_euclid(LANES as i32), y, z] {
                (place, first) = ([shifted.div_euclid(LANES as i32), y, z], this.components.len());
                begin.blocks.end = first;
                begin.vertices.end = vertex;
                if begin.blocks.len() >= CHUNK_BLOCKS {
                    let next = Chunk { blocks: first..first, vertices: vertex..vertex };
                    this.chunks.push(std::mem::replace(&mut begin, next));
                }
            }
            let known = this.components[first..].iter().position(|&other| other == component);
            let block = first + known.unwrap_or(this.components.len() - first);
            if block == this.components.len() {
                this.components.push(component);
                this.occupied.push(0);
            }
            let lane = shifted.rem_euclid(LANES as i32);
            this.occupied[block] |= 1 << lane;
            this.slots.push((block * LANES) as u32 + lane as u32);
        }
        let (blocks, vertices) =
            (begin.blocks.start..this.components.len(), begin.vertices.start..indices.len());
        this.chunks.push(Chunk { blocks, vertices });
        this.link(adjacency);
        this
    }

    /// Finds the neighbors of the blocks, and the gaps between slots that are not linked.
    fn link(&mut self, adjacency: &Adjacency) {
        let Self { slots, occupied, neighbors, gaps, links, .. } = self;
        let blocks = occupied.len();
        links.resize(blocks, Row::ZERO);
        neighbors.resize(blocks, [blocks as u32; 6]);
        // First the lanes that are linked.
        gaps.resize(blocks, [0; 6]);
        for (vertex, linked) in adjacency.neighbors.iter().enumerate() {
            let (block, lane) = block_and_lane(slots[vertex]);
            for side in [1, 3, 5] {
                let neighbor = linked[side] as usize;
                if neighbor == vertex {
                    continue;
                }
                let (other, other_lane) = block_and_lane(slots[neighbor]);
                if other != block {
                    // Where joints are broken, a side of a block can have links to several blocks. The first one
                    // counts.
                    let is_free = |present: u32, wanted: usize| {
                        present as usize == wanted || present as usize == blocks
                    };
                    let is_within = side == 1 && lane + 1 < LANES;
                    let (forth, back) = (neighbors[block][side], neighbors[other][side - 1]);
                    if is_within || !is_free(forth, other) || !is_free(back, block) {
                        continue;
                    }
                    neighbors[block][side] = other as u32;
                    neighbors[other][side - 1] = block as u32;
                }
                for (block, lane, side) in [(block, lane, side), (other, other_lane, side - 1)] {
                    gaps[block][side] |= 1 << lane;
                    links[block][lane] += 1.0;
                }
            }
        }
        for (block, gaps) in gaps.iter_mut().enumerate() {
            let around = neighbors[block].map(|other| occupied.get(other as usize).copied().unwrap_or(0));
            let along_x = [occupied[block] << 1 | around[0] >> 7, occupied[block] >> 1 | around[1] << 7];
            for (side, linked) in gaps.iter_mut().enumerate() {
                let present = if side < 2 { along_x[side] } else { around[side] };
                *linked = present & occupied[block] & !*linked;
            }
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { slots, occupied, neighbors, gaps, links, components, chunks } = self;
        let tables = size_of_val(&**slots) + size_of_val(&**occupied) + size_of_val(&**neighbors);
        let links = size_of_val(&**gaps) + size_of_val(&**links);
        tables + links + size_of_val(&**components) + size_of_val(&**chunks)
    }

    /// Returns the number of blocks, without the zero block.
    pub(super) fn len(&self) -> usize {
        self.occupied.len()
    }

    /// Sets the size of an array of blocks. New blocks are zero, and the zero block at the end always is.
    pub(super) fn resize<const N: usize>(&self, values: &mut Vec<Block<N>>) {
        values.resize(self.len() + 1, [Row::ZERO; N]);
        values[self.len()] = [Row::ZERO; N];
    }

    /// Returns the blocks of each chunk, mutable.
    pub(super) fn split<'a, T>(
        &'a self,
        mut blocks: &'a mut [T],
    ) -> impl ExactSizeIterator<Item = &'a mut [T]> + use<'a, T> {
        self.chunks.iter().map(move |chunk| blocks.split_off_mut(..chunk.blocks.len()).unwrap_or_default())
    }

    /// Returns the vertices of each chunk, mutable.
    pub(super) fn split_vertices<'a, T>(
        &'a self,
        mut vertices: &'a mut [T],
    ) -> impl ExactSizeIterator<Item = &'a mut [T]> + use<'a, T> {
        self.chunks
            .iter()
            .map(move |chunk| vertices.split_off_mut(..chunk.vertices.len()).unwrap_or_default())
    }

    /// Returns the number of links of each vertex of a block.
    #[inline(always)]
    pub(super) fn links<S: Simd>(&self, simd: S, block: usize) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.links[block])
    }

    /// Returns `row` with zeros in the lanes without a vertex.
    #[inline(always)]
    pub(super) fn filled<S: Simd>(&self, simd: S, block: usize, row: f32x8<S>) -> f32x8<S> {
        lanes(simd, self.occupied[block]).select(row, f32x8::splat(simd, 0.0))
    }

    /// Returns the sum of row `c` of `values` over the links of each vertex of a block along an axis. Lanes without a
    /// vertex can be different from zero; see [`filled`](Self::filled).
    #[inline(always)]
    pub(super) fn sum_along<S: Simd, const N: usize>(
        &self,
        simd: S,
        block: usize,
        axis: usize,
        (values, c): (&[Block<N>], usize),
    ) -> f32x8<S> {
        let neighbors = &self.neighbors[block];
        let mut low = f32x8::load_array_ref(simd, &values[neighbors[2 * axis] as usize][c]);
        let mut high = f32x8::load_array_ref(simd, &values[neighbors[2 * axis + 1] as usize][c]);
        if axis == 0 {
            let center = f32x8::load_array_ref(simd, &values[block][c]);
            low = simd.slide_f32x8::<7>(low, center);
            high = simd.slide_f32x8::<1>(center, high);
        }
        let gaps = &self.gaps[block];
        if gaps[2 * axis] | gaps[2 * axis + 1] != 0 {
            let zero = f32x8::splat(simd, 0.0);
            low = lanes(simd, gaps[2 * axis]).select(zero, low);
            high = lanes(simd, gaps[2 * axis + 1]).select(zero, high);
        }
        low + high
    }

    /// Returns the sum of row `c` of `values` over all links of each vertex of a block. Lanes without a vertex can be
    /// different from zero.
    #[inline(always)]
    pub(super) fn sum<S: Simd, const N: usize>(
        &self,
        simd: S,
        block: usize,
        (values, c): (&[Block<N>], usize),
    ) -> f32x8<S> {
        let xy = self.sum_along(simd, block, 0, (values, c)) + self.sum_along(simd, block, 1, (values, c));
        xy + self.sum_along(simd, block, 2, (values, c))
    }
}

/// Returns the mask of the lanes of a bit mask.
#[inline(always)]
fn lanes<S: Simd>(simd: S, bits: u8) -> mask32x8<S> {
    mask32x8::from_bitmask(simd, bits.into())
}

/// Returns the number, 0 to 7, that is added to x before the division into blocks: the one with the fewest blocks.
fn best_offset(indices: &[[i32; 3]]) -> i32 {
    let mut counts = [0; LANES];
    for pair in indices.windows(2) {
        let ([a, b], is_line) = ([pair[0][0], pair[1][0]], pair[0][1..] == pair[1][1..]);
        for (offset, count) in (0..).zip(&mut counts) {
            let is_same =
                is_line && (a + offset).div_euclid(LANES as i32) == (b + offset).div_euclid(LANES as i32);
            *count += usize::from(!is_same);
        }
    }
    (0..).zip(counts).min_by_key(|(_, count)| *count).map_or(0, |(offset, _)| offset)
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use nalgebra::Point3;

    use super::*;
    use crate::simd::level;

    /// Two combs whose teeth interlock without links between them, and a slab with a hole.
    fn gapped() -> Lattice {
        let mut cells = Vec::new();
        for x in 0..23 {
            for y in 0..5 {
                let is_tooth = if x % 4 == 0 { y < 4 } else { x % 4 == 2 && y > 0 };
                if is_tooth || (y == 0 && x % 4 == 1) {
                    cells.push([x, y, 0]);
                }
                if (x, y) != (9, 2) {
                    cells.push([x, y, 7]);
                }
            }
        }
        Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap()
    }

    #[test]
    fn sums_over_links_agree_with_the_adjacency() {
        let lattice = gapped();
        let adjacency = Adjacency::new(&lattice);
        let blocks = Blocks::new(&lattice, &adjacency);
        assert!(adjacency.component_count > 2 && blocks.gaps.iter().any(|gaps| *gaps != [0; 6]));
        let value = |vertex: usize| 1.0 + (vertex * vertex % 101) as f32;
        let mut values = Vec::new();
        blocks.resize(&mut values);
        for (vertex, &slot) in blocks.slots.iter().enumerate() {
            let (block, lane) = block_and_lane(slot);
            values[block][0][lane] = value(vertex);
            assert_eq!(blocks.components[block] as usize, adjacency.component(vertex));
        }
        let mut sums = values.clone();
        dispatch!(level(), simd => {
            for block in 0..blocks.len() {
                blocks.filled(simd, block, blocks.sum(simd, block, (&values, 0))).store_array(&mut sums[block][0]);
            }
        });
        for (vertex, &slot) in blocks.slots.iter().enumerate() {
            // Small integers, so that the sums are exact.
            let expected: f32 = adjacency.linked(vertex).map(value).sum();
            let (block, lane) = block_and_lane(slot);
            let sum = &mut sums[block][0][lane];
            assert_eq!(std::mem::take(sum), expected, "{vertex}");
        }
        assert!(sums.iter().all(|block| *block == [Row::ZERO]), "lanes without a vertex");
    }

    #[test]
    fn chunks_cover_all_blocks_and_vertices() {
        let cells: Vec<[i32; 3]> = (0..40 * 40 * 20).map(|i| [i % 40, i / 40 % 40, i / 1600]).collect();
        let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), true).unwrap();
        let blocks = Blocks::new(&lattice, &Adjacency::new(&lattice));
        let mut end = (0, 0);
        for Chunk { blocks: range, vertices } in &blocks.chunks {
            assert_eq!((range.start, vertices.start), end);
            let slots = &blocks.slots[vertices.clone()];
            assert!(slots.iter().all(|&slot| range.contains(&block_and_lane(slot).0)));
            end = (range.end, vertices.end);
        }
        assert_eq!(end, (blocks.len(), lattice.len()));
        assert!(blocks.chunks.len() > 2);
    }
}
