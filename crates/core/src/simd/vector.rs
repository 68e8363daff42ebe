//! Computes products of 3-vectors. A vector is three registers x, y, z; each lane is an independent 3-vector.

use std::ops::{Add, Mul, Sub};

use fearless_simd::{Simd, SimdFloat};
use nalgebra::Vector3;

/// Computes the scalar product a·b. Each product and each sum is rounded.
#[inline(always)]
pub(crate) fn dot<V: Copy + Add<Output = V> + Mul<Output = V>>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Computes the scalar product a·b with fused multiply-adds, which do not round the products.
#[inline(always)]
pub(crate) fn dot_fused<S: Simd, V: SimdFloat<S>>(a: [V; 3], b: [V; 3]) -> V {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Computes the cross product a × b.
#[inline(always)]
pub(crate) fn cross<V: Copy + Sub<Output = V> + Mul<Output = V>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Converts a vector to f64.
#[inline]
pub(crate) fn wide(v: [f32; 3]) -> Vector3<f64> {
    Vector3::from(v.map(f64::from))
}

/// Computes the product of the scalar s and the vector v.
#[inline(always)]
pub(crate) fn scaled<V: Copy + Mul<Output = V>>(s: V, v: [V; 3]) -> [V; 3] {
    [v[0] * s, v[1] * s, v[2] * s]
}
