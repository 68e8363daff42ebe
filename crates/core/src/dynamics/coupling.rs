//! Couples the reference motions of bodies that press on each other: see [`elastic_damping`](super::elastic_damping).
//!
//! The reference motions of such bodies do not move into or out of each other, and where the bodies do not roll or
//! slide on each other, they do not move relative to each other at all. The conditions are the same as for a support
//! by a collider, and are met by opposite impulses on the rigid motions of both bodies at the same point, computed
//! one after another in several sweeps (projected Gauss-Seidel iteration). So damping keeps the
//! momenta of the bodies. The impulses have the limits of a contact: see [`reaction`](super::reaction).

use nalgebra::{Vector3, Vector6};

use super::momentum::{Mobility, SOFTNESS};
use super::reaction::{ImpulseLimits, SupportDirections, SupportLimits};
use crate::state::{PairSupport, Twist};

/// Number of sweeps over the conditions of all supports. More sweeps damp towers of more bodies as a whole.
const SWEEPS: usize = 10;

/// The reference motion of a connected component, in world space and scene units.
#[derive(Clone, Debug)]
pub(crate) struct CoupledComponent {
    /// The body and the index of the component.
    pub(crate) side: (u32, u32),
    /// Center of mass.
    pub(super) center: Vector3<f64>,
    /// Rigid motion with the momenta of the component.
    pub(super) motion: Twist,
    /// Reference motion (v, ω).
    pub(super) reference: Vector6<f64>,
    /// Change of the reference motion by impulses, restricted by pins, handles and colliders.
    pub(super) mobility: Mobility,
    /// Fraction of the difference to the reference motion that a step takes away from the velocities.
    pub(super) fraction: f64,
    /// Size of the body.
    pub(super) size: f64,
    pub(super) cell_size: f64,
    /// See [`DampingStep`](super::reaction::DampingStep).
    pub(super) layers: f64,
    /// Change (v, ω) of the reference motion by the coupling.
    pub(super) change: Vector6<f64>,
    /// Sum of the impulses of the coupling on the component in the step.
    pub(super) impulse: Vector3<f64>,
}

/// Computes the common reference motions. Its buffers are reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coupling {
    /// The components that press on others, in increasing order of the sides.
    pub(crate) components: Vec<CoupledComponent>,
    conditions: Vec<Condition>,
    /// The reaction of each support: the impulse on its first side in the last step that was solved.
    pub(crate) reactions: Vec<Vector3<f64>>,
}

/// A condition: equal speeds of two components along `rows`.
#[derive(Clone, Debug)]
struct Condition {
    /// Index of the support.
    support: usize,
    components: [usize; 2],
    rows: [Vector6<f64>; 2],
    /// Change of the reference motion of each component by a unit impulse on it along its row.
    responses: [Vector6<f64>; 2],
    impulse: f64,
    limits: ImpulseLimits,
    /// Compliance of the condition, and the inverse of the sum of it and of the mobilities.
    softness: f64,
    inverse: f64,
    /// Part of the change that the damping of each component applies.
    parts: [f64; 2],
    /// Part of the impulse that acts in the step.
    fraction: f64,
}

