//! Removes the directions of external forces from the deformation field: Eq. (2) of Takamatsu & Kanai 2009.

use super::line::Moving;

/// External force on a lattice vertex, from a contact or from the user; gravity is not included.
///
/// The force is expressed as a length, so that it does not depend on the units of mass and time. The length
/// is the displacement by which the force alone would move the vertex, divided by the stiffness `alpha`. A
/// force `f` on a mass `m` during a step `dt` gives the length `f dt^2 / (m alpha)`. A contact that displaces
/// a vertex by `d` and changes its velocity by `v` gives `(d + v dt) / alpha`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExternalForce {
    /// Lattice vertex.
    pub vertex: u32,
    /// Force as a length, in cells, with the direction of the force in world axes. Zero and non-finite forces
    /// have no effect.
    pub force: [f32; 3],
}

/// Force, in cells, that halves the component of the field along the force.
///
/// It is well below the contact force that carries the weight of a vertex of a stiff body at rest on the
/// ground, and well above rounding errors. Contacts that carry weight therefore have their full effect, and
/// the effect of a grazing contact fades in with the square of the contact force.
const HALF_FORCE: f64 = 1e-3;

/// Magnitude to which a force is clamped, in units of [`HALF_FORCE`]. It keeps the matrix `I + F` well
/// conditioned.
const MAX_FORCE: f64 = 1e4;

/// Removes the directions of external forces from the field: Takamatsu & Kanai 2009, Eq. (2), regularized.
///
/// `v` is the vector of the field at a vertex, and `v'` replaces it. `^T` is the transpose:
///
/// ```text
/// paper:  v' = v - (v . d) d  for one force f with the direction d = f / |f|          (Eq. 2)
/// here:   v' minimizes |v' - v|^2 + sum (f . v')^2 / f0^2,  f0 = HALF_FORCE,
///         with the sum over the forces f on the vertex. The solution of
///         (I + F) v' = v,  F = sum f f^T / f0^2,  is this minimum.
/// ```
///
/// A single force gives `v' = v - s (v . d) d` with `s = |f|^2 / (|f|^2 + f0^2)`. For a strong force `s` is
/// nearly 1, as in Eq. (2). For a weak force `s` is near 0, so that the field changes continuously when a
/// force begins; with Eq. (2) it would jump. Several strong forces remove all directions in their span,
/// independently of their order.
///
/// * `acts`: returns whether a force is considered.
/// * `order`: a buffer that keeps its capacity between calls.
pub(super) fn remove_force_directions(
    forces: &[ExternalForce],
    acts: impl Fn(&ExternalForce) -> bool,
    order: &mut Vec<(u32, u32)>,
    points: &mut [Moving],
) {
    order.clear();
    let acting = forces.iter().enumerate().filter(|(_, force)| acts(force));
    order.extend(acting.map(|(index, force)| (force.vertex, index as u32)));
    order.sort_unstable();
    for group in order.chunk_by(|a, b| a.0 == b.0) {
        // Upper triangle of I + F: xx, xy, xz, yy, yz, zz.
        let mut matrix = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
        for &(_, index) in group {
            let [x, y, z] = in_units_of_half_force(&forces[index as usize].force);
            for (sum, term) in matrix.iter_mut().zip([x * x, x * y, x * z, y * y, y * z, z * z]) {
                *sum += term;
            }
        }
        let point = &mut points[group[0].0 as usize];
        point.set_direction(solve(&matrix, point.direction().map(f64::from)).map(|v| v as f32));
    }
}

/// Returns a force in units of [`HALF_FORCE`], clamped to the length [`MAX_FORCE`]; zero if it is not finite.
fn in_units_of_half_force(force: &[f32; 3]) -> [f64; 3] {
    let f = force.map(|x| f64::from(x) / HALF_FORCE);
    let length = (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]).sqrt();
    if !length.is_finite() {
        return [0.0; 3];
    }
    let factor = if length > MAX_FORCE { MAX_FORCE / length } else { 1.0 };
    f.map(|f| f * factor)
}

/// Solves a symmetric system with the right-hand side `b`, by an LDL^T (square-root-free Cholesky)
/// factorization. The eigenvalues of the matrix must be at least 1.
fn solve(&[xx, xy, xz, yy, yz, zz]: &[f64; 6], b: [f64; 3]) -> [f64; 3] {
    let (l10, l20) = (xy / xx, xz / xx);
    let d1 = (yy - l10 * xy).max(1.0);
    let l21 = (yz - l20 * xy) / d1;
    let d2 = (zz - l20 * xz - l21 * l21 * d1).max(1.0);
    let y1 = b[1] - l10 * b[0];
    let z = (b[2] - l20 * b[0] - l21 * y1) / d2;
    let y = y1 / d1 - l21 * z;
    [b[0] / xx - l10 * y - l20 * z, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the vector `v` of the field after the removal of the directions of `force_vectors`.
    fn remaining(v: [f32; 3], force_vectors: &[[f32; 3]]) -> [f32; 3] {
        let forces: Vec<ExternalForce> =
            force_vectors.iter().map(|&force| ExternalForce { vertex: 0, force }).collect();
        let mut points = [Moving::new([0.0; 3], v)];
        remove_force_directions(&forces, |_| true, &mut Vec::new(), &mut points);
        points[0].direction()
    }

    fn assert_near(a: [f32; 3], b: [f32; 3], tolerance: f32) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance), "{a:?} {b:?}");
    }

    #[test]
    fn single_force_has_the_documented_weight() {
        let half = HALF_FORCE as f32;
        assert_near(remaining([0.6, 0.8, 0.0], &[[0.0, half, 0.0]]), [0.6, 0.4, 0.0], 1e-7);
        assert_near(remaining([0.6, 0.8, 0.0], &[[0.0, 3.0 * half, 0.0]]), [0.6, 0.08, 0.0], 1e-7);
        assert_near(remaining([0.6, 0.8, 0.0], &[[0.0, 1.0, 0.0]]), [0.6, 0.0, 0.0], 1e-6);
        assert_near(remaining([1.0, 0.0, 0.0], &[[1.0, 1.0, 0.0]]), [0.5, -0.5, 0.0], 1e-6);
        assert_near(remaining([0.6, 0.8, 0.0], &[[0.0, half * 1e-4, 0.0]]), [0.6, 0.8, 0.0], 1e-7);
    }

    #[test]
    fn several_forces_remove_their_span() {
        assert_near(remaining([0.5, 0.6, 0.7], &[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]), [0.0, 0.0, 0.7], 1e-5);
        let forces = [[1.0, 0.0, 0.0], [1e-30, 1e30, 0.0], [0.0, 2.0, 5.0]];
        assert_near(remaining([0.5, 0.6, 0.7], &forces), [0.0; 3], 1e-5);
    }

    #[test]
    fn zero_and_non_finite_forces_have_no_effect() {
        let v = [0.5, 0.6, 0.7];
        assert_eq!(remaining(v, &[[0.0; 3], [f32::NAN, 0.0, 0.0], [f32::INFINITY, 1.0, 0.0]]), v);
        assert_near(remaining(v, &[[f32::MAX; 3]]), [-0.1, 0.0, 0.1], 1e-6);
    }
}
