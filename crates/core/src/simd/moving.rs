//! Points that move along straight lines.

use crate::simd::vector::Product;
use fearless_simd::{Simd, SimdBase, f32x4, f32x8, u8x32};

/// Byte indices that permute (x, y, z, 0) to (x, y, z, x).
const XYZX: [u8; 32] = byte_indices([0, 1, 2, 0]);

/// Point `p + lambda v`, with position `p` and direction `v`. It is stored as `(p, 0, v, 0)`, which fills a
/// register of eight f32 lanes.
///
/// The unit is cells. `p` is relative to the center of the point's component, so that f32 is accurate enough.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Moving([f32; 8]);

impl Moving {
    /// Creates a point from its position and direction.
    #[cfg(test)]
    pub(crate) fn new(position: [f32; 3], direction: [f32; 3]) -> Self {
        let mut moving = Self::default();
        moving.set_position(position);
        moving.set_direction(direction);
        moving
    }

    /// Returns the position `p`.
    #[inline]
    pub(crate) fn position(&self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// Returns the direction `v`.
    #[inline]
    pub(crate) fn direction(&self) -> [f32; 3] {
        [self.0[4], self.0[5], self.0[6]]
    }

    /// Sets the position `p`.
    #[inline]
    pub(crate) fn set_position(&mut self, [x, y, z]: [f32; 3]) {
        [self.0[0], self.0[1], self.0[2]] = [x, y, z];
    }

    /// Moves the point along its direction: `p += scale * v`.
    #[inline]
    pub(crate) fn advance(&mut self, scale: f32) {
        for k in 0..3 {
            self.0[k] += scale * self.0[4 + k];
        }
    }

    /// Sets the direction `v`.
    #[inline]
    pub(crate) fn set_direction(&mut self, [x, y, z]: [f32; 3]) {
        [self.0[4], self.0[5], self.0[6]] = [x, y, z];
    }

    /// Replaces the point by the lanes `(p, 0, v, 0)` of `moving`.
    #[inline(always)]
    pub(crate) fn store<S: Simd>(&mut self, moving: f32x8<S>) {
        moving.store_array(&mut self.0);
    }

    /// Returns the lanes `(p, 0, v, 0)`.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.0)
    }
}

/// Returns `p + lambda v + center` as `(x, y, z, x)`.
///
/// * `moving`: the lanes of a [`Moving`].
/// * `center`: the components (x, y, z, x).
#[inline(always)]
pub(crate) fn position_at<S: Simd>(simd: S, moving: f32x8<S>, lambda: f32, center: f32x4<S>) -> f32x4<S> {
    let (p, v) = simd.split_f32x8(permuted(simd, moving, XYZX));
    v.times_plus(f32x4::splat(simd, lambda), p) + center
}

/// Returns the byte indices that permute the four lanes of each half of a register: lane `i` of the result is
/// lane `order[i]`.
pub(crate) const fn byte_indices(order: [u8; 4]) -> [u8; 32] {
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
pub(crate) fn permuted<S: Simd>(simd: S, moving: f32x8<S>, order: [u8; 32]) -> f32x8<S> {
    simd.swizzle_dyn_within_blocks_f32x8(moving, u8x32::load_array(simd, order))
}
