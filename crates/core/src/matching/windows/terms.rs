//! What a window adds up: the terms of the cascade's passes and of their adjoints.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, mask32x8};

use super::wide::{BlockSums, WideWindows};
use crate::simd::lanes::{Row, store};

/// What a pass leaves.
pub(super) trait Windows<S: Simd>: Terms<S> {
    /// The windows around the vertices of whole lines, along the lanes: `put` takes those of a run in a block, and its
    /// lanes as bits.
    fn wide(
        simd: S,
        sums: &mut BlockSums,
        wide: WideWindows,
        row: &impl Fn(usize, usize) -> f32x8<S>,
        put: impl FnMut(usize, u8, Self),
    );
}

/// Sums of eight windows, built up vertex by vertex.
///
/// `row(c)` is component c of the vertex that is added, for the eight lanes of a block.
pub(super) trait Terms<S: Simd>: Copy {
    /// The sums of windows that hold their centers only.
    fn center(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self;

    /// Adds a vertex `offset` links away, in the lanes in the bits of `reach`.
    fn add(&mut self, simd: S, reach: u8, offset: f32, row: impl Fn(usize) -> f32x8<S>);

    /// Writes them down.
    fn store(self, rows: &mut [Row]);
}

/// Sums that are carried on from window to window.
pub(super) trait Running<S: Simd>: Terms<S> {
    /// Sums as they are stored.
    fn from_rows(simd: S, row: impl Fn(usize) -> f32x8<S>) -> Self;

    /// Sums as they were stored.
    #[inline(always)]
    fn load(simd: S, rows: &[Row]) -> Self {
        Self::from_rows(
            simd,
            #[inline(always)]
            |c| f32x8::load_array_ref(simd, &rows[c]),
        )
    }

    /// The same sums, with the next vertex along the axis for the center.
    fn recenterd(self) -> Self;
}

/// A forward pass: W of all `N` components, and W' of the first three.
#[derive(Clone, Copy)]
pub(super) struct Forward<S: Simd, const N: usize> {
    pub(super) plain: [f32x8<S>; N],
    pub(super) weighted: [f32x8<S>; 3],
}

/// An adjoint pass: W of the first `OUT` of `IN = OUT + 3` components, less W' of the last three
/// in the first three. Seen from the vertex, its offset from the region is the opposite of the region's from it.
#[derive(Clone, Copy)]
pub(super) struct Adjoint<S: Simd, const IN: usize, const OUT: usize> {
    pub(super) sums: [f32x8<S>; OUT],
}

/// The same with what a running sum needs besides: W of the last three components.
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
    fn add(&mut self, simd: S, reach: u8, offset: f32, row: impl Fn(usize) -> f32x8<S>) {
        let (mask, offset) = (lanes(simd, reach), f32x8::splat(simd, offset));
        let zero = f32x8::splat(simd, 0.0);
        for c in 0..N {
            let value = mask.select(row(c), zero);
            self.plain[c] += value;
            if c < 3 {
                self.weighted[c] = value.mul_add(offset, self.weighted[c]);
            }
        }
    }

    #[inline(always)]
    fn store(self, rows: &mut [Row]) {
        store(self.plain, rows);
        store(self.weighted, &mut rows[N..]);
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
    fn recenterd(mut self) -> Self {
        for c in 0..3 {
            self.weighted[c] -= self.plain[c];
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
    fn add(&mut self, simd: S, reach: u8, offset: f32, row: impl Fn(usize) -> f32x8<S>) {
        let (mask, back) = (lanes(simd, reach), f32x8::splat(simd, -offset));
        let zero = f32x8::splat(simd, 0.0);
        for c in 0..OUT {
            let mut value = row(c);
            if c < 3 {
                value = row(IN - 3 + c).mul_add(back, value);
            }
            self.sums[c] += mask.select(value, zero);
        }
    }

    #[inline(always)]
    fn store(self, rows: &mut [Row]) {
        store(self.sums, rows);
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
    fn add(&mut self, simd: S, reach: u8, offset: f32, row: impl Fn(usize) -> f32x8<S>) {
        let (mask, zero) = (lanes(simd, reach), f32x8::splat(simd, 0.0));
        for c in 0..3 {
            self.last[c] += mask.select(row(IN - 3 + c), zero);
        }
        self.adjoint.add(simd, reach, offset, row);
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
    fn recenterd(mut self) -> Self {
        for c in 0..3 {
            self.adjoint.sums[c] += self.last[c];
        }
        self
    }
}

impl<S: Simd, const N: usize> Windows<S> for Forward<S, N> {
    #[inline(always)]
    fn wide(
        simd: S,
        sums: &mut BlockSums,
        wide: WideWindows,
        row: &impl Fn(usize, usize) -> f32x8<S>,
        mut put: impl FnMut(usize, u8, Self),
    ) {
        sums.along::<S, N, 0>(
            simd,
            wide,
            row,
            #[inline(always)]
            |block, lanes, plain, weighted| put(block, lanes, Self { plain, weighted }),
        );
    }
}

impl<S: Simd, const IN: usize, const OUT: usize> Windows<S> for Adjoint<S, IN, OUT> {
    #[inline(always)]
    fn wide(
        simd: S,
        sums: &mut BlockSums,
        wide: WideWindows,
        row: &impl Fn(usize, usize) -> f32x8<S>,
        mut put: impl FnMut(usize, u8, Self),
    ) {
        // W' is that of the last three components.
        sums.along::<S, IN, OUT>(
            simd,
            wide,
            row,
            #[inline(always)]
            |block, lanes, plain, weighted| {
                let mut sums = [f32x8::splat(simd, 0.0); OUT];
                for c in 0..OUT {
                    sums[c] = if c < 3 { plain[c] - weighted[c] } else { plain[c] };
                }
                put(block, lanes, Self { sums });
            },
        );
    }
}

/// The lanes in the bits of `reach`.
#[inline(always)]
fn lanes<S: Simd>(simd: S, reach: u8) -> mask32x8<S> {
    mask32x8::from_bitmask(simd, u64::from(reach))
}
