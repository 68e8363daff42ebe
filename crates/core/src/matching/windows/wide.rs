//! Wide windows along the lanes, from prefix sums within blocks.
//!
//! P[b] are the prefix sums of f over the lanes of block b, T[b] is the sum over the block, and w = 8 a + r.
//! pair[b] are the 16 prefix sums over the blocks b and b + 1: P[b], then T[b] + P[b+1]. The window around
//! lane l of block b is
//!
//! ```text
//! W(f) = T[b-a-1] + … + T[b+a-1]  +  pair[b+a] at l + r  -  pair[b-a-1] at l + 7 - r
//! ```
//!
//! W' is computed in the same way from sums of j f, with j counted from lane l. The sums are within a run, a
//! sequence of linked vertices; vertices of other runs count as zero. So windows need no masks, and the cost
//! hardly depends on w.

use std::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};

use crate::simd::lanes::LANES;

/// A run of linked vertices along the lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    /// First block.
    first: usize,
    /// Last block.
    last: usize,
    /// Bit mask of the lanes of the run from its first vertex on, in the first block.
    head: u8,
    /// Bit mask of the lanes of the run up to its last vertex, in the last block.
    tail: u8,
}

impl Run {
    /// Bit mask of the lanes of a block that belong to the run.
    fn lanes(self, block: usize) -> u8 {
        let head = if block == self.first { self.head } else { 0xff };
        let tail = if block == self.last { self.tail } else { 0xff };
        head & tail
    }
}

/// Iterates over the runs in some blocks in order; the blocks are whole lines.
fn runs<'a>(links: &'a [u8], occupied: &'a [u8], blocks: Range<usize>) -> impl Iterator<Item = Run> + 'a {
    let (mut block, mut rest) = (blocks.start, 0xff);
    std::iter::from_fn(move || {
        while block < blocks.end && occupied[block] & rest == 0 {
            (block, rest) = (block + 1, 0xff);
        }
        if block >= blocks.end {
            return None;
        }
        let (first, start) = (block, (occupied[block] & rest).trailing_zeros());
        let mut from = start;
        let end = loop {
            let end = from + (links[block] >> from).trailing_ones();
            if end < LANES as u32 {
                break end;
            }
            (block, from) = (block + 1, 0);
        };
        // The vertex in lane `end` is not linked to the next one.
        let run = Run { first, last: block, head: 0xff << start, tail: 0xff >> (LANES as u32 - 1 - end) };
        rest = !run.tail;
        Some(run)
    })
}

/// Scratch memory for the prefix sums of a run.
#[derive(Clone, Debug)]
pub(in crate::matching) struct BlockSums {
    /// Pairs of all components, then of the moments l f of three: of the block before the run, then of its
    /// blocks.
    pairs: Vec<[Pair; 15]>,
    /// T of all components, then of the moments l f of three, by block of the run.
    totals: Vec<[f32; 2 * LANES]>,
}

/// The windows that are summed.
#[derive(Clone, Debug)]
pub(super) struct WideWindows<'a> {
    pub(super) links: &'a [u8],
    pub(super) occupied: &'a [u8],
    pub(super) half_width: usize,
    /// Blocks of the windows; whole lines.
    pub(super) blocks: Range<usize>,
}

/// Prefix sums over two consecutive blocks.
type Pair = [f32; 2 * LANES];

/// The pairs of a block outside the run and not next to it.
const ZERO_PAIRS: [Pair; 15] = [[0.0; 2 * LANES]; 15];

impl BlockSums {
    /// Allocates scratch memory for runs of up to `blocks` blocks.
    pub(in crate::matching) fn new(blocks: usize) -> Self {
        Self { pairs: vec![ZERO_PAIRS; blocks + 1], totals: vec![[0.0; 2 * LANES]; blocks] }
    }

    /// Memory in bytes.
    pub(in crate::matching) fn bytes(&self) -> usize {
        size_of_val(self.pairs.as_slice()) + size_of_val(self.totals.as_slice())
    }

