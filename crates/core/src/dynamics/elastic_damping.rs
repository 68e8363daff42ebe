//! Damps the elastic modes of a body: moves the velocity of each vertex towards the reference motion of its component.
//!
//! The reference motion is the rigid motion that is closest to the velocities in the metric of the mass and meets the
//! conditions of the surroundings: it moves like the constrained vertices, and it does not move into or out of a
//! collider that presses on the component. Each step multiplies the difference of the velocities to the
//! reference motion by exp(-2 c dt), so that the amplitude of a mode with an angular frequency above c decays as
//! exp(-c t). A free component keeps its momenta: its reference motion is the rigid motion with its momenta, so
//! that flight and spin are undamped.
//!
//! A body that rests on a collider also sways on it: its base stays, and most of it moves like a rigid body. Such a
//! motion is elastic, but the velocities of one step do not distinguish it from rolling or sliding. The displacement
//! does: each [`Support`] has a [`Deflection`], the rotation or the sliding of the component since the
//! motion last reversed, up to a limit, as the bristles of a model of friction have (Dahl 1968). Below the limit, the
//! reference motion does not take part; at the limit it does, in the direction of the deflection. So a body that
//! rolls or slides is damped only at the start, over an angle of [`LEAST_LIMIT`](super::deflection) or that part of
//! its size, and one that sways is damped after each reversal. A reversal doubles the limit, up to
//! [`GREATEST_LIMIT`](super::deflection), and a long displacement in one direction lowers it again, so that
//! oscillations over short displacements are damped most.
//!
//! A component that rolls on a collider is slowed by *rolling resistance*: the center of pressure of a contact lies
//! ahead, by a fraction of the radius of the contact, so that it has a torque about the contact (Coulomb 1785; for
//! soft bodies Greenwood et al. 1961). The torque is at most that fraction times the radius times the normal force,
//! and at most as great as stops the rolling in the step. The radius is √(s + 1/4) cells, with the mean square s of
//! the distances of the contacts from their center: the lattice resolves no smaller ones.

use nalgebra::{Vector3, Vector6};

use super::constraints::Constraints;
use super::coupling::CoupledComponent;
use super::deflection::{axes_without, deflect};
use super::momentum::{
    Mobility, MomentumTracker, Projection, RigidMotion, RigidState, RigidVelocity, Sums, Weight,
};
use crate::simd::lanes::Lanes;
use crate::state::{State, Support};

/// The elastic-damping stage. It computes the reference motions at the beginning of a step, and the acceleration
/// towards the goal positions applies them to the velocities before the step. So damping acts neither on the gravity of
/// the step nor on the impulses that carry the body.
#[derive(Clone, Debug, Default)]
pub(crate) struct ElasticDamper {
    /// Sums over the constrained vertices of each component, with unit masses, and their number.
    constrained: Vec<(Sums, f64)>,
    /// The reference motion of each component.
    references: Vec<Reference>,
    /// Component and index of each support, in increasing order.
    supports: Vec<(u32, u32)>,
    keep: f64,
    damped: Damped,
}

/// The reference motion of a component.
#[derive(Clone, Debug)]
struct Reference {
    /// Rigid motion with the momenta of the component.
    motion: RigidMotion,
    reference: RigidMotion,
    /// The change of the rigid motion in a step by rolling resistance.
    rolling: RigidMotion,
    /// Present if the component is constrained or supported.
    projection: Option<Projection>,
}

/// The damping of a step: velocities v become `keep` v + r, with a rigid velocity r of each component.
#[derive(Clone, Debug, Default)]
pub(crate) struct Damped {
    pub(super) keep: f32,
    /// 1 - `keep` times the reference motion of each component.
    pub(crate) rigid: Vec<RigidVelocity>,
}

impl Damped {
    /// Returns the change of the velocity of a vertex of a component, in cells/s. `position` and `velocity` are in
    /// cells and cells/s from the origin of the body.
    pub(crate) fn change(
        &self,
        component: usize,
        position: Vector3<f64>,
        velocity: Vector3<f64>,
    ) -> Vector3<f64> {
        let RigidVelocity { linear, angular } = self.rigid[component];
        let [linear, angular] = [linear, angular].map(|v| Vector3::from(v.map(f64::from)));
        velocity * (f64::from(self.keep) - 1.0) + linear + angular.cross(&position)
    }
}

/// The numbers of a step that the damping depends on.
#[derive(Clone, Copy)]
pub(crate) struct DampingStep<'a> {
    /// Length of the step in seconds.
    pub(crate) dt: f64,
    /// exp(-2 c dt), the fraction of the differences that remains.
    pub(crate) keep: f64,
    /// Size of the body in cells.
    pub(crate) size: f64,
    /// Returns the coefficient of rolling resistance on a collider.
    pub(crate) rolling_resistance: &'a dyn Fn(u32) -> f64,
}

