//! Constraints on the field: external forces, and held vertices.

use super::adjacency::Adjacency;
use super::line::Moving;

/// An external force on a lattice vertex, of a contact or a grab; never gravity, which all vertices share.
///
/// Given as a length, so that it does not depend on the units of mass and time: how far the force moves the vertex
/// in one step where nothing else acts, over the stiffness `alpha`. (A force `f` on a mass `m` through a step `dt`:
/// `f dt^2 / (m alpha)`; a contact that forces a vertex out by `d` and takes the velocity `v` from it: `d + v dt`.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExternalForce {
    /// The lattice vertex.
    pub vertex: u32,
    /// Direction and size of the force, in cells and world axes. Zero and non-finite ones count as none.
    pub offset: [f32; 3],
}

/// The force, in cells, at which half of the field's part along it is gone.
///
/// It is well below what a vertex that rests on the ground needs to carry its own weight in a stiff body, and well
/// above rounding: contacts that carry weight count in full, and a grazing one fades in with the square of its force.
pub const HALF_FORCE: f64 = 1e-3;

/// Pushes beyond this many times [`HALF_FORCE`] count as this many: the matrix below stays well conditioned.
const STRONGEST: f64 = 1e4;

/// Takes the forces' directions out of the field: equation (2) of Takamatsu & Kanai (2009), softened.
///
/// Each vertex takes the `v'` that minimises `|v' - v|^2 + sum (f . v')^2 / f0^2`, that is `(I + F) v' = v` with
/// `F = sum f f^T / f0^2` and `f0 =` [`HALF_FORCE`]. For one force that is `v - s (v . f^) f^` with
/// `s = |f|^2 / (|f|^2 + f0^2)`: the paper's equation for a strong one, and nothing at all for a weak one, where the
/// paper's pops. Several forces take away all that they span, in whichever order they come.
///
/// `order` is scratch: it keeps its room between calls.
pub(super) fn remove_force_directions(
    forces: &[ExternalForce],
    order: &mut Vec<(u32, u32)>,
    points: &mut [Moving],
) {
    order.clear();
    order.extend(forces.iter().enumerate().map(|(index, force)| (force.vertex, index as u32)));
    order.sort_unstable();
    for group in order.chunk_by(|a, b| a.0 == b.0) {
        // The upper triangle of I + F: xx, xy, xz, yy, yz, zz.
        let mut matrix = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
        for &(_, index) in group {
            let [x, y, z] = in_half_forces(&forces[index as usize].offset);
            for (sum, term) in matrix.iter_mut().zip([x * x, x * y, x * z, y * y, y * z, z * z]) {
                *sum += term;
            }
        }
        let point = &mut points[group[0].0 as usize];
        point.set_direction(solve(&matrix, point.direction().map(f64::from)).map(|v| v as f32));
    }
}

/// A force in units of [`HALF_FORCE`], no longer than [`STRONGEST`].
fn in_half_forces(offset: &[f32; 3]) -> [f64; 3] {
    let f = offset.map(|x| f64::from(x) / HALF_FORCE);
    let length = (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]).sqrt();
    if !length.is_finite() {
        return [0.0; 3];
    }
    let factor = if length > STRONGEST { STRONGEST / length } else { 1.0 };
    f.map(|f| f * factor)
}

/// Solves a symmetric system with eigenvalues of one and more, by Cholesky's factors.
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

/// How much of the field is left at each vertex beside held ones: 0 at a held vertex, rising smoothly to 1 at
/// `ramp` links from it, so that no crease shows beside a pin. All ones if nothing is held.
pub(super) fn ramp(adjacency: &Adjacency, held: &[u32], ramp: u32) -> Vec<f32> {
    let ramp = ramp.max(1);
    let share = |distance: u32| {
        let t = f64::from(distance.min(ramp)) / f64::from(ramp);
        (t * t * (3.0 - 2.0 * t)) as f32
    };
    adjacency.distances(held.iter().map(|&i| i as usize)).into_iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(v: [f32; 3], offsets: &[[f32; 3]]) -> [f32; 3] {
        let forces: Vec<ExternalForce> =
            offsets.iter().map(|&offset| ExternalForce { vertex: 0, offset }).collect();
        let mut points = [Moving::new([0.0; 3], v)];
        remove_force_directions(&forces, &mut Vec::new(), &mut points);
        points[0].direction()
    }

    fn near(a: [f32; 3], b: [f32; 3], tolerance: f32) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance), "{a:?} {b:?}");
    }

    #[test]
    fn one_push_has_the_stated_weight() {
        let half = HALF_FORCE as f32;
        near(left([0.6, 0.8, 0.0], &[[0.0, half, 0.0]]), [0.6, 0.4, 0.0], 1e-7);
        near(left([0.6, 0.8, 0.0], &[[0.0, 3.0 * half, 0.0]]), [0.6, 0.08, 0.0], 1e-7);
        near(left([0.6, 0.8, 0.0], &[[0.0, 1.0, 0.0]]), [0.6, 0.0, 0.0], 1e-6);
        near(left([1.0, 0.0, 0.0], &[[1.0, 1.0, 0.0]]), [0.5, -0.5, 0.0], 1e-6);
        near(left([0.6, 0.8, 0.0], &[[0.0, half * 1e-4, 0.0]]), [0.6, 0.8, 0.0], 1e-7);
    }

    #[test]
    fn several_pushes_take_their_span() {
        near(left([0.5, 0.6, 0.7], &[[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]), [0.0, 0.0, 0.7], 1e-5);
        near(left([0.5, 0.6, 0.7], &[[1.0, 0.0, 0.0], [1e-30, 1e30, 0.0], [0.0, 2.0, 5.0]]), [0.0; 3], 1e-5);
    }

    #[test]
    fn no_push_and_no_number_are_nothing() {
        let v = [0.5, 0.6, 0.7];
        assert_eq!(left(v, &[[0.0; 3], [f32::NAN, 0.0, 0.0], [f32::INFINITY, 1.0, 0.0]]), v);
        near(left(v, &[[f32::MAX; 3]]), [-0.1, 0.0, 0.1], 1e-6);
    }
}
