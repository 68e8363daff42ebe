//! Wide windows along the lanes, from sums within blocks.
//!
//! With P the sums of f over the lanes up to each lane of a block, T those over the whole block, w = 8 a + r, and
//! *pairs* that go on into the next block, (P of block b, T of block b + P of block b + 1), the window around lane l
//! of block b is
//!
//! ```text
//! W(f) = T[b-a-1] + … + T[b+a-1]  +  pair[b+a] at l + r  -  pair[b-a-1] at l + 7 - r
//! ```
//!
//! and W' the same of the sums of j f, j counted from lane l. A run is a row of linked vertices; others count as
//! zero. So no window needs a mask, and wider ones cost next to nothing more.

use std::ops::Range;

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};

use crate::simd::lanes::LANES;

/// Linked vertices along the lanes: the blocks from `first` to `last`, in these the lanes in the bits of `head` and
/// `tail`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    first: usize,
    last: usize,
    head: u8,
    tail: u8,
}

impl Run {
    /// The lanes of a block that belong to the run, as bits.
    fn lanes(self, block: usize) -> u8 {
        let head = if block == self.first { self.head } else { 0xff };
        let tail = if block == self.last { self.tail } else { 0xff };
        head & tail
    }
}

/// The runs in some blocks, whole lines, in order.
fn runs<'a>(links: &'a [u8], occupied: &'a [u8], blocks: Range<usize>) -> impl Iterator<Item = Run> + 'a {
    let (mut block, mut left) = (blocks.start, 0xff);
    std::iter::from_fn(move || {
        while block < blocks.end && occupied[block] & left == 0 {
            (block, left) = (block + 1, 0xff);
        }
        if block >= blocks.end {
            return None;
        }
        let (first, start) = (block, (occupied[block] & left).trailing_zeros());
        let mut from = start;
        let end = loop {
            let end = from + (links[block] >> from).trailing_ones();
            if end < LANES as u32 {
                break end;
            }
            (block, from) = (block + 1, 0);
        };
        // The vertex in lane `end` is linked to none after it.
        let run = Run { first, last: block, head: 0xff << start, tail: 0xff >> (LANES as u32 - 1 - end) };
        left = !run.tail;
        Some(run)
    })
}

/// Scratch: sums within the blocks of a run.
#[derive(Clone, Debug)]
pub(in crate::matching) struct BlockSums {
    /// Of the block before the run, then of its blocks.
    pairs: Vec<[Pair; 15]>,
    /// T of all components, then of the moments l f of three.
    totals: Vec<[f32; 2 * LANES]>,
}

/// Which windows are summed.
#[derive(Clone, Debug)]
pub(super) struct WideWindows<'a> {
    pub(super) links: &'a [u8],
    pub(super) occupied: &'a [u8],
    pub(super) half_width: usize,
    /// Whole lines.
    pub(super) blocks: Range<usize>,
}

type Pair = [f32; 2 * LANES];

/// The pairs of a block far from the run.
const FAR: [Pair; 15] = [[0.0; 2 * LANES]; 15];

impl BlockSums {
    /// For runs of up to `blocks` blocks.
    pub(in crate::matching) fn new(blocks: usize) -> Self {
        Self { pairs: vec![FAR; blocks + 1], totals: vec![[0.0; 2 * LANES]; blocks] }
    }

    /// Memory that it takes.
    pub(in crate::matching) fn bytes(&self) -> usize {
        size_of_val(self.pairs.as_slice()) + size_of_val(self.totals.as_slice())
    }

    /// The windows around the vertices of some blocks, whole lines: W of the `N` components, at most 12, that
    /// `row(block, c)` gives, W' of those from `WEIGHTED` on. `put` takes the windows of the lanes of a block.
    #[inline(always)]
    pub(super) fn along<S: Simd, const N: usize, const WEIGHTED: usize>(
        &mut self,
        simd: S,
        WideWindows { links, occupied, half_width, blocks }: WideWindows,
        row: &impl Fn(usize, usize) -> f32x8<S>,
        mut put: impl FnMut(usize, u8, [f32x8<S>; N], [f32x8<S>; 3]),
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
                put(block, run.lanes(block), plain, weighted);
            }
        }
    }

    /// The sums within block `at` of a run.
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
        let number = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let (before, here) = self.pairs.split_at_mut(at + 1);
        let (before, here) = (&mut before[at], &mut here[0]);
        let earlier = at.checked_sub(1).map_or([0.0; 2 * LANES], |at| self.totals[at]);
        let totals = &mut self.totals[at];
        for c in 0..N {
            let value = mask.select(row(c), zero);
            let sums = prefix(simd, value);
            sums.store_slice(&mut here[c][..LANES]);
            sums.store_slice(&mut here[c][LANES..]);
            totals[c] = here[c][LANES - 1];
            (sums + earlier[c]).store_slice(&mut before[c][LANES..]);
            if c >= WEIGHTED && c < WEIGHTED + 3 {
                let m = N + c - WEIGHTED;
                let moments = prefix(simd, value * number);
                moments.store_slice(&mut here[m][..LANES]);
                totals[m] = here[m][LANES - 1];
                // In the block after, lane 0 is lane 8.
                let moved = sums.mul_add(f32x8::splat(simd, LANES as f32), moments);
                (moved + earlier[m]).store_slice(&mut before[m][LANES..]);
            }
        }
        // Where no block follows, a pair ends with the total.
        for c in 0..N + 3 {
            here[c][LANES..].fill(totals[c]);
        }
    }

    /// The windows of block `at` of a run of `length` blocks.
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
        let end = if at + whole < length { &self.pairs[at + whole + 1] } else { &FAR };
        let start = if at >= whole { &self.pairs[at - whole] } else { &FAR };
        let between = self.between::<S, N, WEIGHTED>(simd, at, whole, length);
        let number = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
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
                weighted[c - WEIGHTED] = moment - plain[c] * number;
            }
        }
        (plain, weighted)
    }

    /// The totals of the blocks from `at - whole - 1` to `at + whole - 1`, those of moments counted from the start of
    /// block `at`.
    #[inline(always)]
    fn between<S: Simd, const N: usize, const WEIGHTED: usize>(
        &self,
        simd: S,
        at: usize,
        whole: usize,
        length: usize,
    ) -> [f32; 2 * LANES] {
        let zero = f32x8::splat(simd, 0.0);
        let (mut sums, mut levers) = ([zero; 2], [zero; 2]);
        let from = at.saturating_sub(whole + 1);
        for (block, totals) in (from..).zip(&self.totals[from..length.min(at + whole)]) {
            let distance = f32x8::splat(simd, LANES as f32 * (block as f32 - at as f32));
            for half in 0..2 {
                let totals = f32x8::from_slice(simd, &totals[half * LANES..][..LANES]);
                sums[half] += totals;
                levers[half] = totals.mul_add(distance, levers[half]);
            }
        }
        let (mut between, mut moved) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
        for half in 0..2 {
            sums[half].store_slice(&mut between[half * LANES..][..LANES]);
            levers[half].store_slice(&mut moved[half * LANES..][..LANES]);
        }
        for c in 0..3 {
            between[N + c] += moved[WEIGHTED + c];
        }
        between
    }
}

/// The sums of the lanes up to each lane.
#[inline(always)]
fn prefix<S: Simd>(simd: S, values: f32x8<S>) -> f32x8<S> {
    let zero = f32x8::splat(simd, 0.0);
    let pairs = values + simd.slide_f32x8::<7>(zero, values);
    let fours = pairs + simd.slide_f32x8::<6>(zero, pairs);
    fours + simd.slide_f32x8::<4>(zero, fours)
}
