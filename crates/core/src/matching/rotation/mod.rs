//! Computes the rotation of a region: R = argmax over SO(3) of tr(Rᵀ A), for a 3 × 3 matrix A.
//!
//! R is a proper rotation even if A is singular or inverted. Let A = U diag(s₁, s₂, s₃) Vᵀ be the singular
//! value decomposition, with s₁ >= s₂ >= s₃ >= 0. For det A < 0, R is U diag(1, 1, -1) Vᵀ, the proper
//! rotation nearest to A (Umeyama 1991). R is unique iff s₂ + sign(det A) s₃ > 0. If it is not unique, the
//! result is the solution nearest to the previous rotation, so that the motion stays continuous.
//!
//! Newton's method on the quaternion ([`newton`]) computes the rotations of two blocks of eight lanes at a
//! time, one matrix A in each lane. An eigenvalue test decides whether a lane has converged to the maximum.
//! Lanes that do not converge use the fallback: Davenport's eigenvalue problem in f64 ([`davenport`]).

mod columns;
mod davenport;
pub(super) mod newton;

pub(crate) use columns::columns;

use fearless_simd::{SimdBase, dispatch, f32x16};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion};

use crate::simd::lanes::LANES;
use crate::simd::level;

/// Computes the rotation R = argmax over SO(3) of tr(Rᵀ A) of each 3 × 3 matrix A, with the algorithm that a
/// simulation step uses.
///
/// R is a proper rotation and does not depend on the scale of A. For the zero matrix it is the identity.
/// Entries of A that are not finite count as zero.
pub fn rotations(matrices: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
    let mut out = Vec::with_capacity(matrices.len());
    for chunk in matrices.chunks(ROTATIONS) {
        out.extend_from_slice(&rotations_near(chunk, &UnitQuaternion::identity())[..chunk.len()]);
    }
    out
}

/// Greatest number of matrices of [`rotations_near`].
pub(crate) const ROTATIONS: usize = 2 * LANES;

/// Computes the rotations of up to [`ROTATIONS`] matrices as [`rotations`] does. A rotation that is not unique is the
/// one nearest to `near`.
pub(crate) fn rotations_near(
    matrices: &[Matrix3<f64>],
    near: &UnitQuaternion<f64>,
) -> [Matrix3<f64>; ROTATIONS] {
    let mut a = [[0.0; ROTATIONS]; 9];
    for (lane, matrix) in matrices.iter().enumerate() {
        let largest = matrix.iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()));
        let scale = if largest > 0.0 { largest } else { 1.0 };
        for (row, x) in a.iter_mut().zip(matrix.iter()) {
            row[lane] = if x.is_finite() { (x / scale) as f32 } else { 0.0 };
        }
    }
    let mut quaternions = [[0.0; ROTATIONS]; 4];
    let active = (1_u32 << matrices.len()) - 1;
    dispatch!(level(), simd => {
        let rows = a.map(|row| f32x16::load_array(simd, row));
        let start = [near.i, near.j, near.k, near.w].map(|x| f32x16::splat(simd, x as f32));
        let (q, _) = newton::solve(simd, rows, start, active as u16, 0);
        quaternions = q.map(f32x16::to_array);
    });
    std::array::from_fn(|lane| {
        let [x, y, z, w] = quaternions.map(|row| f64::from(row[lane]));
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner()
    })
}
