//! Eight rotations at a time: Newton's method on the quaternion with a Cayley step (Kugelstadt et al. 2018).
//!
//! With M = Rᵀ A, a = axial(M) and S = sym(M), a turn by ω in the body's frame changes the trace to
//!
//! ```text
//! tr(Rᵀ A) + ω·a - ½ ωᵀ H ω,    H = tr(S) I - S,
//! ```
//!
//! so Newton's step is H ω = a. A stationary point is the global maximum iff H is positive definite; without that
//! test Newton also settles on saddles, where the torque a vanishes as well.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::{columns, eigen};
use crate::lanes::LANES;

/// Steps before the lanes that are left go through the eigenvalue problem. A warm start needs one or two.
const STEPS: usize = 4;

/// The rotations of eight matrices given by columns, from the quaternions (rows x, y, z, w) of the step before,
/// which they replace. Only lanes in the bits of `occupied` are asked for. Returns the lanes that Newton did not
/// settle, as bits.
#[inline(always)]
pub(crate) fn solve<S: Simd>(
    simd: S,
    a: [f32x8<S>; 9],
    occupied: u8,
    quaternions: &mut [[f32; LANES]; 4],
) -> u8 {
    let warm = *quaternions;
    let mut q = warm.map(|row| f32x8::load_array(simd, row));
    let mut open = occupied;
    for _ in 0..STEPS {
        let (stepped, settled) = step(simd, a, q);
        q = stepped;
        open = occupied & !settled;
        if open == 0 {
            break;
        }
    }
    for (row, q) in quaternions.iter_mut().zip(q) {
        q.store_array(row);
    }
    if open != 0 {
        let a = a.map(|row| row.to_array());
        for lane in (0..LANES).filter(|lane| open >> lane & 1 != 0) {
            let best = eigen::rotation(a.map(|row| row[lane]), warm.map(|row| row[lane]));
            for (row, component) in quaternions.iter_mut().zip(best) {
                row[lane] = component;
            }
        }
    }
    open
}

/// One Newton step: the new quaternions, and the lanes that it brings to the maximum, as bits.
///
/// The torque after a step is of third order in ω. A lane has settled if H is positive definite with a margin
/// that the step cannot use up, and the torque to come is below 1e-6 of the smallest eigenvalue of H, for which
/// det H / (tr H / 2)² is a lower bound.
#[inline(always)]
fn step<S: Simd>(simd: S, a: [f32x8<S>; 9], q: [f32x8<S>; 4]) -> ([f32x8<S>; 4], u8) {
    let constant = |value: f32| f32x8::splat(simd, value);
    let r = columns(simd, q);
    let dot = |i: usize, j: usize| {
        r[3 * i].mul_add(a[3 * j], r[3 * i + 1].mul_add(a[3 * j + 1], r[3 * i + 2] * a[3 * j + 2]))
    };
    let (m00, m11, m22) = (dot(0, 0), dot(1, 1), dot(2, 2));
    let (m01, m10) = (dot(0, 1), dot(1, 0));
    let (m02, m20) = (dot(0, 2), dot(2, 0));
    let (m12, m21) = (dot(1, 2), dot(2, 1));

    let (t0, t1, t2) = (m21 - m12, m02 - m20, m10 - m01);
    let (h00, h11, h22) = (m11 + m22, m00 + m22, m00 + m11);
    let minus_half = constant(-0.5);
    let (h01, h02, h12) = ((m01 + m10) * minus_half, (m02 + m20) * minus_half, (m12 + m21) * minus_half);

    // The adjugate of H and its determinant.
    let c00 = h11 * h22 - h12 * h12;
    let c01 = h02 * h12 - h01 * h22;
    let c02 = h01 * h12 - h02 * h11;
    let c11 = h00 * h22 - h02 * h02;
    let c12 = h01 * h02 - h00 * h12;
    let c22 = h00 * h11 - h01 * h01;
    let det = h00 * c00 + h01 * c01 + h02 * c02;
    let half_trace = m00 + m11 + m22;

    let inverse = constant(1.0) / det;
    let w0 = (c00 * t0 + c01 * t1 + c02 * t2) * inverse;
    let w1 = (c01 * t0 + c11 * t1 + c12 * t2) * inverse;
    let w2 = (c02 * t0 + c12 * t1 + c22 * t2) * inverse;
    let square = w0 * w0 + w1 * w1 + w2 * w2;
    let angle = square.sqrt();

    let zero = constant(0.0);
    let cube = half_trace * half_trace * half_trace;
    let definite =
        half_trace.simd_gt(zero) & h00.simd_gt(zero) & c22.simd_gt(zero) & det.simd_gt(cube * constant(1e-4));
    let margin = (angle * cube).simd_lt(det * constant(0.02));
    let accurate = (angle * square * cube).simd_lt(det * constant(2.5e-7));
    let settled = definite & margin & accurate;

    // A step that is far off or not a number at all is dropped: the lane is not settled by it.
    let sane = square.simd_lt(constant(16.0));
    let half = constant(0.5);
    let (x, y, z) =
        (sane.select(w0 * half, zero), sane.select(w1 * half, zero), sane.select(w2 * half, zero));
    let [qx, qy, qz, qw] = q;
    let stepped = [
        qx + (qw * x + qy * z - qz * y),
        qy + (qw * y + qz * x - qx * z),
        qz + (qw * z + qx * y - qy * x),
        qw - (qx * x + qy * y + qz * z),
    ];
    let norm = stepped.iter().fold(zero, |sum, &c| c.mul_add(c, sum));
    let unit = constant(1.0) / norm.sqrt();
    (stepped.map(|c| c * unit), settled.to_bitmask() as u8)
}
