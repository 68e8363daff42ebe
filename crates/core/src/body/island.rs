//! The part of a body in an island: in bodies that touch each other, whose impulses are computed together.

use nalgebra::Vector3;

use super::context::StepContext;
use super::parts::{ContactData, Pipeline, Shape};
use super::soft_body::Body;
use crate::contact::bodies::{BodyContactPart, Island, MomentumChange};
use crate::dynamics::add_rigid;
use crate::parallel::Executor;
use crate::state::{ContactForce, Momentum};

impl Body {
    /// Applies the impulses and pushes of the island of the body. Does nothing for a body that is in no island.
    pub(super) fn resolve_body_contacts(
        &mut self,
        context: &StepContext,
        part: &BodyContactPart,
        executor: &Executor,
    ) {
        let &BodyContactPart::InIsland { contacts: between_bodies, island, member, index } = part else {
            return;
        };
        let was_asleep = self.is_asleep();
        if was_asleep {
            self.wake();
        }
        let dt = context.interval.dt;
        if self.is_rigid() {
            self.finish_island_rigidly(context, (island, member));
        } else {
            self.finish_island(context, (island, member, index), executor);
        }
        let unit = self.impulse_unit() / dt;
        let Self { contact: ContactData { contacts, .. }, state, .. } = self;
        let touched = island.pairs_of(index).flat_map(|pair| {
            let sides = [(0, 1), (1, 0)];
            sides.map(|(own, other)| (pair.bodies[own], pair.components[own], pair.bodies[other]))
        });
        let touched = touched.filter(|(body, ..)| *body == index);
        let between = island.pairs_of(index).filter(|pair| pair.bodies[0] == index);
        let between = between.map(|pair| ContactForce { key: pair.key, force: (pair.impulse / dt).into() });
        let pressures = contacts.iter().flat_map(|contacts| contacts.pressures());
        let with_colliders = pressures.map(|pressure| pressure.force(unit));
        let bodies = touched.map(|(_, component, other)| (component, other));
        // The bodies that the body touched when it fell asleep, and that still sleep, are not searched in this step.
        let keep = |other: u32| was_asleep && !between_bodies.is_pair(index, other);
        state.touches.set(keep, between_bodies.touches(index), bodies, between.chain(with_colliders));
    }

    /// Applies the impulses and pushes of an island to the pose of a rigid body.
    ///
    /// A contact moves the center of mass by D/M, so that its moment changes by D × V: see `Body::add_momenta`. A body that
    /// nothing else touches gives this change to its angular momentum.
    fn finish_island_rigidly(&mut self, context: &StepContext, (island, member): (&Island, usize)) {
        let dt = context.interval.dt;
        let cell_size = self.shape.lattice.cell_size();
        let Some((mut body, contacts)) = self.moved_in_contact() else { return };
        let (impulse, push) = island.rigid_motion(member);
        let touches_colliders = contacts.as_ref().is_some_and(|contacts| !contacts.pressures().is_empty());
        body.change(|rigid, pose| {
            rigid.apply_impulse(pose, impulse, dt);
            rigid.displace(pose, push);
            if rigid.held.is_empty() && !touches_colliders {
                let moved = impulse.linear * dt + push.linear * rigid.mass();
                let velocity = pose.velocity() - island.mean_velocity / cell_size;
                pose.set_angular_momentum(pose.angular_momentum() - moved.cross(&velocity));
            }
        });
        if let Some(contacts) = contacts {
            let step = (context.colliders, context.interval);
            island.finish_contacts(member, contacts, &mut body, step);
        }
    }

