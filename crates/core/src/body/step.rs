//! One step of a body.

use nalgebra::Vector3;

use super::Body;
use crate::contact::Colliders;
use crate::dynamics::{Accelerate, Advance, Constraints, EnergyLimiter};
use crate::matching::Purpose;
use crate::parallel::{CHUNK, Executor};
use crate::state::Interval;

/// What acts on all bodies in a step.
pub(crate) struct World<'a> {
    /// Scene units per second squared.
    pub(crate) gravity: Vector3<f64>,
    pub(crate) interval: Interval,
    /// Whether this is the first step of a frame.
    pub(crate) opens_frame: bool,
    pub(crate) colliders: &'a Colliders,
}

/// A stage of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    BeginConstraints,
    Forces,
    Momentum,
    RegionDamping,
    BeginContacts,
    Matching,
    Integration,
    Contacts,
    Constraints,
}

/// The stages in the order in which they run. This list is the program: [`Body::step`] runs it, and the plan prints it
/// with the memory of each, followed by the two stages of a display.
pub(super) const STEP: [Stage; 9] = [
    Stage::BeginConstraints,
    Stage::Forces,
    Stage::Momentum,
    Stage::RegionDamping,
    Stage::BeginContacts,
    Stage::Matching,
    Stage::Integration,
    Stage::Contacts,
    Stage::Constraints,
];

impl Body {
    /// One step: the stages that the body has, in the order of [`STEP`].
    pub(crate) fn step(&mut self, world: &World, executor: &Executor) {
        self.meet(world.colliders);
        for stage in STEP {
            if self.has(stage) {
                self.run(stage, world, executor);
            }
        }
    }

    /// Whether the body has a stage. One that it lacks takes no time and no memory.
    pub(super) fn has(&self, stage: Stage) -> bool {
        match stage {
            Stage::BeginConstraints | Stage::Constraints => self.constraints.is_some(),
            Stage::Forces => self.forces.is_some(),
            Stage::RegionDamping => self.region_damping.is_some(),
            Stage::BeginContacts | Stage::Contacts => self.contacts.is_some(),
            Stage::Momentum | Stage::Matching | Stage::Integration => true,
        }
    }

    /// With h the length of the step, f external forces, a gravity, and g the goal position of a vertex at x:
    fn run(&mut self, stage: Stage, world: &World, executor: &Executor) {
        match stage {
            // Pins and handles that become active capture the positions of their vertices.
            Stage::BeginConstraints => self.begin_constraints(world),
            // v += h f/m
            Stage::Forces => self.apply_external_forces(world),
            // Momenta that are not known are measured; the frame stays near the body.
            Stage::Momentum => self.track_momentum(executor),
            // v += share (v̄ - v), with v̄ the mean of the rigid velocities of the regions that hold the vertex.
            Stage::RegionDamping => self.damp(world, executor),
            // The velocities before the matching are those with which the surface meets a collider.
            Stage::BeginContacts => self.begin_contacts(),
            // v += alpha (g - x)/h + h a
            Stage::Matching => self.accelerate(world, executor),
            // x += h v
            Stage::Integration => self.integrate(world, executor),
            // Impulses on the visible surface.
            Stage::Contacts => self.resolve_contacts(world),
            // Held vertices follow their pins and handles.
            Stage::Constraints => self.apply_constraints(world),
        }
    }

    /// Whether a step is not divided among threads: its tasks would be too small.
    pub(crate) fn is_one_task(&self) -> bool {
        self.matching.layout.blocks() <= CHUNK
    }

    /// Whether neither constraints nor contacts act on the body.
    fn is_free(&self) -> bool {
        self.contacts.is_none() && !self.constraints.as_ref().is_some_and(Constraints::any_active)
    }

    fn begin_constraints(&mut self, world: &World) {
        let Self { constraints: Some(constraints), matching, state, .. } = self else { return };
        if constraints.begin(world.interval, &state.shared(), matching.layout.slots()) {
            self.track_constraints();
        }
    }

    /// The momenta of components with held vertices are not conserved.
    pub(super) fn track_constraints(&mut self) {
        let Self { constraints, matching, momentum, state, .. } = self;
        match constraints {
            Some(constraints) => {
                momentum.constrain(matching.layout.slots(), constraints.held(), &mut state.momenta);
            }
            None => momentum.release(),
        }
    }

    fn apply_external_forces(&mut self, world: &World) {
        let Self { forces: Some(forces), lattice, matching, material, state, .. } = self else { return };
        let mass = |vertex| super::mass(material, lattice, vertex);
        let when = (world.interval, world.opens_frame);
        forces.apply(when, (lattice, matching.layout.slots()), mass, state);
        if forces.is_empty() {
            self.forces = None;
        }
    }

    /// The frame of a free body moves with it, so that f32 velocities and positions stay small.
    fn track_momentum(&mut self, executor: &Executor) {
        let is_free = self.is_free();
        let Self { matching, momentum, state, .. } = self;
        let slots = matching.layout.slots();
        if !is_free {
            state.set_origin_velocity(slots, Vector3::zeros());
        }
        if !is_free || state.momenta.contains(&None) {
            state.energy_limit = None;
        }
        let (strayed, unknown) = (state.strayed(slots[0]), momentum.any_unknown(&state.momenta));
        if !strayed && !unknown {
            return;
        }
        let (bounds, weights) = (matching.cascade.bounds(), &matching.regions.weights);
        momentum.measure(executor, bounds, weights, &state.positions, &state.velocities);
        if strayed {
            state.rebase(slots, momentum.center());
        }
        if unknown && is_free {
            state.set_origin_velocity(slots, state.frame.velocity() + momentum.velocity());
            momentum.measure(executor, bounds, weights, &state.positions, &state.velocities);
        }
        momentum.adopt(&mut state.momenta);
    }

