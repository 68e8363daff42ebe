//! Defines `Vec4`, a three-component vector in one SIMD register.

use nalgebra::{Vector3, Vector4};

use crate::simd::lanes::Lanes;

/// Three-component vector, padded with a zero.
pub(super) type Vec4 = Vector4<f32>;

/// Converts a vector to f32 and pads it with a zero.
#[inline(always)]
pub(super) fn narrow(v: Vector3<f64>) -> Vec4 {
    Vec4::new(v.x as f32, v.y as f32, v.z as f32, 0.0)
}

/// Converts x, y and z to f64.
#[inline(always)]
pub(super) fn wide(v: &Vec4) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z).map(f64::from)
}

/// Returns the dot product, summed in the order x, y, z; `Vector4::dot` uses another order.
#[inline(always)]
pub(super) fn dot(a: &Vec4, b: &Vec4) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// Copies the vectors at `slots` in `lanes` to `vectors`, in the order of `slots`.
///
/// A slot is the index of a lattice vertex in `lanes`; see `simd::lanes`.
pub(super) fn read(vectors: &mut [Vec4], lanes: &Lanes<3>, slots: &[u32]) {
    for (vector, &slot) in vectors.iter_mut().zip(slots) {
        let [x, y, z] = lanes.get(slot);
        *vector = Vec4::new(x, y, z, 0.0);
    }
}