impl ElasticDamper {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.constrained.as_slice())
            + size_of_val(self.references.as_slice())
            + size_of_val(self.supports.as_slice())
            + size_of_val(self.damped.rigid.as_slice())
    }

    /// Returns the damping of the step.
    pub(crate) fn damped(&self) -> &Damped {
        &self.damped
    }

    /// Begins a step: computes the reference motions, and advances the deflections of the supports.
    ///
    /// `tracker` has measured the state. `slots` has the slot of each lattice vertex.
    pub(crate) fn begin(
        &mut self,
        constraints: Option<&Constraints>,
        (state, slots): (&mut State, &[u32]),
        tracker: &MomentumTracker,
        step: DampingStep<'_>,
    ) {
        self.read_constrained(constraints, (state, slots), tracker);
        let supports = state.supports.list_mut();
        self.supports.clear();
        self.supports.extend(supports.iter().zip(0..).map(|(support, index)| (support.component, index)));
        self.supports.sort_unstable();
        let mut references = std::mem::take(&mut self.references);
        references.clear();
        let mut rest = &*self.supports;
        for (component, measured) in tracker.states().iter().enumerate() {
            let motion = measured.motion(measured.momentum);
            let count = rest.partition_point(|(supported, _)| *supported as usize == component);
            let (own, others) = rest.split_at(count);
            rest = others;
            references.push(self.reference((component, measured), motion, (supports, own), step));
        }
        (self.references, self.keep) = (references, step.keep);
    }

    /// Returns the reference motion of a component that presses on other bodies, to be coupled with theirs. `size` is
    /// the size of the body in scene units.
    pub(crate) fn coupled(
        &self,
        side: (u32, u32),
        (state, tracker): (&State, &MomentumTracker),
        (size, cell_mass): (f64, f64),
    ) -> CoupledComponent {
        let (frame, measured) = (state.frame, &tracker.states()[side.1 as usize]);
        let Reference { motion, reference, projection, .. } = &self.references[side.1 as usize];
        let cell_size = frame.cell_size();
        let world = |motion: &RigidMotion| RigidMotion {
            linear: (motion.linear + frame.velocity()) * cell_size,
            angular: motion.angular,
        };
        let mobility = match projection {
            Some(projection) => projection.mobility().clone(),
            None => Mobility::of_body(measured.mass, measured.inertia()),
        };
        CoupledComponent {
            side,
            center: frame.to_world(measured.center).coords,
            motion: world(motion),
            reference: world(reference).components(),
            mobility: mobility.in_units(cell_size, cell_mass),
            fraction: 1.0 - self.keep,
            size,
            change: Vector6::zeros(),
        }
    }

    /// Changes the reference motion of a component by the change of a coupling. `cell_size` is in scene units.
    pub(crate) fn add_change(&mut self, component: &CoupledComponent, cell_size: f64) {
        let RigidMotion { linear, angular } = RigidMotion::from_components(&component.change);
        let reference = &mut self.references[component.side.1 as usize].reference;
        *reference = *reference + RigidMotion { linear: linear / cell_size, angular };
    }

    /// Completes the damping of the step from the reference motions.
    pub(crate) fn finish(&mut self, state: &mut State, tracker: &MomentumTracker) {
        let Self { references, keep, damped, .. } = self;
        damped.keep = *keep as f32;
        damped.rigid.clear();
        for (component, measured) in tracker.states().iter().enumerate() {
            let &Reference { motion, reference, rolling, .. } = &references[component];
            // The surroundings of the component change its momenta.
            if let Some(momentum) = &mut state.momenta[component] {
                momentum.add(measured.momentum_of((reference - motion) * (1.0 - *keep) + rolling));
            }
            damped.rigid.push((reference * (1.0 - *keep) + rolling).about_origin(measured.center));
        }
    }

    /// Sums the motion of the constrained vertices of each component.
    fn read_constrained(
        &mut self,
        constraints: Option<&Constraints>,
        (state, slots): (&State, &[u32]),
        tracker: &MomentumTracker,
    ) {
        self.constrained.clear();
        let Some(constraints) = constraints.filter(|constraints| constraints.any_active()) else { return };
        self.constrained.resize(tracker.states().len(), (Sums::default(), 0.0));
        let active = constraints.list().iter().filter(|constraint| constraint.is_active());
        for &vertex in active.flat_map(|constraint| constraint.vertices()) {
            let slot = slots[vertex as usize];
            let (sums, count) = &mut self.constrained[tracker.components().of_slot(slot)];
            let vector = |lanes: &Lanes<3>| lanes.get(slot).map(f64::from);
            sums.add_vertex(1.0, vector(&state.positions), vector(&state.velocities));
            *count += 1.0;
        }
    }

    /// Returns the reference motion of a component, and advances the deflections of its supports. `motion` is the rigid
    /// motion with the momenta of the component, and `own` has its supports, as in `self.supports`.
    fn reference(
        &self,
        (component, rigid): (usize, &RigidState),
        motion: RigidMotion,
        (supports, own): (&mut [Support], &[(u32, u32)]),
        step: DampingStep<'_>,
    ) -> Reference {
        let constrained = self.constrained.get(component).filter(|(_, count)| *count > 0.0);
        let mut rolling = RigidMotion::ZERO;
        if constrained.is_none() && own.is_empty() {
            return Reference { motion, reference: motion, rolling, projection: None };
        }
        let mobility = Mobility::of_body(rigid.mass, rigid.inertia());
        let mut projection = Projection::new(mobility.clone(), motion, rigid.center);
        if let Some((sums, count)) = constrained {
            projection.fix_vertices(&sums.rigid_state(*count));
        }
        // Colliders at rest add no energy: the damped velocities lie between the velocities and the reference motion.
        let mut limit = rigid.energy_of(motion);
        for &(_, index) in own {
            let support = &mut supports[index as usize];
            rest_on(&mut projection, support, &step, motion, rigid.center);
            limit += 0.5 * rigid.mass * Vector3::from(support.velocity).norm_squared();
            let coefficient = (step.rolling_resistance)(support.collider);
            if coefficient > 0.0 && constrained.is_none() {
                rolling = rolling + resistance(support, coefficient, &mobility, motion + rolling);
            }
        }
        let reference = projection.motion();
        let energy = rigid.energy_of(reference);
        let is_limited = constrained.is_none() && energy > limit;
        let reference = if is_limited { reference * (limit / energy).sqrt() } else { reference };
        Reference { motion, reference, rolling, projection: Some(projection) }
    }
}

