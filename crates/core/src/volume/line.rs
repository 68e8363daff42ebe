//! Points that move along straight lines, and their determinants, which are cubics in the scale `lambda`.
//!
//! `det[a, b, c]` is the scalar triple product `a . (b × c)`. In memory the components of vectors lie in SIMD
//! lanes.

use fearless_simd::{Simd, SimdBase, SimdFloat, f32x8, f64x4, u8x32};

/// Point `p + lambda v`, with position `p` and direction `v`. It is stored as `(p, 0, v, 0)`, which fills a
/// register of eight f32 lanes.
///
/// The unit is cells. `p` is relative to the center of the point's component, so that f32 is accurate enough.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Moving([f32; 8]);

impl Moving {
    /// Creates a point from its position and direction.
    #[cfg(test)]
    pub(super) fn new(position: [f32; 3], direction: [f32; 3]) -> Self {
        let mut moving = Self::default();
        moving.set_position(position);
        moving.set_direction(direction);
        moving
    }

    /// Returns the position `p`.
    #[inline]
    pub(super) fn position(&self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// Returns the direction `v`.
    #[inline]
    pub(super) fn direction(&self) -> [f32; 3] {
        [self.0[4], self.0[5], self.0[6]]
    }

    /// Sets the position `p`.
    #[inline]
    pub(super) fn set_position(&mut self, [x, y, z]: [f32; 3]) {
        [self.0[0], self.0[1], self.0[2]] = [x, y, z];
    }

    /// Moves the point along its direction: `p += scale * v`.
    #[inline]
    pub(super) fn advance(&mut self, scale: f32) {
        for k in 0..3 {
            self.0[k] += scale * self.0[4 + k];
        }
    }

    /// Sets the direction `v`.
    #[inline]
    pub(super) fn set_direction(&mut self, [x, y, z]: [f32; 3]) {
        [self.0[4], self.0[5], self.0[6]] = [x, y, z];
    }

    /// Replaces the point by the lanes `(p, 0, v, 0)` of `moving`.
    #[inline(always)]
    pub(super) fn store<S: Simd>(&mut self, moving: f32x8<S>) {
        moving.store_array(&mut self.0);
    }
}

/// Loads the points with the indices `indices`.
#[inline(always)]
pub(super) fn load<S: Simd, const N: usize>(simd: S, points: &[Moving], indices: &[u32; N]) -> [f32x8<S>; N] {
    let mut loaded = [f32x8::splat(simd, 0.0); N];
    for k in 0..N {
        loaded[k] = f32x8::load_array_ref(simd, &points[indices[k] as usize].0);
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
        Self { p: other.p.mul_add(factor, self.p), v: other.v.mul_add(factor, self.v) }
    }
}

/// Byte indices that permute (x, y, z, 0) to (y, z, x, 0).
const YZX: [u8; 32] = byte_indices([1, 2, 0, 3]);
/// Byte indices that permute (x, y, z, 0) to (z, x, y, 0).
const ZXY: [u8; 32] = byte_indices([2, 0, 1, 3]);

/// Returns the byte indices that permute the four lanes of each half of a register: lane `i` of the result is
/// lane `order[i]`.
const fn byte_indices(order: [u8; 4]) -> [u8; 32] {
    let mut bytes = [0; 32];
    let mut i = 0;
    while i < 32 {
        bytes[i] = 4 * order[i % 16 / 4] + (i % 4) as u8;
        i += 1;
    }
    bytes
}

/// Permutes the components of `p` and of `v`. `order`: byte indices.
#[inline(always)]
fn permuted<S: Simd>(simd: S, moving: f32x8<S>, order: [u8; 32]) -> f32x8<S> {
    simd.swizzle_dyn_within_blocks_f32x8(moving, u8x32::load_array(simd, order))
}

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
        *c0 = a.p.mul_add(n0, *c0);
        *c1 = a.p.mul_add(n1, a.v.mul_add(n0, *c1));
        *c2 = a.p.mul_add(n2, a.v.mul_add(n1, *c2));
        *c3 = a.v.mul_add(n2, *c3);
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

/// Returns the value of `det[a, b, c]` at `lambda = 0` and its derivative there, at half the cost of
/// [`Determinants`]. The components of `a` are in the order (z, x, y).
#[inline(always)]
pub(super) fn value_and_slope<S: Simd>(a: Line<S>, b: CrossFactor<S>, c: CrossFactor<S>) -> [f64; 2] {
    let n0 = cross(b.xyz.p, b.yzx.p, c.xyz.p, c.yzx.p);
    let n1 = cross(b.xyz.p, b.yzx.p, c.xyz.v, c.yzx.v) + cross(b.xyz.v, b.yzx.v, c.xyz.p, c.yzx.p);
    let [z0, x0, y0, _] = (a.p * n0).to_array();
    let [z1, x1, y1, _] = a.p.mul_add(n1, a.v * n0).to_array();
    [x0 + y0 + z0, x1 + y1 + z1]
}

/// Returns `a × b` with components in the order (z, x, y). `a`, `b`: components in the order (x, y, z);
/// `a_yzx`, `b_yzx`: components in the order (y, z, x).
#[inline(always)]
fn cross<S: Simd>(a: f64x4<S>, a_yzx: f64x4<S>, b: f64x4<S>, b_yzx: f64x4<S>) -> f64x4<S> {
    a.mul_add(b_yzx, -(a_yzx * b))
}
