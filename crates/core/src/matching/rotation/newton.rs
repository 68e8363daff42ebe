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
use crate::lanes::{LANES, load, store};

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
    let mut q: [f32x8<S>; 4] = load(simd, &warm);
    let mut open = occupied;
    for _ in 0..STEPS {
        let (stepped, settled) = step(simd, a, q);
        q = stepped;
        open = occupied & !settled;
        if open == 0 {
            break;
        }
    }
    store(q, quaternions);
    if open != 0 {
        let mut rows = [[0.0; LANES]; 9];
        store(a, &mut rows);
        settle(&rows, open, &warm, quaternions);
    }
    open
}

/// The robust path for the lanes in the bits of `open`.
#[cold]
fn settle(a: &[[f32; LANES]; 9], open: u8, warm: &[[f32; LANES]; 4], quaternions: &mut [[f32; LANES]; 4]) {
    for lane in (0..LANES).filter(|lane| open >> lane & 1 != 0) {
        let best = eigen::rotation(a.map(|row| row[lane]), warm.map(|row| row[lane]));
        for (row, component) in quaternions.iter_mut().zip(best) {
            row[lane] = component;
        }
    }
}

/// One Newton step: the new quaternions, and the lanes that it brings to the maximum, as bits.
///
/// The torque after a step is of third order in ω. A lane has settled if H is positive definite with a margin
/// that the step cannot use up, and the torque to come is below 1e-6 of the smallest eigenvalue of H, for which
/// det H / (tr H / 2)² is a lower bound.
#[inline(always)]
fn step<S: Simd>(simd: S, a: [f32x8<S>; 9], q: [f32x8<S>; 4]) -> ([f32x8<S>; 4], u8) {
    let zero = f32x8::splat(simd, 0.0);
    let r = columns(simd, q);
    let mut m = [[zero; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            m[i][j] =
                r[3 * i].mul_add(a[3 * j], r[3 * i + 1].mul_add(a[3 * j + 1], r[3 * i + 2] * a[3 * j + 2]));
        }
    }
    let [[m00, m01, m02], [m10, m11, m12], [m20, m21, m22]] = m;

    let (t0, t1, t2) = (m21 - m12, m02 - m20, m10 - m01);
    let (h00, h11, h22) = (m11 + m22, m00 + m22, m00 + m11);
    let (h01, h02, h12) = ((m01 + m10) * -0.5, (m02 + m20) * -0.5, (m12 + m21) * -0.5);

    // The adjugate of H and its determinant.
    let c00 = h11 * h22 - h12 * h12;
    let c01 = h02 * h12 - h01 * h22;
    let c02 = h01 * h12 - h02 * h11;
    let c11 = h00 * h22 - h02 * h02;
    let c12 = h01 * h02 - h00 * h12;
    let c22 = h00 * h11 - h01 * h01;
    let det = h00 * c00 + h01 * c01 + h02 * c02;
    let half_trace = m00 + m11 + m22;

    let one = f32x8::splat(simd, 1.0);
    let inverse = one / det;
    let w0 = (c00 * t0 + c01 * t1 + c02 * t2) * inverse;
    let w1 = (c01 * t0 + c11 * t1 + c12 * t2) * inverse;
    let w2 = (c02 * t0 + c12 * t1 + c22 * t2) * inverse;
    let square = w0 * w0 + w1 * w1 + w2 * w2;
    let angle = square.sqrt();

    let cube = half_trace * half_trace * half_trace;
    let definite =
        half_trace.simd_gt(zero) & h00.simd_gt(zero) & c22.simd_gt(zero) & det.simd_gt(cube * 1e-4);
    let margin = (angle * cube).simd_lt(det * 0.02);
    let accurate = (angle * square * cube).simd_lt(det * 2.5e-7);
    let settled = definite & margin & accurate;

    // A step that is far off or not a number at all is dropped: the lane is not settled by it.
    let sane = square.simd_lt(f32x8::splat(simd, 16.0));
    let x = sane.select(w0 * 0.5, zero);
    let y = sane.select(w1 * 0.5, zero);
    let z = sane.select(w2 * 0.5, zero);
    let [qx, qy, qz, qw] = q;
    let sx = qx + (qw * x + qy * z - qz * y);
    let sy = qy + (qw * y + qz * x - qx * z);
    let sz = qz + (qw * z + qx * y - qy * x);
    let sw = qw - (qx * x + qy * y + qz * z);
    let unit = one / (sx * sx + sy * sy + sz * sz + sw * sw).sqrt();
    ([sx * unit, sy * unit, sz * unit, sw * unit], settled.to_bitmask() as u8)
}
