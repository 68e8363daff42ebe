//! Defines the window sums that forward and adjoint passes compute for eight lanes, and how a vertex is added
//! to them. W is the plain and W' the offset-weighted sum over a window.

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8, mask32x8};

use crate::simd::has_masked_arithmetic;
use crate::simd::lanes::{Row, store};
use crate::simd::vector::Product;

/// The sums of eight windows, one in each lane. Vertices are added one at a time, one vertex to each window.
///
/// `row(c)` is component `c` of the vertices that are added.
pub(super) trait Terms<S: Simd>: Copy {
    /// Returns the sums of windows that contain only their center vertices.
    fn center(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self;

    /// Adds the vertices at `offset` links from the centers, in the lanes of the bit mask `linked`.
    fn add(&mut self, simd: S, linked: u8, offset: f32, row: impl Fn(usize) -> f32x8<S>);

    /// Writes the sums to `rows`, one row for each number of a vertex.
    fn store(self, rows: &mut [Row]);
}

/// The sums of windows of two vertices, for regions of one cell: the center of a window is halfway between them.
pub(super) trait PairTerms<S: Simd>: Terms<S> {
    /// Whether the pass is adjoint: the vertex in the place of a window is then its upper one, and
    /// otherwise its lower one.
    const IS_ADJOINT: bool;

    /// Returns the sums of windows that contain only one vertex, at `offset` links from the center.
    fn single(simd: S, offset: f32, row: impl Fn(usize) -> f32x8<S>) -> Self;
}

/// Running sums: sums that continue from the windows of a block to the windows of the next block on the axis.
pub(super) trait Running<S: Simd>: Terms<S> {
    /// Creates sums from the rows that [`Terms::store`] has written; `row(c)` is row `c`.
    fn from_rows(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self;

    /// Loads sums from the rows that [`Terms::store`] has written.
    #[inline(always)]
    fn load(simd: S, rows: &[Row]) -> Self {
        Self::from_rows(
            simd,
            #[inline(always)]
            |c| f32x8::load_array_ref(simd, &rows[c]),
        )
    }

    /// Returns the sums of the same vertices about the vertex two links further on the axis as the center.
    fn recentered(self) -> Self;
}

/// The sums of a forward pass: W of all `N` components of the input, and W' of the first three components.
#[derive(Clone, Copy)]
pub(super) struct Forward<S: Simd, const N: usize> {
    pub(super) plain: [f32x8<S>; N],
    pub(super) weighted: [f32x8<S>; 3],
}

/// The sums of an adjoint pass: W of the first `OUT` of the `IN = OUT + 3` components of the input, where W'
/// of the last three components is subtracted from W of the first three. The sign is negative because a
/// window here is centered at a vertex and contains the centers of regions: the offset of the vertex from the
/// center of a region is the negative of the offset in the window.
#[derive(Clone, Copy)]
pub(super) struct Adjoint<S: Simd, const IN: usize, const OUT: usize> {
    pub(super) sums: [f32x8<S>; OUT],
}

/// The running sums of an adjoint pass: the sums of [`Adjoint`], and W of the last three components of the
/// input, which [`Running::recentered`] needs.
#[derive(Clone, Copy)]
pub(super) struct RunningAdjoint<S: Simd, const IN: usize, const OUT: usize> {
    pub(super) adjoint: Adjoint<S, IN, OUT>,
    last: [f32x8<S>; 3],
}

impl<S: Simd, const IN: usize, const OUT: usize> From<RunningAdjoint<S, IN, OUT>> for Adjoint<S, IN, OUT> {
    #[inline(always)]
    fn from(running: RunningAdjoint<S, IN, OUT>) -> Self {
        running.adjoint
    }
}

impl<S: Simd, const N: usize> Terms<S> for Forward<S, N> {
    #[inline(always)]
    fn center(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self {
        let zero = f32x8::splat(simd, 0.0);
        let mut sums = Self { plain: [zero; N], weighted: [zero; 3] };
        for c in 0..N {
            sums.plain[c] = row(c);
        }
        sums
    }

    #[inline(always)]
    fn add(&mut self, simd: S, linked: u8, offset: f32, row: impl Fn(usize) -> f32x8<S>) {
        let (mask, offset) = (lane_mask(simd, linked), f32x8::splat(simd, offset));
        if has_masked_arithmetic(simd) {
            for c in 0..N {
                let (value, sum) = (row(c), self.plain[c]);
                self.plain[c] = mask.select(sum + value, sum);
                if c < 3 {
                    let sum = self.weighted[c];
                    self.weighted[c] = mask.select(value.times_plus(offset, sum), sum);
                }
            }
        } else {
            let zero = f32x8::splat(simd, 0.0);
            for c in 0..N {
                let value = mask.select(row(c), zero);
                self.plain[c] += value;
                if c < 3 {
                    self.weighted[c] = value.times_plus(offset, self.weighted[c]);
                }
            }
        }
    }

    #[inline(always)]
    fn store(self, rows: &mut [Row]) {
        store(self.plain, rows);
        store(self.weighted, &mut rows[N..]);
    }
}

impl<S: Simd, const N: usize> PairTerms<S> for Forward<S, N> {
    const IS_ADJOINT: bool = false;

