//! Defines forces on a part of a body: how long they act, and how they are distributed over its lattice vertices.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

/// Smallest principal moment of inertia of a part that a torque can turn, as a fraction of the greatest. Below it,
/// moments are rounding errors of f32 positions (6e-8 of the size, squared, with a margin).
const LEAST_INERTIA: f64 = 1e-9;

/// A force on the selected part of a body, for [`Body::apply_force`](crate::Body::apply_force). An array is a force
/// without a point, a torque and a duration.
///
/// ```
/// use supple::{Force, ForceDuration};
///
/// // 20 N at a point, for a quarter of a second.
/// let push = Force {
///     point: Some([0.0, 1.0, 0.0]),
///     duration: ForceDuration::Seconds(0.25),
///     ..Force::from([20.0, 0.0, 0.0])
/// };
/// # assert_eq!(push.torque, [0.0; 3]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Force {
    /// The total force, in kg x length / s^2.
    pub force: [f64; 3],
    /// The point in world space at which the force acts; `None`, the default: the center of mass of the part. The force
    /// exerts a torque about the center of mass.
    pub point: Option<[f64; 3]>,
    /// A torque on the part, in kg x length^2 / s^2, besides that of the force; default 0.
    pub torque: [f64; 3],
    /// How long the force acts; default: during the next call.
    pub duration: ForceDuration,
}

impl From<[f64; 3]> for Force {
    fn from(force: [f64; 3]) -> Self {
        Self { force, ..Self::default() }
    }
}

/// How long a force acts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ForceDuration {
    /// During the next call of [`Simulation::step`](crate::Simulation::step), [`steps`](crate::Simulation::steps) or
    /// [`advance`](crate::Simulation::advance).
    #[default]
    Call,
    /// In the next step.
    Step,
    /// For a time in seconds, above 0. In a last step that is longer than the rest of the time, the force is as much
    /// smaller, so that the whole impulse is force x time.
    Seconds(f64),
}

/// Forces on lattice vertices that act in more than one step, or impulses on them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Lasting {
    /// Lattice vertices in increasing order, and the forces or impulses on them.
    pub(super) forces: Vec<(u32, [f64; 3])>,
    /// The time that is left; `None`: the forces are impulses, which act in the next step.
    left: Option<ForceDuration>,
    /// Whether the force acts after the current step.
    lasts: bool,
}

impl Lasting {
    /// `forces`: in any order; those on one vertex add up. `duration`: `None` for impulses.
    pub(crate) fn new(mut forces: Vec<(u32, [f64; 3])>, duration: Option<ForceDuration>) -> Self {
        forces.sort_by_key(|&(vertex, _)| vertex);
        super::forces::sum_duplicates(&mut forces);
        Self { forces, left: duration, lasts: true }
    }

    /// Takes a step of `dt` seconds from the time that is left. Returns the factor of the forces in this step: of the last step of
    /// a time, the share in which the force acts, so that the whole impulse is force x time.
    pub(super) fn take_step(&mut self, dt: f64) -> f64 {
        match &mut self.left {
            Some(ForceDuration::Call) => 1.0,
            Some(ForceDuration::Step) => {
                self.lasts = false;
                1.0
            }
            None => {
                self.lasts = false;
                1.0 / dt
            }
            Some(ForceDuration::Seconds(left)) => {
                let share = (*left / dt).min(1.0);
                *left -= dt;
                // The rest of a whole number of steps is a rounding error.
                self.lasts = *left > 1e-9 * dt;
                share
            }
        }
    }

    /// Returns whether the force acts after the steps that were [taken](Self::take_step).
    pub(super) fn lasts(&self) -> bool {
        self.lasts
    }

    /// Returns whether the force ends with a call that made steps.
    pub(super) fn ends_with_call(&self) -> bool {
        self.left == Some(ForceDuration::Call)
    }
}

