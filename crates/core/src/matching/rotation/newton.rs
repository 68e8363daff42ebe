//! Computes the rotations of two blocks of eight lanes by Newton's method on the quaternion, with a Cayley
//! step (Kugelstadt et al. 2018). An eigenvalue test detects whether a solution is the global maximum.
//!
//! Let M = Rᵀ A, a = (M₃₂ - M₂₃, M₁₃ - M₃₁, M₂₁ - M₁₂), S = (M + Mᵀ)/2, and I the identity matrix. A further
//! rotation by the small rotation vector ω, in the frame of R, changes the trace tr(Rᵀ A) to
//!
//! ```text
//! tr(Rᵀ A) + ω·a - ½ ωᵀ H ω,    H = tr(S) I - S,
//! ```
//!
//! up to terms of third order in ω. So Newton's step solves H ω = a. Here the step has one more term (see
//! [`step`]). At a stationary point, the vector a is zero. A stationary point is the unique global maximum
//! iff all eigenvalues of H are positive. Without this eigenvalue test, Newton's method would also accept
//! saddle points.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16};

use super::columns::columns;
use super::davenport;
use crate::simd::lanes::LANES;
use crate::simd::vector::{Product, scaled};

/// Maximum number of Newton steps. Lanes that have not converged after these steps use the fallback: an
/// eigenvalue problem in f64. From a warm start, one or two steps are sufficient.
const STEPS: usize = 4;

/// Upper limit of |u| cond(H) for convergence, where cond(H) = |H| |H⁻¹|. The step rotates by the angle
/// 2 arctan |u|, approximately 2 |u|. This changes H by approximately 2 |u| |H|, so that below this limit H
/// stays positive definite.
const MARGIN: f32 = 0.1;

/// Upper limit of the error of u for convergence: the rounding level of f32.
const ACCURACY: f32 = 1e-7;

/// Computes the rotations of the matrices A of two blocks, one matrix in each lane. `a` has the entries of
/// the matrices, column by column. `warm` has the warm start: the quaternions (x, y, z, w) of the previous
/// step.
///
/// `active` is the bit mask of the lanes to solve. `collapsed` is the bit mask of the lanes whose matrix has
/// no rotation. Returns the quaternions, and the bit mask of the active lanes for which Newton's method did
/// not converge; collapsed lanes count as not converged. The fallback computes these lanes; the result of a
/// collapsed lane is the warm start.
#[inline(always)]
pub(in crate::matching) fn solve<S: Simd>(
    simd: S,
    a: [f32x16<S>; 9],
    warm: [f32x16<S>; 4],
    active: u16,
    collapsed: u16,
) -> ([f32x16<S>; 4], u16) {
    let mut q = warm;
    let mut unconverged = active;
    for _ in 0..STEPS {
        let (stepped, converged) = step(simd, a, q);
        q = stepped;
        unconverged = active & !(converged & !collapsed);
        if unconverged == 0 {
            return (q, 0);
        }
    }
    let mut rows = [[0.0; 2 * LANES]; 9];
    let (mut previous, mut best) = ([[0.0; 2 * LANES]; 4], [[0.0; 2 * LANES]; 4]);
    for c in 0..9 {
        a[c].store_array(&mut rows[c]);
    }
    for c in 0..4 {
        warm[c].store_array(&mut previous[c]);
        q[c].store_array(&mut best[c]);
    }
    solve_in_f64(&rows, unconverged, collapsed, &previous, &mut best);
    for c in 0..4 {
        q[c] = f32x16::load_array_ref(simd, &best[c]);
    }
    (q, unconverged)
}

/// Solves the lanes of the bit mask `unconverged` by the fallback: an eigenvalue problem in f64.
#[cold]
fn solve_in_f64(
    a: &[[f32; 2 * LANES]; 9],
    unconverged: u16,
    collapsed: u16,
    warm: &[[f32; 2 * LANES]; 4],
    quaternions: &mut [[f32; 2 * LANES]; 4],
) {
    for lane in (0..2 * LANES).filter(|lane| unconverged >> lane & 1 != 0) {
        let matrix = if collapsed >> lane & 1 != 0 { [0.0; 9] } else { a.map(|row| row[lane]) };
        let best = davenport::rotation(matrix, warm.map(|row| row[lane]));
        for (row, component) in quaternions.iter_mut().zip(best) {
            row[lane] = component;
        }
    }
}

