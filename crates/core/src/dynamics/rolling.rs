//! Rolling resistance of components on colliders.
//!
//! A component that rolls on a collider is slowed by *rolling resistance*: the center of pressure of a contact lies
//! ahead, by a fraction of the radius of the contact, so that it has a torque about the contact (Coulomb 1785; for
//! soft bodies Greenwood et al. 1961). The torque is at most that fraction times the radius times the normal force,
//! and at most as great as stops the rolling in the step. The radius is √(s + 1/4) cells, with the mean square s of
//! the distances of the contacts from their center: the lattice resolves no smaller ones.

use super::momentum::Mobility;
use crate::state::{RigidMobility, Support, Twist};
use nalgebra::Vector3;

/// Returns the change of the rigid motion of a component by rolling resistance at a support. `coefficient`: of the
/// resistance. `mobility`, `motion`: of the component, without conditions.
pub(super) fn resistance(support: &Support, coefficient: f64, mobility: &Mobility, motion: Twist) -> Twist {
    let [normal, spin] = [support.pressing.normal, support.spin].map(Vector3::from);
    let turning = motion.angular - spin;
    let rolling = turning - normal * normal.dot(&turning);
    let Some(axis) = rolling.try_normalize(0.0) else { return Twist::default() };
    // A torque without a force: friction changes the velocity of the center.
    let turned = mobility.turn(axis);
    // Without a mean normal, no force presses.
    let torque = coefficient * support.pressing.radius(1.0) * support.pressing.impulse * normal.norm();
    // About the axis, the component is stopped at most: no work is done.
    let stopping = rolling.norm() / axis.dot(&turned);
    match stopping.is_finite() {
        true => Twist { angular: -turned * torque.min(stopping), ..Twist::default() },
        false => Twist::default(),
    }
}

/// Returns the change of the angular velocity `spin` of a rigid body by rolling resistance at a support: see
/// [`resistance`].
pub(crate) fn rolling_resistance(
    support: &Support,
    coefficient: f64,
    body: &RigidMobility,
    spin: Vector3<f64>,
) -> Vector3<f64> {
    let mobility = Mobility::of_angular(&body.angular);
    let motion = Twist { angular: spin, ..Twist::default() };
    resistance(support, coefficient, &mobility, motion).angular
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::state::Pressing;

    /// A torque about a horizontal axis leaves the angular momentum about the normal, and takes energy, also from a
    /// body whose moments of inertia couple the axes.
    #[test]
    fn rolling_resistance_takes_energy_and_no_angular_momentum_about_the_normal() {
        let inertia = Matrix3::new(1.0, -0.5, 0.0, -0.5, 1.0, 0.0, 0.0, 0.0, 0.3);
        let mobility = Mobility::of_body(2.0, &inertia);
        for (spin, impulse) in [([0.1, 10.0, 0.0], 1e9), ([3.0, -1.0, 2.0], 0.5), ([3.0, -1.0, 2.0], 1e9)] {
            let motion = Twist { angular: spin.into(), ..Twist::default() };
            let pressing = Pressing { normal: [0.0, 1.0, 0.0], impulse, ..Pressing::default() };
            let support = Support { pressing, ..Support::default() };
            let after = motion.angular + resistance(&support, 0.1, &mobility, motion).angular;
            let energy = |angular: Vector3<f64>| 0.5 * angular.dot(&(inertia * angular));
            assert!(energy(after) < energy(motion.angular), "{after:?}");
            assert!((inertia * (after - motion.angular)).y.abs() < 1e-12);
        }
    }
}