impl Coupling {
    /// Computes the changes of the reference motions of the components by the supports, and advances the deflections of
    /// the supports by a step of `dt` seconds. `friction`: returns the coefficient of friction of a support.
    pub(crate) fn solve(
        &mut self,
        supports: &mut [PairSupport],
        dt: f64,
        friction: impl Fn(&PairSupport) -> f64,
    ) {
        let Self { components, conditions, reactions } = self;
        conditions.clear();
        reactions.clear();
        reactions.resize(supports.len(), Vector3::zeros());
        for (index, support) in supports.iter_mut().enumerate() {
            let place = |side| components.binary_search_by_key(&side, |component| component.side).ok();
            if let [Some(first), Some(second)] = support.sides.map(place) {
                let friction = friction(support);
                add_conditions(components, [first, second], (index, support, friction), dt, conditions);
            }
        }
        for _ in 0..SWEEPS {
            for condition in &mut *conditions {
                let Condition { components: [first, second], rows, responses, softness, inverse, .. } =
                    *condition;
                let speed = |index: usize, row: &Vector6<f64>| row.dot(&components[index].reference);
                let difference = speed(first, &rows[0]) - speed(second, &rows[1]);
                let wanted = condition.impulse - (difference + softness * condition.impulse) * inverse;
                let impulse = condition.limits.nearest(wanted) - condition.impulse;
                condition.impulse += impulse;
                for (side, sign) in [(0, 1.0), (1, -1.0)] {
                    let component = &mut components[condition.components[side]];
                    let change = responses[side] * (sign * impulse);
                    component.reference += change;
                    component.change += change * condition.parts[side];
                }
            }
        }
        for condition in &*conditions {
            let impulse = condition.rows[0].fixed_rows::<3>(0) * (condition.impulse * condition.fraction);
            components[condition.components[0]].impulse += impulse;
            components[condition.components[1]].impulse -= impulse;
            reactions[condition.support] += impulse;
        }
    }
}