/// Returns the change of the rigid motion of a component by rolling resistance at a support. `coefficient`: of the
/// resistance. `mobility`, `motion`: of the component, without conditions.
fn resistance(support: &Support, coefficient: f64, mobility: &Mobility, motion: RigidMotion) -> RigidMotion {
    let [normal, spin] = [support.normal, support.spin].map(Vector3::from);
    let turning = motion.angular - spin;
    let rolling = turning - normal * normal.dot(&turning);
    let Some(axis) = rolling.try_normalize(0.0) else { return RigidMotion::ZERO };
    // A torque without a force: friction changes the velocity of the center.
    let turned = mobility.turn(axis);
    let radius = (support.squared_radius + 0.25).sqrt();
    // Without a mean normal, no force presses.
    let torque = coefficient * radius * support.impulse * normal.norm();
    // About the axis, the component is stopped at most: no work is done.
    let stopping = rolling.norm() / axis.dot(&turned);
    match stopping.is_finite() {
        true => RigidMotion { angular: -turned * torque.min(stopping), ..RigidMotion::ZERO },
        false => RigidMotion::ZERO,
    }
}

/// Adds the conditions of a support, and advances its deflections.
fn rest_on(
    projection: &mut Projection,
    support: &mut Support,
    &DampingStep { size, dt, .. }: &DampingStep<'_>,
    motion: RigidMotion,
    center: Vector3<f64>,
) {
    let [point, normal, surface, spin] =
        [support.point, support.normal, support.velocity, support.spin].map(Vector3::from);
    projection.fix_velocity(point, normal, normal.dot(&surface), Weight::Soft);

    let turning = motion.angular - spin;
    let free = deflect(&mut support.rotation, turning * dt);
    for axis in axes_without(free) {
        projection.fix_spin(axis, axis.dot(&spin), Weight::Soft);
    }

    let slip = motion.linear + motion.angular.cross(&(point - center)) - surface;
    let free = deflect(&mut support.sliding, (slip - normal * normal.dot(&slip)) * (dt / size));
    for axis in axes_without(free) {
        projection.fix_velocity(point, axis, axis.dot(&surface), Weight::Soft);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    /// A torque about a horizontal axis leaves the angular momentum about the normal, and takes energy, also from a
    /// body whose moments of inertia couple the axes.
    #[test]
    fn rolling_resistance_takes_energy_and_no_angular_momentum_about_the_normal() {
        let inertia = Matrix3::new(1.0, -0.5, 0.0, -0.5, 1.0, 0.0, 0.0, 0.0, 0.3);
        let mobility = Mobility::of_body(2.0, &inertia);
        for (spin, impulse) in [([0.1, 10.0, 0.0], 1e9), ([3.0, -1.0, 2.0], 0.5), ([3.0, -1.0, 2.0], 1e9)] {
            let motion = RigidMotion { angular: spin.into(), ..RigidMotion::ZERO };
            let support = Support { normal: [0.0, 1.0, 0.0], impulse, ..Support::default() };
            let after = motion.angular + resistance(&support, 0.1, &mobility, motion).angular;
            let energy = |angular: Vector3<f64>| 0.5 * angular.dot(&(inertia * angular));
            assert!(energy(after) < energy(motion.angular), "{after:?}");
            assert!((inertia * (after - motion.angular)).y.abs() < 1e-12);
        }
    }
}