    /// Sums the windows around the vertices of some blocks, which are whole lines. Computes W of the `N`
    /// components `row(block, c)`, at most 12, and W' of the three components from `WEIGHTED` on. `output`
    /// receives a block, the bit mask of the lanes of a run, W and W'.
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
                let at = block - run.first;
                let (plain, weighted) = self.window::<S, N, WEIGHTED>(simd, half_width, at, length);
                output(block, run.lanes(block), plain, weighted);
            }
        }
    }

    /// Computes the prefix sums of block `at` of a run.
    #[inline(always)]
    fn sum<S: Simd, const N: usize, const WEIGHTED: usize>(
        &mut self,
        simd: S,
        at: usize,
        lanes: u8,
        row: impl Fn(usize) -> f32x8<S>,
    ) {
        let zero = f32x8::splat(simd, 0.0);
        let mask = mask32x8::from_bitmask(simd, u64::from(lanes));
        let lane_index = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let (previous, current) = self.pairs.split_at_mut(at + 1);
        let (previous, current) = (&mut previous[at], &mut current[0]);
        let previous_totals = at.checked_sub(1).map_or([0.0; 2 * LANES], |at| self.totals[at]);
        let totals = &mut self.totals[at];
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
                // Counted from the start of the previous block, lane 0 is lane 8.
                let shifted = sums.mul_add(f32x8::splat(simd, LANES as f32), moments);
                (shifted + previous_totals[m]).store_slice(&mut previous[m][LANES..]);
            }
        }
        // Without a next block, the second half of a pair is the total. The next block overwrites it.
        for c in 0..N + 3 {
            current[c][LANES..].fill(totals[c]);
        }
    }

    /// Computes W and W' of block `at` of a run of `length` blocks.
    #[inline(always)]
    fn window<S: Simd, const N: usize, const WEIGHTED: usize>(
        &self,
        simd: S,
        half_width: usize,
        at: usize,
        length: usize,
    ) -> ([f32x8<S>; N], [f32x8<S>; 3]) {
        let (whole, rest) = (half_width / LANES, half_width % LANES);
        // `pairs` begins one block before the run.
        let end = if at + whole < length { &self.pairs[at + whole + 1] } else { &ZERO_PAIRS };
        let start = if at >= whole { &self.pairs[at - whole] } else { &ZERO_PAIRS };
        let between = self.between::<S, N, WEIGHTED>(simd, at, whole, length);
        let lane_index = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let zero = f32x8::splat(simd, 0.0);
        let (mut plain, mut weighted) = ([zero; N], [zero; 3]);
        for c in 0..N {
            let up_to_end = f32x8::from_slice(simd, &end[c][rest..rest + LANES]);
            let before_start = f32x8::from_slice(simd, &start[c][LANES - 1 - rest..2 * LANES - 1 - rest]);
            plain[c] = (up_to_end - before_start) + between[c];
            if c >= WEIGHTED && c < WEIGHTED + 3 {
                let m = N + c - WEIGHTED;
                let end_moment = f32x8::from_slice(simd, &end[m][rest..rest + LANES]);
                let start_moment = f32x8::from_slice(simd, &start[m][LANES - 1 - rest..2 * LANES - 1 - rest]);
                let to_end = f32x8::splat(simd, (LANES * whole) as f32);
                let to_start = f32x8::splat(simd, (LANES * (whole + 1)) as f32);
                let ends = up_to_end.mul_add(to_end, end_moment);
                let starts = start_moment - before_start * to_start;
                let moment = (ends - starts) + between[m];
                weighted[c - WEIGHTED] = moment - plain[c] * lane_index;
            }
        }
        (plain, weighted)
    }

    /// Sums the totals of the blocks from `at - whole - 1` to `at + whole - 1`. Moments are counted from the
    /// start of block `at`.
    #[inline(always)]
    fn between<S: Simd, const N: usize, const WEIGHTED: usize>(
        &self,
        simd: S,
        at: usize,
        whole: usize,
        length: usize,
    ) -> [f32; 2 * LANES] {
        let zero = f32x8::splat(simd, 0.0);
        let (mut sums, mut shifts) = ([zero; 2], [zero; 2]);
        let from = at.saturating_sub(whole + 1);
        for (block, totals) in (from..).zip(&self.totals[from..length.min(at + whole)]) {
            let distance = f32x8::splat(simd, LANES as f32 * (block as f32 - at as f32));
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

/// Computes the prefix sums of eight lanes.
#[inline(always)]
fn prefix<S: Simd>(simd: S, values: f32x8<S>) -> f32x8<S> {
    let zero = f32x8::splat(simd, 0.0);
    let pairs = values + simd.slide_f32x8::<7>(zero, values);
    let fours = pairs + simd.slide_f32x8::<6>(zero, pairs);
    fours + simd.slide_f32x8::<4>(zero, fours)
}
