//! Forces that pins and handles exert on a body.

use nalgebra::{Point3, Vector3};

use super::parts::Pipeline;
use super::reference::{BodyRef, DisplayContext};
use super::soft_body::Body;
use crate::dynamics::{Constraint, ConstraintError};
use crate::matching::Purpose;
use crate::simd::vector::wide;
use crate::state::Interval;

/// The force that a pin or handle exerts on a body, in world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct HoldForce {
    /// Force, in kg x length / s^2.
    pub force: Vector3<f64>,
    /// Torque about `center`, in kg x length^2 / s^2.
    pub torque: Vector3<f64>,
    /// Mean position of the lattice vertices of the pin or handle.
    pub center: Point3<f64>,
}

impl BodyRef<'_> {
    /// Computes the force and the torque that a pin or handle exerts in the next step, from the current state: its
    /// lattice vertices need this force, beside the elastic forces and gravity, to move as prescribed. `None` outside a
    /// simulation; zero if the pin or handle did not act in the last step.
    ///
    /// The reaction of the elastic damping is included, shared by the pins and handles of a connected component in
    /// proportion to the masses that they hold; it is missing until the next step after a state was restored, the
    /// damping was changed or the body broke. Contacts, external forces on the held vertices and region damping are
    /// not included. Where keyframes change the velocity, the force makes the change within one step. A call costs
    /// as much as a step.
    ///
    /// * `index`: as for [`Body::release`].
    ///
    /// # Errors
    ///
    /// An index out of range, or a released pin or handle.
    pub fn hold_force(self, index: usize) -> Result<Option<HoldForce>, ConstraintError> {
        let constraint = self.constraint(index)?;
        Ok(self.context().map(|context| {
            if constraint.is_active() {
                self.get().force_of(constraint, context)
            } else {
                HoldForce::default()
            }
        }))
    }
}

impl Body {
    fn force_of(&self, constraint: &Constraint, context: DisplayContext<'_>) -> HoldForce {
        let DisplayContext { gravity, dt, time, executor, .. } = context;
        let Self { pipeline: Pipeline { matching, .. }, state, .. } = self;
        let slots = matching.layout.slots();
        let position = |vertex: u32| state.frame.to_world(state.local(slots[vertex as usize]));
        let vertices = constraint.vertices();
        // Sums relative to the origin of the body keep the accuracy far from the world origin.
        let origin = state.frame.to_world(Vector3::zeros());
        let sum: Vector3<f64> = vertices.iter().map(|&vertex| position(vertex) - origin).sum();
        let center = origin + sum / vertices.len().max(1) as f64;
        let mut result = HoldForce { center, ..HoldForce::default() };
        let step = Interval { start: time, end: time + dt, dt };
        let mut add = |force: Vector3<f64>, point: Point3<f64>| {
            result.force += force;
            result.torque += (point - center).cross(&force);
        };

        let in_step = constraint.in_step(step, executor);
        if !constraint.holds_all() {
            let mut state = self.state.clone();
            let pose = self.rigid.as_deref().zip(state.rigid.as_ref());
            let mass_factor = pose.map_or(1.0, |(rigid, pose)| rigid.lattice_center(pose).1);
            for (vertex, acceleration) in in_step.accelerations(step, &state.body_state(), slots) {
                add(acceleration * (self.mass_of(vertex) * mass_factor), position(vertex));
            }
        }
        if constraint.held().next().is_none() {
            return result;
        }
        if let Some((force, torque)) = self.reaction_of(constraint, gravity, (step, executor), center) {
            return HoldForce { force: result.force + force, torque: result.torque + torque, center };
        }
        let (workspace, _) = self.fit_now(executor, Purpose::Vertices);
        let goals = matching.goals(&workspace, executor);
        let stiffness = self.alpha(dt) * self.cell_mass() * self.shape.lattice.cell_size() / (dt * dt);
        let moved = in_step.targets(step).filter(|&(vertex, ..)| self.is_moved_by(constraint, vertex));
        for (vertex, _, motion) in moved {
            let slot = slots[vertex as usize];
            let mass = self.mass_of(vertex);
            // The regions act on the vertex with its mass in the fits.
            let strength = stiffness * matching.regions.goal_strength(slot);
            let distance = wide(goals.get(slot)) - state.local(slot);
            let velocity = state.frame.velocity_to_world(state.velocities.get(slot));
            let acceleration = (motion / dt - velocity) / dt;
            add((acceleration - gravity) * mass - distance * strength, position(vertex));
        }
        self.add_damping(constraint, dt, &mut add);
        result
    }

    /// Returns whether a vertex of an active pin or handle is moved by it, and not by a later one.
    fn is_moved_by(&self, constraint: &Constraint, vertex: u32) -> bool {
        self.constraints.as_ref().is_some_and(|constraints| constraints.is_moved_by(constraint, vertex))
    }

    /// Adds the reaction of the elastic damping: the momentum per time that it takes from the vertices that move
    /// freely, which pins, handles and colliders absorb.
    fn add_damping(&self, constraint: &Constraint, dt: f64, add: &mut impl FnMut(Vector3<f64>, Point3<f64>)) {
        let Self {
            pipeline: Pipeline { elastic_damping: Some(damper), matching, momentum, .. },
            constraints: Some(constraints),
            state,
            ..
        } = self
        else {
            return;
        };
        let (damped, of_vertex) = (damper.damped(), &self.shape.lattice.components().of_vertex);
        // Only a step computes it.
        if damped.rigid.is_empty() {
            return;
        }
        let is_held = constraints.constrained();
        // Masses that are held by this constraint, and by all of them.
        let mut held = vec![[0.0; 2]; damped.rigid.len()];
        for vertex in (0..of_vertex.len() as u32).filter(|&vertex| is_held[vertex as usize]) {
            held[of_vertex[vertex as usize] as usize][1] += self.mass_of(vertex);
        }
        let vertices = constraint.vertices().iter().copied();
        for vertex in vertices.filter(|&vertex| self.is_moved_by(constraint, vertex)) {
            held[of_vertex[vertex as usize] as usize][0] += self.mass_of(vertex);
        }
        for (vertex, &slot) in (0..).zip(matching.layout.slots()) {
            let component = of_vertex[vertex as usize] as usize;
            let [own, all] = held.get(component).copied().unwrap_or_default();
            if own > 0.0 && !is_held[vertex as usize] {
                let velocity = wide(state.velocities.get(slot));
                let change = damper.change((component, slot), state.local(slot), velocity);
                let force = self.mass_of(vertex) * self.shape.lattice.cell_size() / dt * own / all * change;
                add(force, state.frame.to_world(state.local(slot)));
            }
        }
        // The impulses after the contacts, without the part of the colliders.
        for ((component, state), [own, all]) in (0..).zip(damper.states(momentum)).zip(&held) {
            if *own > 0.0 {
                let force =
                    damper.taken_from_surroundings(component) * (self.impulse_unit() / dt * own / all);
                add(force, self.state.frame.to_world(state.center));
            }
        }
        for reaction in damper.reactions() {
            let [own, all] = held.get(reaction.component as usize).copied().unwrap_or_default();
            if own > 0.0 {
                let force = reaction.impulse * (self.impulse_unit() / dt * own / all);
                add(-force, state.frame.to_world(reaction.point));
            }
        }
    }
}
