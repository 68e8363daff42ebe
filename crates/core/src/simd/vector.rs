//! Products of 3-vectors in three registers, one vector for each lane.

use std::ops::{Add, Mul, Sub};

use fearless_simd::{Simd, SimdFloat};

/// Computes `a . b`; each product is rounded.
#[inline(always)]
pub(crate) fn dot<V: Copy + Add<Output = V> + Mul<Output = V>>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Computes `a . b` with fused multiply-adds.
#[inline(always)]
pub(crate) fn dot_fused<S: Simd, V: SimdFloat<S>>(a: [V; 3], b: [V; 3]) -> V {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Computes `a x b`.
#[inline(always)]
pub(crate) fn cross<V: Copy + Sub<Output = V> + Mul<Output = V>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Computes `s v`.
#[inline(always)]
pub(crate) fn scaled<V: Copy + Mul<Output = V>>(s: V, v: [V; 3]) -> [V; 3] {
    [v[0] * s, v[1] * s, v[2] * s]
}
