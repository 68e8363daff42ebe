//! Computes products of 3-vectors. A vector is three registers x, y, z; each lane is an independent 3-vector.

use std::ops::{Add, Mul, Sub};

use nalgebra::Vector3;

/// Computes the scalar product a·b.
#[inline(always)]
pub(crate) fn dot<V: Copy + Add<Output = V> + Mul<Output = V>>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
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

/// Sums and differences of a product and a number. Both operations round: a fused multiply-add, which not every processor has,
/// would give other bits.
pub(crate) trait Product: Copy {
    /// Computes a·b + c.
    #[inline(always)]
    fn times_plus<B, C>(self, b: B, c: C) -> Self
    where
        Self: Mul<B, Output = Self> + Add<C, Output = Self>,
    {
        self * b + c
    }

    /// Computes a·b − c.
    #[inline(always)]
    fn times_minus<B, C>(self, b: B, c: C) -> Self
    where
        Self: Mul<B, Output = Self> + Sub<C, Output = Self>,
    {
        self * b - c
    }
}

impl<V: Copy> Product for V {}
