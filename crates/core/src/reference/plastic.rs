//! Computes the plastic flow of a region.

use nalgebra::Matrix3;

use crate::dynamics::Plasticity;

/// Least mean stretch to which strains are relative: a cube compressed evenly to a twentieth of its volume.
const LEAST_STRETCH: f64 = 0.37;

/// Greatest |k D| of a step.
const GREATEST_CHANGE: f64 = 0.5;

/// Returns the plastic shape of a region with a rotation R, a deformation gradient F and a plastic shape S after a step
/// of `dt` seconds.
///
/// The stretch of the region from its plastic shape S is the symmetric part E of R^T F S^-1, and its strain D is the
/// deviatoric part of E divided by the mean stretch. Where |D| exceeds the yield strain, S becomes
/// (1 + k D/2) S (1 + k D/2) with k |D| = c (|D| - yield), at most 1/2, and c = 1 - exp(-creep dt), at most 1/2. S is
/// then scaled to the determinant 1. If |S - 1| exceeds the greatest one, S - 1 is scaled back to it, and S to the
/// determinant 1.
pub(super) fn flowed(
    [rotation, gradient, shape]: [Matrix3<f64>; 3],
    plasticity: &Plasticity,
    dt: f64,
) -> Matrix3<f64> {
    let Plasticity { yield_strain, max, .. } = *plasticity;
    let Some(inverse) = shape.try_inverse() else { return shape };
    let elastic = rotation.transpose() * gradient * inverse;
    let stretch = (elastic + elastic.transpose()) / 2.0;
    let mean = stretch.trace() / 3.0;
    let strain = (stretch - Matrix3::identity() * mean) / mean.max(LEAST_STRETCH);
    let norm = strain.norm();
    if norm.is_nan() || norm <= yield_strain {
        return shape;
    }
    let change = (plasticity.fraction(dt) * (norm - yield_strain)).min(GREATEST_CHANGE);
    let factor = Matrix3::identity() + strain * (change / norm / 2.0);
    let flowed = of_volume_one(factor * shape * factor);
    let plastic = flowed - Matrix3::identity();
    if plastic.norm() <= max {
        return flowed;
    }
    of_volume_one(Matrix3::identity() + plastic * (max / plastic.norm()))
}

/// Scales a positive definite matrix to the determinant 1.
fn of_volume_one(shape: Matrix3<f64>) -> Matrix3<f64> {
    shape / libm::cbrt(shape.determinant())
}