/// Returns the force on each of some `vertices` (position and mass), whose sum is `force`, with the given torque about
/// their center of mass: f = m (F/M + a × r), where r is the distance from the center of mass and the angular
/// acceleration a = I⁻¹ T, so that the vertices are accelerated like a rigid body. `None`: the vertices lie on a line,
/// about which nothing can turn them, or at a point.
pub(crate) fn distribute(
    vertices: &[(Point3<f64>, f64)],
    force: Vector3<f64>,
    torque: impl Fn(Point3<f64>) -> Vector3<f64>,
) -> Option<Vec<Vector3<f64>>> {
    let total: f64 = vertices.iter().map(|(_, mass)| mass).sum();
    let first = vertices.first()?.0;
    let center =
        first + vertices.iter().map(|(point, mass)| (point - first) * *mass).sum::<Vector3<f64>>() / total;
    let inertia: Matrix3<f64> = vertices
        .iter()
        .map(|(point, mass)| {
            let r = point - center;
            (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * *mass
        })
        .sum();
    let torque = torque(center);
    let spin = if torque == Vector3::zeros() { Some(torque) } else { turned(&inertia, torque) }?;
    let of_vertex =
        |&(point, mass): &(Point3<f64>, f64)| (force / total + spin.cross(&(point - center))) * mass;
    Some(vertices.iter().map(of_vertex).collect())
}

/// Returns the angular acceleration by a torque; `None` if the inertia about an axis with torque is zero.
fn turned(inertia: &Matrix3<f64>, torque: Vector3<f64>) -> Option<Vector3<f64>> {
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(*inertia);
    let least = LEAST_INERTIA * eigenvalues.max();
    let mut spin = Vector3::zeros();
    for (moment, axis) in eigenvalues.iter().zip(eigenvectors.column_iter()) {
        let part = axis.dot(&torque);
        if *moment > least {
            spin += axis * (part / moment);
        } else if part.abs() > 1e-9 * torque.norm() {
            return None;
        }
    }
    Some(spin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distributed_forces_have_the_given_sum_and_torque() {
        let corner = |k: usize| Point3::new((k & 1) as f64, (k >> 1 & 1) as f64 * 2.0, (k >> 2) as f64 * 3.0);
        let vertices: Vec<_> = (0..8).map(|k| (corner(k) + Vector3::repeat(1e3), 1.0 + k as f64)).collect();
        let (force, torque) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 4.0, -1.0));
        let center = std::cell::Cell::new(Point3::origin());
        let forces = distribute(&vertices, force, |c| (center.set(c), torque).1).unwrap();
        let sum: Vector3<f64> = forces.iter().sum();
        let moment: Vector3<f64> =
            forces.iter().zip(&vertices).map(|(f, (point, _))| (point - center.get()).cross(f)).sum();
        assert!((sum - force).norm() < 1e-12 && (moment - torque).norm() < 1e-12, "{sum} {moment}");
    }

    #[test]
    fn vertices_on_a_line_take_no_torque_about_it() {
        let vertices: Vec<_> = (0..3).map(|k| (Point3::new(f64::from(k), 0.0, 0.0), 1.0)).collect();
        let torque = |axis: Vector3<f64>| distribute(&vertices, Vector3::zeros(), |_| axis);
        assert!(torque(Vector3::x()).is_none());
        assert!(torque(Vector3::y()).is_some());
        assert!(distribute(&vertices[..1], Vector3::x(), |_| Vector3::y()).is_none());
        assert_eq!(distribute(&vertices[..1], Vector3::x(), |_| Vector3::zeros()), Some(vec![Vector3::x()]));
    }

    #[test]
    fn a_force_that_ends_within_a_step_acts_in_its_share_of_it() {
        let mut lasting = Lasting::new(vec![(0, [1.0; 3])], Some(ForceDuration::Seconds(0.25)));
        let shares: Vec<f64> =
            std::iter::from_fn(|| lasting.lasts().then(|| lasting.take_step(0.1))).collect();
        assert_eq!(shares.len(), 3);
        assert!((shares.iter().sum::<f64>() * 0.1 - 0.25).abs() < 1e-12);
        let mut whole = Lasting::new(vec![], Some(ForceDuration::Seconds(0.3)));
        let steps = std::iter::from_fn(|| whole.lasts().then(|| whole.take_step(0.1))).count();
        assert_eq!(steps, 3);
    }
}