    #[inline(always)]
    fn single(simd: S, offset: f32, row: impl Fn(usize) -> f32x8<S>) -> Self {
        let mut sums = Self::center(simd, row);
        for c in 0..3 {
            sums.weighted[c] = sums.plain[c] * offset;
        }
        sums
    }
}

impl<S: Simd, const N: usize> Running<S> for Forward<S, N> {
    #[inline(always)]
    fn from_rows(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self {
        let mut sums = Self::center(simd, &row);
        for c in 0..3 {
            sums.weighted[c] = row(N + c);
        }
        sums
    }

    #[inline(always)]
    fn recentered(mut self) -> Self {
        for c in 0..3 {
            self.weighted[c] -= self.plain[c] + self.plain[c];
        }
        self
    }
}

impl<S: Simd, const IN: usize, const OUT: usize> Terms<S> for Adjoint<S, IN, OUT> {
    #[inline(always)]
    fn center(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self {
        let mut sums = [f32x8::splat(simd, 0.0); OUT];
        for c in 0..OUT {
            sums[c] = row(c);
        }
        Self { sums }
    }

    #[inline(always)]
    fn add(&mut self, simd: S, linked: u8, offset: f32, row: impl Fn(usize) -> f32x8<S>) {
        let (mask, negative_offset) = (lane_mask(simd, linked), f32x8::splat(simd, -offset));
        let zero = f32x8::splat(simd, 0.0);
        for c in 0..OUT {
            let mut value = row(c);
            if c < 3 {
                value = row(IN - 3 + c).times_plus(negative_offset, value);
            }
            let sum = self.sums[c];
            self.sums[c] = if has_masked_arithmetic(simd) {
                mask.select(sum + value, sum)
            } else {
                sum + mask.select(value, zero)
            };
        }
    }

    #[inline(always)]
    fn store(self, rows: &mut [Row]) {
        store(self.sums, rows);
    }
}

impl<S: Simd, const IN: usize, const OUT: usize> PairTerms<S> for Adjoint<S, IN, OUT> {
    const IS_ADJOINT: bool = true;

    #[inline(always)]
    fn single(simd: S, offset: f32, row: impl Fn(usize) -> f32x8<S>) -> Self {
        let mut sums = Self::center(simd, &row);
        for c in 0..3 {
            sums.sums[c] = row(IN - 3 + c).times_plus(f32x8::splat(simd, -offset), sums.sums[c]);
        }
        sums
    }
}

impl<S: Simd, const IN: usize, const OUT: usize> Terms<S> for RunningAdjoint<S, IN, OUT> {
    #[inline(always)]
    fn center(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self {
        let mut last = [f32x8::splat(simd, 0.0); 3];
        for c in 0..3 {
            last[c] = row(IN - 3 + c);
        }
        Self { adjoint: Adjoint::center(simd, row), last }
    }

    #[inline(always)]
    fn add(&mut self, simd: S, linked: u8, offset: f32, row: impl Fn(usize) -> f32x8<S>) {
        let (mask, zero) = (lane_mask(simd, linked), f32x8::splat(simd, 0.0));
        for c in 0..3 {
            self.last[c] += mask.select(row(IN - 3 + c), zero);
        }
        self.adjoint.add(simd, linked, offset, row);
    }

    #[inline(always)]
    fn store(self, rows: &mut [Row]) {
        store(self.adjoint.sums, rows);
        store(self.last, &mut rows[OUT..]);
    }
}

impl<S: Simd, const IN: usize, const OUT: usize> Running<S> for RunningAdjoint<S, IN, OUT> {
    #[inline(always)]
    fn from_rows(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self {
        Self::center(simd, row)
    }

    #[inline(always)]
    fn recentered(mut self) -> Self {
        for c in 0..3 {
            self.adjoint.sums[c] += self.last[c] + self.last[c];
        }
        self
    }
}

/// Converts a bit mask of lanes to a mask register.
#[inline(always)]
fn lane_mask<S: Simd>(simd: S, lanes: u8) -> mask32x8<S> {
    mask32x8::from_bitmask(simd, u64::from(lanes))
}
