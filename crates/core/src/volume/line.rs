//! Points that move along straight lines, and their determinants, which are cubics in `lambda`.

use fearless_simd::{Simd, SimdBase, SimdFloat, f32x8, f64x4, u8x32};

/// Point `p + lambda v`, stored as `(p, 0, v, 0)` in one register of eight lanes.
///
/// The unit is cells. `p` is relative to a center near the body, so that f32 is accurate enough.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(super) struct Moving([f32; 8]);

impl Moving {
    /// Creates a point from its position and direction.
    #[cfg(test)]
    pub(super) fn new(place: [f32; 3], direction: [f32; 3]) -> Self {
        let mut moving = Self::default();
        moving.set_place(place);
        moving.set_direction(direction);
        moving
    }

    /// Returns `p`.
    #[inline]
    pub(super) fn place(&self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// Returns `v`.
    #[inline]
    pub(super) fn direction(&self) -> [f32; 3] {
        [self.0[4], self.0[5], self.0[6]]
    }

    #[inline]
    pub(super) fn set_place(&mut self, [x, y, z]: [f32; 3]) {
        [self.0[0], self.0[1], self.0[2]] = [x, y, z];
    }

    /// Moves the point: `p += scale * v`.
    #[inline]
    pub(super) fn advance(&mut self, scale: f32) {
        for k in 0..3 {
            self.0[k] += scale * self.0[4 + k];
        }
    }

    #[inline]
    pub(super) fn set_direction(&mut self, [x, y, z]: [f32; 3]) {
        [self.0[4], self.0[5], self.0[6]] = [x, y, z];
    }

    #[inline(always)]
    pub(super) fn store<S: Simd>(&mut self, moving: f32x8<S>) {
        moving.store_array(&mut self.0);
    }
}

/// Loads the points with these indices.
#[inline(always)]
pub(super) fn load<S: Simd, const N: usize>(simd: S, points: &[Moving], numbers: &[u32; N]) -> [f32x8<S>; N] {
    let mut loaded = [f32x8::splat(simd, 0.0); N];
    for k in 0..N {
        loaded[k] = f32x8::load_array_ref(simd, &points[numbers[k] as usize].0);
    }
    loaded
}

/// Vector `p + lambda v` in f64.
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

    /// Converts a point, with components in the order (x, y, z).
    #[inline(always)]
    pub(super) fn xyz(simd: S, moving: f32x8<S>) -> Self {
        let (p, v) = simd.widen_f32x8(moving);
        Self { p, v }
    }

    /// Converts a point, with components in the order (y, z, x).
    #[inline(always)]
    pub(super) fn yzx(simd: S, moving: f32x8<S>) -> Self {
        Self::xyz(simd, ordered(simd, moving, YZX))
    }

    /// Converts a point, with components in the order (z, x, y).
    #[inline(always)]
    pub(super) fn zxy(simd: S, moving: f32x8<S>) -> Self {
        Self::xyz(simd, ordered(simd, moving, ZXY))
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

const YZX: [u8; 32] = bytes([1, 2, 0, 3]);
const ZXY: [u8; 32] = bytes([2, 0, 1, 3]);

/// Returns the byte indices that permute the four lanes of each half of a register.
const fn bytes(order: [u8; 4]) -> [u8; 32] {
    let mut bytes = [0; 32];
    let mut i = 0;
    while i < 32 {
        bytes[i] = 4 * order[i % 16 / 4] + (i % 4) as u8;
        i += 1;
    }
    bytes
}

/// Permutes the components of `p` and `v`.
#[inline(always)]
fn ordered<S: Simd>(simd: S, moving: f32x8<S>, order: [u8; 32]) -> f32x8<S> {
    simd.swizzle_dyn_within_blocks_f32x8(moving, u8x32::load_array(simd, order))
}

/// Factor of a cross product: a vector in two component orders.
#[derive(Clone, Copy)]
pub(super) struct Arm<S: Simd> {
    xyz: Line<S>,
    yzx: Line<S>,
}

impl<S: Simd> Arm<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, moving: f32x8<S>) -> Self {
        Self { xyz: Line::xyz(simd, moving), yzx: Line::yzx(simd, moving) }
    }
}

/// Sum of determinants: the coefficient of each power of `lambda`, as the parts of three vector components.
#[derive(Clone, Copy)]
pub(super) struct Determinants<S: Simd>([f64x4<S>; 4]);

impl<S: Simd> Determinants<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self([f64x4::splat(simd, 0.0); 4])
    }

    /// Adds `det[a, b, c]`; `a` is in the order (z, x, y), which is that of the cross product.
    #[inline(always)]
    pub(super) fn add(&mut self, a: Line<S>, b: Arm<S>, c: Arm<S>) {
        let n0 = cross(b.xyz.p, b.yzx.p, c.xyz.p, c.yzx.p);
        let n1 = cross(b.xyz.p, b.yzx.p, c.xyz.v, c.yzx.v) + cross(b.xyz.v, b.yzx.v, c.xyz.p, c.yzx.p);
        let n2 = cross(b.xyz.v, b.yzx.v, c.xyz.v, c.yzx.v);
        let [c0, c1, c2, c3] = &mut self.0;
        *c0 = a.p.mul_add(n0, *c0);
        *c1 = a.p.mul_add(n1, a.v.mul_add(n0, *c1));
        *c2 = a.p.mul_add(n2, a.v.mul_add(n1, *c2));
        *c3 = a.v.mul_add(n2, *c3);
    }

    /// Returns the coefficients of the sum, that of `lambda^k` at index `k`.
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

/// Returns the first two coefficients of a determinant, at half the cost of [`Determinants`].
#[inline(always)]
pub(super) fn value_and_slope<S: Simd>(a: Line<S>, b: Arm<S>, c: Arm<S>) -> [f64; 2] {
    let n0 = cross(b.xyz.p, b.yzx.p, c.xyz.p, c.yzx.p);
    let n1 = cross(b.xyz.p, b.yzx.p, c.xyz.v, c.yzx.v) + cross(b.xyz.v, b.yzx.v, c.xyz.p, c.yzx.p);
    let [z0, x0, y0, _] = (a.p * n0).to_array();
    let [z1, x1, y1, _] = a.p.mul_add(n1, a.v * n0).to_array();
    [x0 + y0 + z0, x1 + y1 + z1]
}

/// Returns `a x b` in the order (z, x, y), from both vectors in the orders (x, y, z) and (y, z, x).
#[inline(always)]
fn cross<S: Simd>(a: f64x4<S>, a_yzx: f64x4<S>, b: f64x4<S>, b_yzx: f64x4<S>) -> f64x4<S> {
    a.mul_add(b_yzx, -(a_yzx * b))
}
