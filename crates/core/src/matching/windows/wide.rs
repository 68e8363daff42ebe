//! Computes the sums over wide windows for an axis along the lanes, from prefix sums within blocks.
//!
//! Let f be the value of a vertex, and w = 8 a + r the half-width, with 0 <= r < 8. P[b] are the prefix sums
//! of f over the eight lanes of block b, and T[b] is the sum over these lanes. pair[b] are the 16 prefix sums
//! over the blocks b and b + 1: P[b], then T[b] + P[b+1]. The sum over the window around lane l of block b is
//!
//! ```text
//! W(f) = T[b-a-1] + … + T[b+a-1]  +  pair[b+a][l + r]  -  pair[b-a-1][l + 7 - r]
//! ```
//!
//! The offset-weighted sum W'(f) follows in the same way from the moments, the sums of j f, where j is the
//! number of lanes from the center of the window to a vertex. A run is a maximal sequence of linked vertices.
//! The sums are computed run by run, and vertices of other runs count as zero. So windows need no masks, and
//! the cost depends only slightly on w.

use std::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};

use crate::simd::lanes::LANES;

/// A run: a maximal sequence of linked vertices along the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    /// Index of the first block.
    first: usize,
    /// Index of the last block.
    last: usize,
    /// Bit mask of the lanes from the first vertex of the run to lane 7, in the first block.
    head: u8,
    /// Bit mask of the lanes from lane 0 to the last vertex of the run, in the last block.
    tail: u8,
}

impl Run {
    /// Returns the bit mask of the lanes of a block that belong to the run.
    fn lanes(self, block: usize) -> u8 {
        let head = if block == self.first { self.head } else { 0xff };
        let tail = if block == self.last { self.tail } else { 0xff };
        head & tail
    }
}

/// Iterates over the runs of `blocks` in storage order. `blocks` must consist of whole lines, so that no run
/// crosses its ends.
fn runs<'a>(links: &'a [u8], occupied: &'a [u8], blocks: Range<usize>) -> impl Iterator<Item = Run> + 'a {
    // The lanes of `block` that are not yet part of a run.
    let (mut block, mut unvisited) = (blocks.start, 0xff);
    std::iter::from_fn(move || {
        while block < blocks.end && occupied[block] & unvisited == 0 {
            (block, unvisited) = (block + 1, 0xff);
        }
        if block >= blocks.end {
            return None;
        }
        let (first, start) = (block, (occupied[block] & unvisited).trailing_zeros());
        let mut lane = start;
        let end = loop {
            let end = lane + (links[block] >> lane).trailing_ones();
            if end < LANES as u32 {
                break end;
            }
            (block, lane) = (block + 1, 0);
        };
        // The vertex in lane `end` is not linked to the next vertex.
        let run = Run { first, last: block, head: 0xff << start, tail: 0xff >> (LANES as u32 - 1 - end) };
        unvisited = !run.tail;
        Some(run)
    })
}

/// Scratch memory for the prefix sums of a run.
#[derive(Clone, Debug)]
pub(in crate::matching) struct BlockSums {
    /// `pair` of each component of f, then of the moment l f of three components, where l is the lane. The
    /// first entry is for the block before the run, the others are for the blocks of the run.
    pairs: Vec<[Pair; 15]>,
    /// T of each component of f, then of the moment l f of three components, for each block of the run.
    totals: Vec<[f32; 2 * LANES]>,
}

/// The wide windows of a pass for an axis along the lanes.
#[derive(Clone, Debug)]
pub(super) struct WideWindows<'a> {
    /// For each block, the bit mask of the lanes that are linked to the next vertex.
    pub(super) links: &'a [u8],
    /// For each block, the bit mask of the lanes with a vertex.
    pub(super) occupied: &'a [u8],
    pub(super) half_width: usize,
    /// The blocks of the center vertices; whole lines.
    pub(super) blocks: Range<usize>,
}

