//! `Vec4`: x, y, z and a zero in one register.

use nalgebra::{Vector3, Vector4};

use crate::simd::lanes::Lanes;

/// A vector of three numbers, padded with a zero.
pub(crate) type Vec4 = Vector4<f32>;

/// The vector in f32, padded.
#[inline(always)]
pub(crate) fn narrow(v: Vector3<f64>) -> Vec4 {
    Vec4::new(v.x as f32, v.y as f32, v.z as f32, 0.0)
}

/// The vector in f64.
#[inline(always)]
pub(crate) fn wide(v: &Vec4) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z).map(f64::from)
}

/// The product of the first three numbers: a sum in this order, which that of `Vector4` is not.
#[inline(always)]
pub(super) fn dot(a: &Vec4, b: &Vec4) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Reads the vectors in some slots.
pub(super) fn read(vectors: &mut [Vec4], lanes: &Lanes<3>, slots: &[u32]) {
    for (vector, &slot) in vectors.iter_mut().zip(slots) {
        let [x, y, z] = lanes.get(slot);
        *vector = Vec4::new(x, y, z, 0.0);
    }
}