    /// Applies the impulses and pushes of an island to the vertices.
    fn finish_island(
        &mut self,
        context: &StepContext,
        (island, member, index): (&Island, usize, u32),
        executor: &Executor,
    ) {
        let dt = context.interval.dt;
        self.add_momenta(island, index, executor);
        let Self {
            contact: ContactData { contacts, .. },
            shape: Shape { lattice, .. },
            pipeline: Pipeline { matching, .. },
            state,
            ..
        } = self;
        let slots = matching.layout.slots();
        let mut body = state.body_state();
        for (vertex, change) in island.impacts(member) {
            let slot = slots[vertex as usize];
            body.set_velocity(slot, body.velocity(slot) + change);
            body.set_position(slot, body.position(slot) + change * dt);
        }
        for (vertex, push) in island.pushes(member) {
            let slot = slots[vertex as usize];
            body.set_position(slot, body.position(slot) + push);
        }
        if let Some(contacts) = contacts {
            island.finish_contacts(member, contacts, &mut body, (context.colliders, context.interval));
            for vertex in contacts.touched() {
                state.invalidate_momentum(lattice, vertex);
            }
        }
        state.energy_limit = None;
        self.restore_momenta(executor);
    }

    /// Adds the rigid motions to the velocities that restore the tracked momenta: impulses act at the positions before
    /// they move the vertices, and pushes change the angular momenta.
    fn restore_momenta(&mut self, executor: &Executor) {
        if !self.measure_tracked(executor) {
            return;
        }
        let Self { pipeline: Pipeline { matching, momentum, .. }, state, .. } = self;
        let (components, corrections) = momentum.corrections(&state.momenta);
        let occupied = matching.layout.occupied();
        add_rigid(components, corrections, (occupied, None), &state.positions, &mut state.velocities);
    }

    /// Measures the momenta of the components if some are tracked. Returns whether some are.
    fn measure_tracked(&mut self, executor: &Executor) -> bool {
        let Self { pipeline: Pipeline { matching, momentum, .. }, state, .. } = self;
        if state.momenta.iter().all(Option::is_none) {
            return false;
        }
        momentum.measure((matching, state), executor);
        true
    }

    /// Adds the impulses of an island to the tracked momenta.
    ///
    /// A contact changes the momenta of its two bodies by opposite amounts: the linear momentum by the impulse J, and
    /// the angular momentum about the origin by p × J. It also moves the centers of mass by D/M, and their moments
    /// change by D × V, with the mass M and the velocity V after the impulses; V is relative to the mean velocity of
    /// the island, so that the common motion of both bodies has no effect on their spins.
    fn add_momenta(&mut self, island: &Island, index: u32, executor: &Executor) {
        if !self.measure_tracked(executor) {
            return;
        }
        let (frame, cell_size) = (self.state.frame, self.shape.lattice.cell_size());
        let impulse_unit = self.impulse_unit();
        let Self {
            contact: ContactData { body_contact, .. },
            pipeline: Pipeline { momentum, .. },
            state,
            ..
        } = self;
        let Some(contact) = body_contact else { return };
        let changes = &mut contact.momentum_changes;
        changes.clear();
        changes.resize(momentum.states().len(), MomentumChange::default());
        for pair in island.pairs_of(index) {
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                if pair.bodies[side] == index {
                    let component = pair.components[side] as usize;
                    let MomentumChange { linear, angular, moved } = &mut changes[component];
                    let impulse = pair.impulse * (sign / impulse_unit);
                    let point = frame.to_local(pair.point);
                    *linear += impulse;
                    *angular += (point - momentum.states()[component].center).cross(&impulse);
                    *moved += pair.displacement * (sign / impulse_unit);
                }
            }
        }
        let mean_velocity = island.mean_velocity / cell_size - frame.velocity();
        for ((rigid, tracked), change) in momentum.states().iter().zip(&mut state.momenta).zip(&*changes) {
            let (Some(tracked), &MomentumChange { linear, mut angular, moved }) = (tracked, change) else {
                continue;
            };
            let velocity = (Vector3::from(tracked.linear) + linear) / rigid.mass - mean_velocity;
            angular -= moved.cross(&velocity);
            tracked.add(Momentum { linear: linear.into(), angular: angular.into() });
        }
    }
}
