//! Determinants of points that move along straight lines. They are cubics in the scale `lambda`.
//!
//! `det[a, b, c]` is the scalar triple product `a . (b × c)`. In memory the components of vectors lie in SIMD
//! lanes.

use fearless_simd::{Simd, SimdBase, f32x8, f64x4};

pub(super) use crate::simd::moving::Moving;
use crate::simd::moving::{byte_indices, permuted};
use crate::simd::vector::Product;

/// Loads the points with the indices `indices`.
#[inline(always)]
pub(super) fn load<S: Simd, const N: usize>(simd: S, points: &[Moving], indices: &[u32; N]) -> [f32x8<S>; N] {
    let mut loaded = [f32x8::splat(simd, 0.0); N];
    for k in 0..N {
        loaded[k] = points[indices[k] as usize].load(simd);
    }
    loaded
}

/// Vector `p + lambda v` in f64. The fourth lane is 0.
#[derive(Clone, Copy)]
pub(super) struct Line<S: Simd> {
    p: f64x4<S>,
    v: f64x4<S>,
}

impl<S: Simd> Line<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        let zero = f64x4::splat(simd, 0.0);
        Self { p: zero, v: zero }
    }

    /// Converts a point to f64, with components in the order (x, y, z).
    #[inline(always)]
    pub(super) fn xyz(simd: S, moving: f32x8<S>) -> Self {
        let (p, v) = simd.widen_f32x8(moving);
        Self { p, v }
    }

    /// Converts a point to f64, with components in the order (y, z, x).
    #[inline(always)]
    pub(super) fn yzx(simd: S, moving: f32x8<S>) -> Self {
        Self::xyz(simd, permuted(simd, moving, YZX))
    }

    /// Converts a point to f64, with components in the order (z, x, y).
    #[inline(always)]
    pub(super) fn zxy(simd: S, moving: f32x8<S>) -> Self {
        Self::xyz(simd, permuted(simd, moving, ZXY))
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self { p: self.p + other.p, v: self.v + other.v }
    }

    /// Returns `self + factor * other`.
    #[inline(always)]
    pub(super) fn plus_times(self, other: Self, factor: f64x4<S>) -> Self {
        Self { p: other.p.times_plus(factor, self.p), v: other.v.times_plus(factor, self.v) }
    }
}

/// Byte indices that permute (x, y, z, 0) to (y, z, x, 0).
const YZX: [u8; 32] = byte_indices([1, 2, 0, 3]);
/// Byte indices that permute (x, y, z, 0) to (z, x, y, 0).
const ZXY: [u8; 32] = byte_indices([2, 0, 1, 3]);

/// Factor of a cross product: a vector in the two component orders that the product needs.
#[derive(Clone, Copy)]
pub(super) struct CrossFactor<S: Simd> {
    xyz: Line<S>,
    yzx: Line<S>,
}

impl<S: Simd> CrossFactor<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, moving: f32x8<S>) -> Self {
        Self { xyz: Line::xyz(simd, moving), yzx: Line::yzx(simd, moving) }
    }
}

/// Sum of determinants `det[a, b, c]`, each a cubic in `lambda`.
///
/// The element at index `k` belongs to `lambda^k`. Its lanes have the terms of the scalar product of `a` and
/// `b × c`, in the order (z, x, y); their sum is the coefficient.
#[derive(Clone, Copy)]
pub(super) struct Determinants<S: Simd>([f64x4<S>; 4]);

impl<S: Simd> Determinants<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self([f64x4::splat(simd, 0.0); 4])
    }

    /// Adds `det[a, b, c]`. The components of `a` are in the order (z, x, y), which is the order in which
    /// [`cross`] returns the cross product.
    #[inline(always)]
    pub(super) fn add(&mut self, a: Line<S>, b: CrossFactor<S>, c: CrossFactor<S>) {
        let n0 = cross(b.xyz.p, b.yzx.p, c.xyz.p, c.yzx.p);
        let n1 = cross(b.xyz.p, b.yzx.p, c.xyz.v, c.yzx.v) + cross(b.xyz.v, b.yzx.v, c.xyz.p, c.yzx.p);
        let n2 = cross(b.xyz.v, b.yzx.v, c.xyz.v, c.yzx.v);
        let [c0, c1, c2, c3] = &mut self.0;
        *c0 = a.p.times_plus(n0, *c0);
        *c1 = a.p.times_plus(n1, a.v.times_plus(n0, *c1));
        *c2 = a.p.times_plus(n2, a.v.times_plus(n1, *c2));
        *c3 = a.v.times_plus(n2, *c3);
    }

    /// Returns the coefficients of the sum, with the coefficient of `lambda^k` at index `k`.
    #[inline(always)]
    pub(super) fn coefficients(self) -> [f64; 4] {
        let mut coefficients = [0.0; 4];
        for k in 0..4 {
            let [z, x, y, _] = self.0[k].to_array();
            coefficients[k] = x + y + z;
        }
        coefficients
    }
}

/// Sum of determinants `det[a, b, c]` as [`Determinants`], at half the cost: the terms are computed in f32. They are
/// added in f32 up to the next [`flush`](Self::flush), and then in f64.
///
/// The error comes from positions in f32, whose differences are the edges `b` and `c`. Coordinates above 1e12 cells can
/// overflow; the coefficients are then not finite.
#[derive(Clone, Copy)]
pub(super) struct FastDeterminants<S: Simd> {
    /// The sums up to the last flush.
    total: Determinants<S>,
    /// Terms since the last flush of the coefficients of `lambda^0`, then of `lambda^3`.
    outer: f32x8<S>,
    /// Terms since the last flush of the coefficients of `lambda^1`, then of `lambda^2`.
    inner: f32x8<S>,
}