/// Adds the conditions of a support with a coefficient of friction, and advances its deflections.
fn add_conditions(
    components: &[CoupledComponent],
    places: [usize; 2],
    (index, support, friction): (usize, &mut PairSupport, f64),
    dt: f64,
    conditions: &mut Vec<Condition>,
) {
    let sides = places.map(|place| &components[place]);
    let [first, second] = sides;
    // Both components get the same impulse, so the one that is damped less determines the part of it.
    let fraction = first.fraction.min(second.fraction);
    if fraction <= 0.0 {
        return;
    }
    let parts = [fraction / first.fraction, fraction / second.fraction];
    let pressing = &mut support.pressing;
    let arms = sides.map(|component| Vector3::from(pressing.point) - component.center);
    let velocity = |side: usize| sides[side].motion.velocity_at(&arms[side]);
    let relative = [first.motion.angular - second.motion.angular, velocity(0) - velocity(1)];
    let limits = SupportLimits::new(
        pressing,
        friction,
        (first.cell_size.min(second.cell_size), first.layers.min(second.layers)),
    );
    let size = first.size.min(second.size);
    for (directions, limits) in SupportDirections::advance(pressing, limits, relative, (dt, size)).groups() {
        // Of perpendicular impulses, each has an equal part of their common limit.
        let limits = limits.over(fraction * (directions.clone().count() as f64).sqrt());
        for direction in directions {
            let rows = arms.map(|arm| direction.row(arm));
            let found = [first.mobility.response(&rows[0]), second.mobility.response(&rows[1])];
            let speed = found[0].speed + found[1].speed;
            if speed > 0.0 {
                let softness = SOFTNESS * (found[0].free_speed + found[1].free_speed);
                conditions.push(Condition {
                    support: index,
                    components: places,
                    rows,
                    responses: found.map(|response| response.motion),
                    impulse: 0.0,
                    limits,
                    softness,
                    inverse: 1.0 / (speed + softness),
                    parts,
                    fraction,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;
    use crate::dynamics::deflection::axes_without;
    use crate::state::Pressing;

    /// Mass of each component of the tests: `component`, `momenta`.
    const MASSES: [f64; 3] = [1.0, 4.0, 2.0];

    /// Inertia of a component about each axis, over its mass.
    const INERTIA: f64 = 1.0 / 6.0;

    fn component(body: u32, speed: f64) -> CoupledComponent {
        let mass = MASSES[body as usize];
        let motion = Twist { linear: Vector3::x() * speed, angular: Vector3::z() * (0.3 * speed) };
        CoupledComponent {
            side: (body, 0),
            center: Vector3::x() * f64::from(body),
            motion,
            reference: motion.components(),
            mobility: Mobility::of_body(mass, &(Matrix3::identity() * (mass * INERTIA))),
            fraction: 0.1,
            size: 1.0,
            cell_size: 0.1,
            layers: 1.0,
            change: Vector6::zeros(),
            impulse: Vector3::zeros(),
        }
    }

    fn support(first: u32, second: u32, x: f64) -> PairSupport {
        let (point, normal) = ([x, 0.2, 0.1], [1.0, 0.0, 0.0]);
        let pressing = Pressing {
            impulse: 1.0,
            grip: 1.0,
            point,
            normal,
            squared_radius: 1.0,
            aligned: 1.0,
            ..Pressing::default()
        };
        PairSupport { sides: [(first, 0), (second, 0)], pressing }
    }

    /// Returns the linear momentum, and the angular momentum about the origin, of the changes.
    fn momenta(components: &[CoupledComponent]) -> (Vector3<f64>, Vector3<f64>) {
        let impulses = components.iter().zip(MASSES).map(|(c, mass)| {
            let Twist { linear, angular } = Twist::from_components(&(c.change * c.fraction));
            let (linear, angular) = (linear * mass, angular * (mass * INERTIA));
            (linear, angular + c.center.cross(&linear))
        });
        impulses.fold((Vector3::zeros(), Vector3::zeros()), |sum, (p, l)| (sum.0 + p, sum.1 + l))
    }

    /// Returns the energy of the components with the velocities that `motion` returns.
    fn energy(components: &[CoupledComponent], motion: fn(&CoupledComponent) -> Vector6<f64>) -> f64 {
        let energies = components.iter().zip(MASSES).map(|(c, mass)| {
            let Twist { linear, angular } = Twist::from_components(&motion(c));
            0.5 * mass * (linear.norm_squared() + INERTIA * angular.norm_squared())
        });
        energies.sum()
    }

    #[test]
    fn coupling_keeps_momenta_and_stops_relative_motion() {
        let components = [component(0, 1.0), component(1, -0.5), component(2, 0.2)];
        let mut coupling = Coupling { components: components.into(), ..Coupling::default() };
        coupling.components[1].fraction = 0.03;
        coupling.solve(&mut [support(0, 1, 0.5), support(1, 2, 1.5)], 1e-6, |_| 0.5);
        let components = &coupling.components;
        let (linear, angular) = momenta(components);
        assert!(linear.norm() < 1e-15 && angular.norm() < 1e-15, "{linear} {angular}");
        let speeds = [0, 1, 2].map(|index| components[index].reference[0]);
        assert!((speeds[0] - speeds[1]).abs() < 0.2 && (speeds[1] - speeds[2]).abs() < 0.1, "{speeds:?}");
        let before = energy(components, |c| c.motion.components());
        let after = energy(components, |c| c.motion.components() + c.change * c.fraction);
        assert!(after < before, "{after} {before}");
    }

    #[test]
    fn undamped_components_are_not_coupled() {
        let components = [component(0, 1.0), component(1, -0.5)];
        let mut coupling = Coupling { components: components.into(), ..Coupling::default() };
        coupling.components[0].fraction = 0.0;
        coupling.solve(&mut [support(0, 1, 0.5)], 1e-3, |_| 0.5);
        assert!(coupling.components.iter().all(|component| component.change == Vector6::zeros()));
    }

    /// Pins leave mobilities at rounding level, which a division would raise without bound.
    #[test]
    fn components_that_pins_hold_are_not_moved() {
        use crate::dynamics::momentum::Projection;
        let mut components = [component(0, 1.0), component(1, -0.5)];
        for held in &mut components {
            let mut projection = Projection::new(held.mobility.clone(), held.motion, held.center);
            for point in [[0.3, 0.1, 0.7], [0.9, -0.4, 0.2], [-0.2, 0.8, 0.1]] {
                for axis in axes_without(None) {
                    projection.fix_velocity(held.center + Vector3::from(point), axis, 0.0);
                }
            }
            (held.mobility, held.reference) =
                (projection.mobility().clone(), projection.motion().components());
        }
        let mut coupling = Coupling { components: components.into(), ..Coupling::default() };
        coupling.solve(&mut [support(0, 1, 0.5)], 1e-3, |_| 0.5);
        assert!(coupling.components.iter().all(|component| component.change == Vector6::zeros()));
    }
}