/// The 16 prefix sums over two consecutive blocks.
type Pair = [f32; 2 * LANES];

/// The pairs of a block that neither belongs to the run nor is adjacent to it.
const ZERO_PAIRS: [Pair; 15] = [[0.0; 2 * LANES]; 15];

impl BlockSums {
    /// Allocates scratch memory for runs of up to `blocks` blocks.
    pub(in crate::matching) fn new(blocks: usize) -> Self {
        Self { pairs: vec![ZERO_PAIRS; blocks + 1], totals: vec![[0.0; 2 * LANES]; blocks] }
    }

    /// Returns the memory in bytes.
    pub(in crate::matching) fn bytes(&self) -> usize {
        size_of_val(self.pairs.as_slice()) + size_of_val(self.totals.as_slice())
    }

    /// Computes the sums of wide windows: W of the `N` components `row(block, c)`, at most 12, and W' of the
    /// three components from `WEIGHTED` on. Calls `output(block, lanes, W, W')` for each block of each run,
    /// where `lanes` is the bit mask of the lanes that belong to the run.
    #[inline(always)]
    pub(super) fn along<S: Simd, const N: usize, const WEIGHTED: usize>(
        &mut self,
        simd: S,
        WideWindows { links, occupied, half_width, blocks }: WideWindows,
        row: &impl Fn(usize, usize) -> f32x8<S>,
        mut output: impl FnMut(usize, u8, [f32x8<S>; N], [f32x8<S>; 3]),
    ) {
        for run in runs(links, occupied, blocks) {
            let length = run.last + 1 - run.first;
            for block in run.first..=run.last {
                self.sum::<S, N, WEIGHTED>(
                    simd,
                    block - run.first,
                    run.lanes(block),
                    #[inline(always)]
                    |c| row(block, c),
                );
            }
            for block in run.first..=run.last {
                let index = block - run.first;
                let (plain, weighted) = self.window::<S, N, WEIGHTED>(simd, half_width, index, length);
                output(block, run.lanes(block), plain, weighted);
            }
        }
    }

    /// Computes the prefix sums of block `index` of a run. `lanes` is the bit mask of the lanes of the run.
    #[inline(always)]
    fn sum<S: Simd, const N: usize, const WEIGHTED: usize>(
        &mut self,
        simd: S,
        index: usize,
        lanes: u8,
        row: impl Fn(usize) -> f32x8<S>,
    ) {
        let zero = f32x8::splat(simd, 0.0);
        let mask = mask32x8::from_bitmask(simd, u64::from(lanes));
        let lane_index = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let (previous, current) = self.pairs.split_at_mut(index + 1);
        let (previous, current) = (&mut previous[index], &mut current[0]);
        let previous_totals = index.checked_sub(1).map_or([0.0; 2 * LANES], |previous| self.totals[previous]);
        let totals = &mut self.totals[index];
        for c in 0..N {
            let value = mask.select(row(c), zero);
            let sums = prefix(simd, value);
            sums.store_slice(&mut current[c][..LANES]);
            sums.store_slice(&mut current[c][LANES..]);
            totals[c] = current[c][LANES - 1];
            (sums + previous_totals[c]).store_slice(&mut previous[c][LANES..]);
            if c >= WEIGHTED && c < WEIGHTED + 3 {
                let m = N + c - WEIGHTED;
                let moments = prefix(simd, value * lane_index);
                moments.store_slice(&mut current[m][..LANES]);
                totals[m] = current[m][LANES - 1];
                // Lane 0 is lane 8 if lanes are counted from the start of the previous block.
                let shifted = sums.mul_add(f32x8::splat(simd, LANES as f32), moments);
                (shifted + previous_totals[m]).store_slice(&mut previous[m][LANES..]);
            }
        }
        // The second half of a pair is T if the run has no next block. If there is a next block, its call of
        // this function overwrites the second half.
        for c in 0..N + 3 {
            current[c][LANES..].fill(totals[c]);
        }
    }