    /// Region damping comes before the matching: after it, held vertices would pass on the acceleration that they do
    /// not follow.
    fn damp(&mut self, world: &World, executor: &Executor) {
        let Self { region_damping: Some(region_damping), matching, workspace, material, state, .. } = self
        else {
            return;
        };
        if !state.fitted {
            let fitted = (&state.positions, &mut state.rotations);
            matching.fit(workspace, executor, fitted, None, Purpose::Transform);
        }
        let share = material.region_damping_share(world.interval.dt);
        region_damping.apply(matching, workspace, executor, state, share as f32);
    }

    fn begin_contacts(&mut self) {
        if let Some(contacts) = &mut self.contacts {
            contacts.begin(&self.state.velocities);
        }
    }

    /// v += alpha (g - x)/h + h a. Gravity acts on the frame of a free body, and on the vertices of others.
    ///
    /// Near two best rotations of a region the energy of a free body is limited: the sums are then made twice.
    fn accelerate(&mut self, world: &World, executor: &Executor) {
        let is_free = self.is_free();
        let Self { matching, workspace, momentum, energy, material, lattice, state, .. } = self;
        let dt = world.interval.dt;
        let mut gain = world.gravity * (dt / lattice.cell_size());
        if is_free {
            state.frame.fly(gain, dt);
            gain = Vector3::zeros();
        }

        let fitted = (&state.positions, &mut state.rotations);
        let unsettled = matching.fit(workspace, executor, fitted, None, Purpose::Adjoint);
        self.unsettled += unsettled;
        state.fitted = true;
        let limiter =
            (is_free && unsettled > 0).then(|| energy.get_or_insert_with(|| EnergyLimiter::new(matching)));
        if let Some(limiter) = &limiter {
            let fitted = (&state.positions, &mut state.rotations);
            matching.fit(workspace, executor, fitted, Some(limiter.potential()), Purpose::Adjoint);
        }
        let limiter = limiter.map(|limiter| {
            limiter.begin(&state.velocities);
            &*limiter
        });

        let stiffness_rate = material.alpha(dt) / dt;
        let (weights, track) = (&matching.regions.weights, momentum.any_free());
        let (components, sums) = momentum.begin_sums();
        let update = Accelerate {
            weights,
            positions: &state.positions,
            stiffness_rate: stiffness_rate as f32,
            gain: gain.map(|v| v as f32).into(),
            components: track.then_some(components),
        };
        let (layout, velocities) = (&matching.layout, state.velocities.blocks_mut());
        matching.cascade.adjoint(layout, executor, workspace, &update, velocities, sums);
        momentum.finish_sums();

        if let Some(limiter) = limiter {
            limiter.apply((stiffness_rate, dt), weights, state, momentum);
        }
        momentum.add_impulse(&mut state.momenta, gain);
    }

    /// x += h v, with the velocities corrected to the known momenta.
    fn integrate(&mut self, world: &World, executor: &Executor) {
        let Self { matching, momentum, state, .. } = self;
        let (components, corrections) = momentum.corrections(&state.momenta);
        let occupied = matching.layout.occupied();
        let advance = Advance { occupied, components, corrections, dt: world.interval.dt };
        advance.run(executor, &mut state.positions, &mut state.compensation, &mut state.velocities);
    }

    /// The momenta of touched components are measured anew.
    fn resolve_contacts(&mut self, world: &World) {
        let Self { contacts: Some(contacts), lattice, state, .. } = self else { return };
        if world.opens_frame {
            contacts.clear_pushes();
        }
        contacts.resolve(&mut state.shared(), world.colliders, world.interval, world.gravity.into());
        for vertex in contacts.touched() {
            state.invalidate_momentum(lattice, vertex);
        }
    }

    fn apply_constraints(&mut self, world: &World) {
        if let Some(constraints) = &self.constraints {
            constraints.apply(world.interval, &mut self.state.shared(), self.matching.layout.slots());
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::{Collider, Lattice, Selection, Simulation};

    fn known(simulation: &Simulation) -> Vec<bool> {
        simulation.body(0).state.momenta.iter().map(Option::is_some).collect()
    }

    #[test]
    fn contacts_and_forces_invalidate_the_momenta_of_their_components_only() {
        let lattice = Lattice::from_cells(&[[0, 0, 0], [4, 0, 0], [8, 0, 0]], 1.0, Point3::origin(), false);
        let mut body = Body::from_lattice(lattice.unwrap()).build().unwrap();
        body.apply_forces(&[(2, [1.0, 0.0, 0.0])]).unwrap();
        let ball = Collider::sphere([8.5, -1.0, 0.5], 1.5);
        let mut simulation =
            Simulation::builder().body(body).collider(ball).gravity([0.0; 3]).build().unwrap();
        simulation.step();
        assert_eq!(known(&simulation), [true, true, false]);
        let body = simulation.body_mut(0);
        body.apply_force([1.0; 3], &Selection::Vertices(vec![2])).unwrap();
        let (gravity, interval) = (Vector3::zeros(), Interval::of_step(1, 1.0));
        let colliders = &Colliders::new(&[]).unwrap();
        body.apply_external_forces(&World { gravity, interval, opens_frame: true, colliders });
        assert_eq!(known(&simulation), [true, false, false]);
    }
}