/// Computes one Newton step. Returns the new quaternions, and the bit mask of the lanes that have converged
/// to the global maximum.
///
/// The step multiplies the quaternion by (1, u), the quaternion with the scalar part 1 and the vector part u,
/// and normalizes the product. The result is stationary if (2 H + δ I) u = a, with δ = a·u: this is
/// Davenport's eigenvalue equation in the frame of R. Newton's step u₀ = (2 H)⁻¹ a omits δ. Here one term of
/// the series in δ is added: u = u₀ - δ (2 H)⁻¹ u₀. The error is then of fifth order in |u|: it is
/// approximately ρ² |u|, with ρ = δ |(2 H)⁻¹|.
///
/// A lane has converged if this error is below [`ACCURACY`] and H passes the eigenvalue test: H is positive
/// definite, and stays positive definite over the step ([`MARGIN`]). The test uses two estimates. First,
/// (tr H / 2)² / det H is an upper bound of |H⁻¹|. Second, this bound times tr H / 2 is an upper bound of
/// cond(H) up to a factor of 27/32. The factor is needed where a singular value of A counts as negative (an
/// inverted region), because |H| can then exceed tr H / 2.
#[inline(always)]
fn step<S: Simd>(simd: S, a: [f32x16<S>; 9], q: [f32x16<S>; 4]) -> ([f32x16<S>; 4], u16) {
    let zero = f32x16::splat(simd, 0.0);
    let r = columns(simd, q);
    let mut m = [[zero; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            m[i][j] = r[3 * i]
                .times_plus(a[3 * j], r[3 * i + 1].times_plus(a[3 * j + 1], r[3 * i + 2] * a[3 * j + 2]));
        }
    }
    let [[m00, m01, m02], [m10, m11, m12], [m20, m21, m22]] = m;

    let axial = [m21 - m12, m02 - m20, m10 - m01];
    let (h00, h11, h22) = (m11 + m22, m00 + m22, m00 + m11);
    let (h01, h02, h12) = ((m01 + m10) * -0.5, (m02 + m20) * -0.5, (m12 + m21) * -0.5);

    // Adjugate and determinant of H.
    let c00 = h11.times_plus(h22, -(h12 * h12));
    let c01 = h02.times_plus(h12, -(h01 * h22));
    let c02 = h01.times_plus(h12, -(h02 * h11));
    let c11 = h00.times_plus(h22, -(h02 * h02));
    let c12 = h01.times_plus(h02, -(h00 * h12));
    let c22 = h00.times_plus(h11, -(h01 * h01));
    let adjugate = [c00, c01, c02, c11, c12, c22];
    let det = h00.times_plus(c00, h01.times_plus(c01, h02 * c02));
    let half_trace = m00 + m11 + m22;

    let one = f32x16::splat(simd, 1.0);
    let inverse_det = one / det;
    let half_inverse_det = inverse_det * 0.5;
    let u = scaled(half_inverse_det, symmetric(adjugate, axial));
    let delta = dot(axial, u);
    let correction = scaled(-(delta * half_inverse_det), symmetric(adjugate, u));
    let length_squared = dot(u, u);

    let inverse_bound = half_trace * half_trace * inverse_det;
    let condition = inverse_bound * half_trace;
    // The eigenvalue test, part 1: H is positive definite, by Sylvester's criterion. The leading minors of H
    // are h00, c22 = h00 h11 - h01² and det H.
    let definite =
        half_trace.simd_gt(zero) & h00.simd_gt(zero) & c22.simd_gt(zero) & inverse_det.simd_gt(zero);
    // Part 2: H stays positive definite over the step.
    let stays_definite =
        (length_squared * condition * condition).simd_lt(f32x16::splat(simd, MARGIN * MARGIN));
    let rho = delta * inverse_bound * 0.5;
    let rho_to_fourth = (rho * rho) * (rho * rho);
    let accurate = (rho_to_fourth * length_squared).simd_lt(f32x16::splat(simd, ACCURACY * ACCURACY));
    let converged = definite & stays_definite & accurate;

    // A step that is NaN or longer than |u| = 2 is omitted; such a lane has not converged. The term of the
    // series is valid only for small ρ.
    let is_bounded = length_squared.simd_lt(f32x16::splat(simd, 4.0));
    let is_small = rho.simd_lt(f32x16::splat(simd, 0.25));
    let mut rotation = u;
    for c in 0..3 {
        rotation[c] = is_bounded.select(is_small.select(u[c] + correction[c], u[c]), zero);
    }
    (rotated(simd, q, rotation), converged.to_bitmask() as u16)
}

/// Computes the normalized product q (1, u), where u = (x, y, z). |q| is close to 1, so that one Newton step
/// computes 1/|q| from |q|².
#[inline(always)]
fn rotated<S: Simd>(simd: S, q: [f32x16<S>; 4], [x, y, z]: [f32x16<S>; 3]) -> [f32x16<S>; 4] {
    let one = f32x16::splat(simd, 1.0);
    let [qx, qy, qz, qw] = q;
    let step_squared = x.times_plus(x, y.times_plus(y, z.times_plus(z, one)));
    let q_squared = qx.times_plus(qx, qy.times_plus(qy, qz.times_plus(qz, qw * qw)));
    let scale =
        q_squared.times_plus(f32x16::splat(simd, -0.5), f32x16::splat(simd, 1.5)) / step_squared.sqrt();
    let sx = qx + qw.times_plus(x, qy.times_plus(z, -(qz * y)));
    let sy = qy + qw.times_plus(y, qz.times_plus(x, -(qx * z)));
    let sz = qz + qw.times_plus(z, qx.times_plus(y, -(qy * x)));
    let sw = qw - qx.times_plus(x, qy.times_plus(y, qz * z));
    [sx * scale, sy * scale, sz * scale, sw * scale]
}

/// Computes C v for a symmetric matrix C with the entries xx, xy, xz, yy, yz, zz.
#[inline(always)]
fn symmetric<S: Simd>(c: [f32x16<S>; 6], v: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    [dot([c[0], c[1], c[2]], v), dot([c[1], c[3], c[4]], v), dot([c[2], c[4], c[5]], v)]
}

/// Computes a·b, summed from the last product: the order decides the bits.
#[inline(always)]
fn dot<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> f32x16<S> {
    a[0].times_plus(b[0], a[1].times_plus(b[1], a[2] * b[2]))
}