    /// Computes W and W' of block `index` of a run of `length` blocks.
    #[inline(always)]
    fn window<S: Simd, const N: usize, const WEIGHTED: usize>(
        &self,
        simd: S,
        half_width: usize,
        index: usize,
        length: usize,
    ) -> ([f32x8<S>; N], [f32x8<S>; 3]) {
        // The numbers a and r of the formula.
        let (a, r) = (half_width / LANES, half_width % LANES);
        // `pairs` begins one block before the run.
        let end = if index + a < length { &self.pairs[index + a + 1] } else { &ZERO_PAIRS };
        let start = if index >= a { &self.pairs[index - a] } else { &ZERO_PAIRS };
        let between = self.between::<S, N, WEIGHTED>(simd, index, a, length);
        let lane_index = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let zero = f32x8::splat(simd, 0.0);
        let (mut plain, mut weighted) = ([zero; N], [zero; 3]);
        for c in 0..N {
            let up_to_end = f32x8::from_slice(simd, &end[c][r..r + LANES]);
            let before_start = f32x8::from_slice(simd, &start[c][LANES - 1 - r..2 * LANES - 1 - r]);
            plain[c] = (up_to_end - before_start) + between[c];
            if c >= WEIGHTED && c < WEIGHTED + 3 {
                let m = N + c - WEIGHTED;
                let end_moment = f32x8::from_slice(simd, &end[m][r..r + LANES]);
                let start_moment = f32x8::from_slice(simd, &start[m][LANES - 1 - r..2 * LANES - 1 - r]);
                // Numbers of lanes from the start of this block to the blocks of `end` and `start`.
                let to_end = f32x8::splat(simd, (LANES * a) as f32);
                let to_start = f32x8::splat(simd, (LANES * (a + 1)) as f32);
                let ends = up_to_end.mul_add(to_end, end_moment);
                let starts = start_moment - before_start * to_start;
                let moment = (ends - starts) + between[m];
                weighted[c - WEIGHTED] = moment - plain[c] * lane_index;
            }
        }
        (plain, weighted)
    }

    /// Sums T of the blocks `index - a - 1` to `index + a - 1` of a run of `length` blocks, for each
    /// component of f and the moments of three components. The lanes of the moments are counted from the
    /// start of block `index`.
    #[inline(always)]
    fn between<S: Simd, const N: usize, const WEIGHTED: usize>(
        &self,
        simd: S,
        index: usize,
        a: usize,
        length: usize,
    ) -> [f32; 2 * LANES] {
        let zero = f32x8::splat(simd, 0.0);
        let (mut sums, mut shifts) = ([zero; 2], [zero; 2]);
        let first = index.saturating_sub(a + 1);
        for (block, totals) in (first..).zip(&self.totals[first..length.min(index + a)]) {
            let distance = f32x8::splat(simd, LANES as f32 * (block as f32 - index as f32));
            for half in 0..2 {
                let totals = f32x8::from_slice(simd, &totals[half * LANES..][..LANES]);
                sums[half] += totals;
                shifts[half] = totals.mul_add(distance, shifts[half]);
            }
        }
        let (mut between, mut shift) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
        for half in 0..2 {
            sums[half].store_slice(&mut between[half * LANES..][..LANES]);
            shifts[half].store_slice(&mut shift[half * LANES..][..LANES]);
        }
        for c in 0..3 {
            between[N + c] += shift[WEIGHTED + c];
        }
        between
    }
}

/// Computes the prefix sums over the eight lanes of `values`: lane l of the result is the sum of lanes 0 to
/// l.
#[inline(always)]
fn prefix<S: Simd>(simd: S, values: f32x8<S>) -> f32x8<S> {
    let zero = f32x8::splat(simd, 0.0);
    let pairs = values + simd.slide_f32x8::<7>(zero, values);
    let fours = pairs + simd.slide_f32x8::<6>(zero, pairs);
    fours + simd.slide_f32x8::<4>(zero, fours)
}
