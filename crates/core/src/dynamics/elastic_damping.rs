//! Damps the elastic modes of a body: moves the velocity of each vertex towards the reference motion of its component.
//!
//! The reference motion is a rigid motion, the one that is closest to the velocities in the metric of the mass, among
//! those that the surroundings of the component allow: it moves like the constrained vertices do, and it does not move
//! into or out of a collider that presses on it. Each step multiplies the difference of the velocities to the
//! reference motion by exp(-2 c dt), so that the amplitude of a mode with an angular frequency above c decays as
//! exp(-c t). A free component keeps its momenta: its reference motion is that of the rigid body with its momenta, so
//! that flight and spin are undamped.
//!
//! A body that rests on a collider also sways on it: its base stays, and most of it moves like a rigid body. Such a
//! motion is elastic, but it cannot be told from rolling or sliding by the velocities of one step. It can be told by the
//! way: each [`Support`] has a [`Deflection`], the rotation or the sliding of the component since the motion last
//! reversed, up to a limit, as the bristles of a model of friction have (Dahl 1968). Below the limit, the reference
//! motion does not take part; at the limit it does, in the direction of the deflection. So a body that rolls or slides
//! is damped only at the start, over an angle of [`LEAST_LIMIT`] or that part of its size, and one that sways is damped
//! after each reversal. A reversal doubles the limit, up to [`GREATEST_LIMIT`], and a long way in one direction lowers it
//! again, so that oscillations over short ways are damped most.

use nalgebra::Vector3;

use super::constraints::Constraints;
use super::momentum::{MomentumTracker, Projection, RigidMotion, RigidState, RigidVelocity, Sums, Weight};
use crate::simd::lanes::Lanes;
use crate::state::{Deflection, State, Support};

/// Least limit of a deflection: an angle in rad, or a length as a fraction of the size of the body. A body that sways
/// loses up to 4 c times the limit of its angular velocity between two reversals.
const LEAST_LIMIT: f64 = 5e-4;

/// Greatest limit of a deflection.
const GREATEST_LIMIT: f64 = 0.02;

/// Way beyond the limit after which the limit is divided by e.
const MEMORY: f64 = 0.2;

/// The elastic-damping stage. It computes the reference motions at the beginning of a step, and the acceleration towards
/// the goal positions applies them to the velocities before the step. So damping acts neither on the gravity of the step
/// nor on the impulses that carry the body.
#[derive(Clone, Debug, Default)]
pub(crate) struct ElasticDamper {
    /// Sums over the constrained vertices of each component, with unit masses, and their number.
    constrained: Vec<(Sums, f64)>,
    damped: Damped,
}

/// The damping of a step: velocities v become `keep` v + r, with a rigid velocity r of each component.
#[derive(Clone, Debug, Default)]
pub(crate) struct Damped {
    pub(crate) keep: f32,
    /// 1 - `keep` times the reference motion of each component.
    pub(crate) rigid: Vec<RigidVelocity>,
}

