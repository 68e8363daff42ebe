//! Vectors in the first three of four numbers, which fill a register.

use nalgebra::Vector3;

use crate::Lanes;

/// x, y, z, 0.
pub(super) type Quad = [f32; 4];

/// The vector in f32.
#[inline(always)]
pub(super) fn quad(v: Vector3<f64>) -> Quad {
    [v.x as f32, v.y as f32, v.z as f32, 0.0]
}

/// Reads the vectors in some slots.
pub(super) fn read(quads: &mut [Quad], lanes: &Lanes<3>, slots: &[u32]) {
    for (quad, &slot) in quads.iter_mut().zip(slots) {
        let [x, y, z] = lanes.get(slot);
        *quad = [x, y, z, 0.0];
    }
}

/// The same numbers in f64.
#[inline(always)]
pub(super) fn vector(q: &Quad) -> Vector3<f64> {
    Vector3::new(q[0], q[1], q[2]).map(f64::from)
}

/// a += b s.
#[inline(always)]
pub(super) fn add(a: &mut Quad, b: &Quad, s: f32) {
    for c in 0..4 {
        a[c] += b[c] * s;
    }
}

/// a - b.
#[inline(always)]
pub(super) fn difference(a: &Quad, b: &Quad) -> Quad {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

#[inline(always)]
pub(super) fn dot(a: &Quad, b: &Quad) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
