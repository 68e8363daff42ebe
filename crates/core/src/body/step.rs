//! One step of a body: [`STEP`] lists the stages, and `Body::run` has the formula and the module of each.
//!
//! Symbols: h is the step length, x, v and m are the position, velocity and mass of a vertex, n is the number
//! of regions that contain it, c is the center of mass of a region and x̄ that of a component, superscript 0
//! is the rest pose, f is an external force, a is gravity, and
//! alpha and d are the stiffness and the region damping per step. The crate page has the citations.

use nalgebra::Vector3;

use super::Body;
use crate::contact::Colliders;
use crate::dynamics::{Accelerate, Advance, Constraints, EnergyLimiter};
use crate::matching::Purpose;
use crate::parallel::{CHUNK, Executor};
use crate::state::Interval;

/// Inputs of a step that all bodies share.
pub(crate) struct StepContext<'a> {
    /// Gravity in scene units per second squared.
    pub(crate) gravity: Vector3<f64>,
    pub(crate) interval: Interval,
    /// Whether this is the first step of a frame.
    pub(crate) is_frame_start: bool,
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

/// The stages in execution order. [`Body::step`] runs this list, and the plan prints it with the memory of
/// each stage, followed by the two stages of a display.
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
    /// Advances the body by one step: runs the stages that the body has, in the order of [`STEP`].
    pub(crate) fn step(&mut self, context: &StepContext, executor: &Executor) {
        self.update_contact_stage(context.colliders);
        for stage in STEP {
            if self.has(stage) {
                self.run(stage, context, executor);
            }
        }
    }

    /// Returns whether the body has a stage. A missing stage takes no time and no memory.
    pub(super) fn has(&self, stage: Stage) -> bool {
        match stage {
            Stage::BeginConstraints | Stage::Constraints => self.constraints.is_some(),
            Stage::Forces => self.forces.is_some(),
            Stage::RegionDamping => self.region_damping.is_some(),
            Stage::BeginContacts | Stage::Contacts => self.contacts.is_some(),
            Stage::Momentum | Stage::Matching | Stage::Integration => true,
        }
    }

    /// Runs one stage. Each comment gives the module that implements the stage, and its formula.
    fn run(&mut self, stage: Stage, context: &StepContext, executor: &Executor) {
        match stage {
            // dynamics::constraints: pins and handles that become active capture their vertices' positions.
            Stage::BeginConstraints => self.begin_constraints(context),
            // dynamics::forces: v += h f/m.
            Stage::Forces => self.apply_external_forces(context),
            // dynamics::momentum: P = Σ m v and L = Σ m (x - x̄) x v of each free component, in f64.
            Stage::Momentum => self.track_momentum(executor),
            // dynamics::damping: v += d (v̄ - v), v̄ = mean of the rigid velocities of the vertex's regions.
            Stage::RegionDamping => self.damp(context, executor),
            // contact: stores v, which is the velocity before an impact.
            Stage::BeginContacts => self.begin_contacts(),
            // matching: R = rotation of Σ m/n (x - c)(x⁰ - c⁰)ᵀ, g = mean of R (x⁰ - c⁰) + c over regions.
            // dynamics::integration: v += alpha (g - x)/h + h a.
            Stage::Matching => self.match_shapes(context, executor),
            // dynamics::integration: x += h v, with v corrected to P and L.
            Stage::Integration => self.integrate(context, executor),
            // contact: v += J/m, x += h J/m, with impulses J where the visible surface touches a collider.
            Stage::Contacts => self.resolve_contacts(context),
            // dynamics::constraints: x and v = target position and velocity of the pin or handle.
            Stage::Constraints => self.apply_constraints(context),
        }
    }

    /// Returns whether the body is a single task, so that a step runs on one thread.
    pub(crate) fn is_one_task(&self) -> bool {
        self.matching.layout.blocks() <= CHUNK
    }

    /// Returns whether no active constraint and no contact stage acts on the body.
    fn is_free(&self) -> bool {
        self.contacts.is_none() && !self.constraints.as_ref().is_some_and(Constraints::any_active)
    }

    fn begin_constraints(&mut self, context: &StepContext) {
        let Self { constraints: Some(constraints), matching, state, .. } = self else { return };
        if constraints.begin(context.interval, &state.shared(), matching.layout.slots()) {
            self.track_constraints();
        }
    }

    /// Updates which components have constrained vertices: their momenta are not conserved.
    pub(super) fn track_constraints(&mut self) {
        let Self { constraints, matching, momentum, state, .. } = self;
        match constraints {
            Some(constraints) => {
                momentum.set_constrained(matching.layout.slots(), constraints.held(), &mut state.momenta);
            }
            None => momentum.clear_constrained(),
        }
    }

    fn apply_external_forces(&mut self, context: &StepContext) {
        let Self { forces: Some(forces), lattice, matching, material, state, .. } = self else { return };
        let mass = |vertex| super::mass(material, lattice, vertex);
        let step = (context.interval, context.is_frame_start);
        forces.apply(step, (lattice, matching.layout.slots()), mass, state);
        if forces.is_empty() {
            self.forces = None;
        }
    }

    /// Measures unknown momenta, and moves the frame of a free body with the body so that its f32 positions
    /// and velocities stay small.
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
        let (needs_rebase, invalidated) =
            (state.needs_rebase(slots[0]), momentum.any_invalidated(&state.momenta));
        if !needs_rebase && !invalidated {
            return;
        }
        let (bounds, weights) = (matching.cascade.bounds(), &matching.regions.weights);
        momentum.measure(executor, bounds, weights, &state.positions, &state.velocities);
        if needs_rebase {
            state.rebase(slots, momentum.center());
        }
        if invalidated && is_free {
            state.set_origin_velocity(slots, state.frame.velocity() + momentum.velocity());
            momentum.measure(executor, bounds, weights, &state.positions, &state.velocities);
        }
        momentum.store_measured(&mut state.momenta);
    }

    /// v += d (v̄ - v). Region damping runs before shape matching. After it, damping would spread the
    /// acceleration of constrained vertices, whose velocities the constraints override.
    fn damp(&mut self, context: &StepContext, executor: &Executor) {
        let Self { region_damping: Some(region_damping), matching, workspace, material, state, .. } = self
        else {
            return;
        };
        if !state.fitted {
            let fitted = (&state.positions, &mut state.rotations);
            matching.fit(workspace, executor, fitted, None, Purpose::Regions);
        }
        let share = material.region_damping_share(context.interval.dt);
        region_damping.apply(matching, workspace, executor, state, share as f32);
    }

    fn begin_contacts(&mut self) {
        if let Some(contacts) = &mut self.contacts {
            contacts.begin(&self.state.velocities);
        }
    }

    /// v += alpha (g - x)/h + h a. Gravity acts on the frame of a free body, and on the vertices of other
    /// bodies.
    ///
    /// Where the best rotation of a region is nearly ambiguous, the energy limiter acts on a free body. The
    /// region sums are then computed twice.
    fn match_shapes(&mut self, context: &StepContext, executor: &Executor) {
        let is_free = self.is_free();
        let Self { matching, workspace, momentum, energy, material, lattice, state, .. } = self;
        let dt = context.interval.dt;
        let mut gain = context.gravity * (dt / lattice.cell_size());
        if is_free {
            state.frame.advance_origin(gain, dt);
            gain = Vector3::zeros();
        }

        let fitted = (&state.positions, &mut state.rotations);
        let unconverged = matching.fit(workspace, executor, fitted, None, Purpose::Goals);
        self.unconverged += unconverged;
        state.fitted = true;
        let limiter =
            (is_free && unconverged > 0).then(|| energy.get_or_insert_with(|| EnergyLimiter::new(matching)));
        if let Some(limiter) = &limiter {
            let fitted = (&state.positions, &mut state.rotations);
            matching.fit(workspace, executor, fitted, Some(limiter.potential()), Purpose::Goals);
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

    /// x += h v, with the velocities corrected to the tracked momenta.
    fn integrate(&mut self, context: &StepContext, executor: &Executor) {
        let Self { matching, momentum, state, .. } = self;
        let (components, corrections) = momentum.corrections(&state.momenta);
        let occupied = matching.layout.occupied();
        let advance = Advance { occupied, components, corrections, dt: context.interval.dt };
        advance.run(executor, &mut state.positions, &mut state.compensation, &mut state.velocities);
    }

    /// Applies contact impulses. The momenta of touched components become invalid and are measured in the
    /// next step.
    fn resolve_contacts(&mut self, context: &StepContext) {
        let Self { contacts: Some(contacts), lattice, state, .. } = self else { return };
        if context.is_frame_start {
            contacts.clear_displacements();
        }
        contacts.resolve(&mut state.shared(), context.colliders, context.interval, context.gravity.into());
        for vertex in contacts.touched() {
            state.invalidate_momentum(lattice, vertex);
        }
    }

    fn apply_constraints(&mut self, context: &StepContext) {
        if let Some(constraints) = &self.constraints {
            constraints.apply(context.interval, &mut self.state.shared(), self.matching.layout.slots());
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::{Collider, Lattice, Selection, Simulation};

    fn known_momenta(simulation: &Simulation) -> Vec<bool> {
        simulation.body(0).state.momenta.iter().map(Option::is_some).collect()
    }

    #[test]
    fn contacts_and_forces_invalidate_momenta_of_their_components_only() {
        let lattice = Lattice::from_cells(&[[0, 0, 0], [4, 0, 0], [8, 0, 0]], 1.0, Point3::origin(), false);
        let mut body = Body::from_lattice(lattice.unwrap()).build().unwrap();
        body.apply_forces(&[(2, [1.0, 0.0, 0.0])]).unwrap();
        let ball = Collider::sphere([8.5, -1.0, 0.5], 1.5);
        let mut simulation =
            Simulation::builder().body(body).collider(ball).gravity([0.0; 3]).build().unwrap();
        simulation.step();
        assert_eq!(known_momenta(&simulation), [true, true, false]);
        let body = simulation.body_mut(0);
        body.apply_force([1.0; 3], &Selection::Vertices(vec![2])).unwrap();
        let (gravity, interval) = (Vector3::zeros(), Interval::of_step(1, 1.0));
        let colliders = &Colliders::new(&[]).unwrap();
        body.apply_external_forces(&StepContext { gravity, interval, is_frame_start: true, colliders });
        assert_eq!(known_momenta(&simulation), [true, false, false]);
    }
}