impl Damped {
    /// Returns the change of the velocity of a vertex of a component, in cells/s. `position` and `velocity` are in cells
    /// and cells/s from the origin of the body.
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

impl ElasticDamper {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.constrained.as_slice()) + size_of_val(self.damped.rigid.as_slice())
    }

    /// Returns the damping of the step.
    pub(crate) fn damped(&self) -> &Damped {
        &self.damped
    }

    /// Begins a step of `dt` seconds: computes the reference motions, and advances the deflections of the supports.
    ///
    /// `tracker` has measured the state. `slots` has the slot of each lattice vertex, `keep` is exp(-2 c dt), and
    /// `size` the size of the body in cells.
    pub(crate) fn begin(
        &mut self,
        constraints: Option<&Constraints>,
        (state, slots): (&mut State, &[u32]),
        tracker: &MomentumTracker,
        (keep, size, dt): (f64, f64, f64),
    ) {
        self.read_constrained(constraints, (state, slots), tracker);
        let mut rigid = std::mem::take(&mut self.damped.rigid);
        rigid.clear();
        for (component, measured) in tracker.states().iter().enumerate() {
            let motion = measured.motion(measured.momentum);
            let supports = state.supports.list_mut();
            let reference = self.reference((component, measured), motion, supports, (size, dt));
            // The surroundings of the component change its momenta.
            if let Some(momentum) = &mut state.momenta[component] {
                momentum.add(measured.momentum_of((reference - motion) * (1.0 - keep)));
            }
            rigid.push((reference * (1.0 - keep)).about_origin(measured.center));
        }
        self.damped = Damped { keep: keep as f32, rigid };
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

    /// Returns the reference motion of a component, and advances the deflections of its supports by a step of `dt`
    /// seconds. `motion` is the rigid motion with the momenta of the component, and `size` the size of the body in
    /// cells.
    fn reference(
        &self,
        (component, rigid): (usize, &RigidState),
        motion: RigidMotion,
        supports: &mut [Support],
        (size, dt): (f64, f64),
    ) -> RigidMotion {
        let constrained = self.constrained.get(component).filter(|(_, count)| *count > 0.0);
        let mut supports =
            supports.iter_mut().filter(|support| support.component as usize == component).peekable();
        if constrained.is_none() && supports.peek().is_none() {
            return motion;
        }
        let mut projection = Projection::new(rigid, motion);
        if let Some((sums, count)) = constrained {
            projection.fix_vertices(&sums.rigid_state(*count));
        }
        // Colliders at rest add no energy: the damped velocities lie between the velocities and the reference motion.
        let mut limit = rigid.energy_of(motion);
        for support in supports {
            rest_on(&mut projection, support, (size, dt), motion, rigid.center);
            limit += 0.5 * rigid.mass * Vector3::from(support.velocity).norm_squared();
        }
        let reference = projection.motion();
        let energy = rigid.energy_of(reference);
        if constrained.is_none() && energy > limit { reference * (limit / energy).sqrt() } else { reference }
    }
}

/// Adds the conditions of a support, and advances its deflections.
fn rest_on(
    projection: &mut Projection,
    support: &mut Support,
    (size, dt): (f64, f64),
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

/// Adds `change` to a deflection. Returns its direction if it is at the limit and grows.
fn deflect(deflection: &mut Deflection, change: Vector3<f64>) -> Option<Vector3<f64>> {
    let Deflection { vector, limit, is_at_limit } = deflection;
    if *is_at_limit && change.dot(&Vector3::from(*vector)) < 0.0 {
        (*limit, *is_at_limit) = ((2.0 * *limit).min(GREATEST_LIMIT), false);
    }
    *limit = limit.max(LEAST_LIMIT);
    let moved = Vector3::from(*vector) + change;
    let length = moved.norm();
    if !length.is_finite() {
        return None;
    }
    if length < *limit {
        *vector = moved.into();
        return None;
    }
    let direction = moved / length;
    *limit = (*limit * (-(length - *limit) / MEMORY).exp()).max(LEAST_LIMIT);
    (*vector, *is_at_limit) = ((direction * *limit).into(), true);
    (change.dot(&direction) > 0.0).then_some(direction)
}

/// Returns three perpendicular unit vectors, or the two that are perpendicular to `free`.
fn axes_without(free: Option<Vector3<f64>>) -> impl Iterator<Item = Vector3<f64>> {
    let axes = match free {
        None => [Vector3::x(), Vector3::y(), Vector3::z()],
        Some(direction) => {
            let helper = Vector3::ith(direction.iamin(), 1.0);
            let first = direction.cross(&helper).normalize();
            [first, direction.cross(&first), Vector3::zeros()]
        }
    };
    // A condition on the zero vector is none.
    axes.into_iter().filter(|axis| *axis != Vector3::zeros())
}