impl<S: Simd> FastDeterminants<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        let zero = f32x8::splat(simd, 0.0);
        Self { total: Determinants::zero(simd), outer: zero, inner: zero }
    }

    /// Adds `det[a, b, c]`. All three are lanes `(p, 0, v, 0)` of a [`Moving`].
    #[inline(always)]
    pub(super) fn add(&mut self, simd: S, a: f32x8<S>, b: f32x8<S>, c: f32x8<S>) {
        let [like, mixed] = cross_products(simd, b, c);
        let a = permuted(simd, a, ZXY);
        self.outer = a.times_plus(like, self.outer);
        self.inner =
            a.times_plus(mixed + swapped(simd, mixed), swapped(simd, a).times_plus(like, self.inner));
    }

    /// Adds the terms since the last flush in f64.
    #[inline(always)]
    pub(super) fn flush(&mut self, simd: S) {
        let ((c0, c3), (c1, c2)) = (simd.widen_f32x8(self.outer), simd.widen_f32x8(self.inner));
        let sums = [c0, c1, c2, c3];
        for k in 0..4 {
            self.total.0[k] += sums[k];
        }
        *self = Self { total: self.total, ..Self::zero(simd) };
    }

    /// Returns the coefficients of the sum up to the last flush, with the coefficient of `lambda^k` at index `k`.
    #[inline(always)]
    pub(super) fn coefficients(self) -> [f64; 4] {
        self.total.coefficients()
    }
}

/// Exchanges `p` and `v`.
#[inline(always)]
fn swapped<S: Simd>(simd: S, moving: f32x8<S>) -> f32x8<S> {
    simd.slide_f32x8::<4>(moving, moving)
}

/// Returns the value of `det[a, b, c]` at `lambda = 0` and its derivative there. All three are lanes `(p, 0, v, 0)` of
/// a [`Moving`].
#[inline(always)]
pub(super) fn value_and_slope<S: Simd>(simd: S, a: f32x8<S>, b: f32x8<S>, c: f32x8<S>) -> [f32; 2] {
    let [like, mixed] = cross_products(simd, b, c);
    let a = permuted(simd, a, ZXY);
    let [z0, x0, y0, ..] = (a * like).to_array();
    let [z1, x1, y1, ..] = a.times_plus(mixed + swapped(simd, mixed), swapped(simd, a) * like).to_array();
    [x0 + y0 + z0, x1 + y1 + z1]
}

/// Returns cross products of the lanes `(p, 0, v, 0)` of two [`Moving`]: `p × p` and `v × v` in the halves of the first
/// result, `p × v` and `v × p` in those of the second. Components are in the order (z, x, y).
#[inline(always)]
fn cross_products<S: Simd>(simd: S, b: f32x8<S>, c: f32x8<S>) -> [f32x8<S>; 2] {
    let (b_yzx, c_yzx) = (permuted(simd, b, YZX), permuted(simd, c, YZX));
    let like = b.times_minus(c_yzx, b_yzx * c);
    [like, b.times_minus(swapped(simd, c_yzx), b_yzx * swapped(simd, c))]
}

/// Returns `a × b` with components in the order (z, x, y). `a`, `b`: components in the order (x, y, z);
/// `a_yzx`, `b_yzx`: components in the order (y, z, x).
#[inline(always)]
fn cross<S: Simd>(a: f64x4<S>, a_yzx: f64x4<S>, b: f64x4<S>, b_yzx: f64x4<S>) -> f64x4<S> {
    a.times_plus(b_yzx, -(a_yzx * b))
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::simd::level;

    /// Returns the coefficients of the sum of the determinants of groups of three points, in f64 and in f32.
    fn coefficients(points: &[Moving]) -> [[f64; 4]; 2] {
        dispatch!(level(), simd => {
            let (mut sum, mut fast) = (Determinants::zero(simd), FastDeterminants::zero(simd));
            for groups in points.chunks(3 * 8) {
                for group in groups.chunks_exact(3) {
                    let [a, b, c] = load(simd, group, &[0, 1, 2]);
                    sum.add(Line::zxy(simd, a), CrossFactor::new(simd, b), CrossFactor::new(simd, c));
                    fast.add(simd, a, b, c);
                }
                fast.flush(simd);
            }
            [sum.coefficients(), fast.coefficients()]
        })
    }

    #[test]
    fn fast_determinants_agree_with_f64() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 20) as f32 - 8.0
        };
        let count = 20;
        let mut vector = || std::array::from_fn(|_| random());
        let points: Vec<_> = (0..3 * count).map(|_| Moving::new(vector(), vector())).collect();
        let [exact, fast] = coefficients(&points);
        // At most 18 products of three numbers up to 8 per determinant, each rounded in two products, three sums of a
        // determinant and eight sums of determinants.
        let bound = f64::from(count) * 18.0 * 512.0 * 13.0 * f64::from(f32::EPSILON) / 2.0;
        for (exact, fast) in exact.into_iter().zip(fast) {
            assert!((exact - fast).abs() < bound && exact.abs() > 10.0 * bound, "{exact} {fast} {bound}");
        }
        // A term that overflows shows.
        let far = [[1e30, 2e30, 0.0], [3e30, 0.0, 1e30], [0.0, 1e30, 2e30]].map(|p| Moving::new(p, [0.0; 3]));
        assert!(coefficients(&far)[1].iter().any(|c| !c.is_finite()));
        assert!(coefficients(&far)[0].iter().all(|c| c.is_finite()));
    }
}
