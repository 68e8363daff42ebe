//! Runs the stages of a step. [`STEP`] lists the stages. `Body::run` gives their formulas and modules.
//!
//! | symbol | meaning |
//! |---|---|
//! | h, a | length of the step, gravity |
//! | x, v, m, f | position, velocity and mass of a vertex, and the external force on it |
//! | n | number of regions that contain the vertex |
//! | v̄ | mean of the rigid velocities of these n regions at the vertex |
//! | g | goal position of the vertex |
//! | c, R | center of mass of a region, and the rotation of the region from the rest pose |
//! | x̄, P, L | center of mass, linear momentum and angular momentum of a connected component |
//! | r, c | reference motion of a component (`dynamics::elastic_damping`), and decay rate of its modes |
//! | J | impulse of a contact on a vertex |
//! | alpha, d | stiffness and region damping per step |
//! | superscript 0 | value in the rest pose, such as x⁰ |
//! | × | cross product |
//!
//! A *free component* is a connected component of the lattice without a constrained vertex. Its momenta are
//! tracked. A *free body* has no active constraint and no contact stage. The origin of its frame, from which
//! the f32 positions and velocities are measured, moves with the body. The crate page has the citations.

use nalgebra::Vector3;

use super::context::{BodyContactPart, StepContext};
use super::soft_body::Body;
use crate::dynamics::{Accelerate, Advance, Constraints, EnergyLimiter, RegionDamper};
use crate::matching::{Purpose, Shapes, Workspaces};
use crate::parallel::{CHUNK, Executor};

/// A stage of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    BeginConstraints,
    Forces,
    Inflation,
    Momentum,
    RegionDamping,
    ElasticDamping,
    BeginContacts,
    Matching,
    Fracture,
    Integration,
    Contacts,
    Constraints,
}

/// The stages in execution order. A step runs this list. The plan prints the list with the memory of each stage, followed by
/// the volume correction and the mesh update of the displayed surface.
pub(super) const STEP: [Stage; 12] = [
    Stage::BeginConstraints,
    Stage::Inflation,
    Stage::Momentum,
    Stage::RegionDamping,
    Stage::ElasticDamping,
    Stage::BeginContacts,
    Stage::Matching,
    Stage::Fracture,
    Stage::Integration,
    Stage::Forces,
    Stage::Contacts,
    Stage::Constraints,
];

/// Index in [`STEP`] of the first stage after the damping, whose reference motions bodies that press on each other have
/// in common.
const FIRST_STAGE_AFTER_DAMPING: usize = 5;

/// Index in [`STEP`] of the stage in which bodies touch each other.
const FIRST_CONTACT_STAGE: usize = 10;

const _: () = assert!(matches!(
    (STEP[FIRST_STAGE_AFTER_DAMPING], STEP[FIRST_CONTACT_STAGE]),
    (Stage::BeginContacts, Stage::Contacts)
));

impl Body {
    /// Begins a step: runs the existing stages of the body up to the damping, in the order of [`STEP`], unless it
    /// sleeps.
    pub(crate) fn begin_step(&mut self, context: &StepContext, executor: &Executor) {
        self.update_contact_stage(context.colliders);
        self.complete_elasticity(context.gravity.norm(), context.interval.dt);
        self.wake_to_inflate(context.interval);
        if !self.is_asleep() {
            self.run_all(&STEP[..FIRST_STAGE_AFTER_DAMPING], context, executor);
        } else if let Some(forces) = &mut self.forces {
            forces.discard();
        }
    }

    /// Continues a step: runs the existing stages up to the contacts, unless the body sleeps.
    pub(crate) fn advance_step(&mut self, context: &StepContext, executor: &Executor) {
        if !self.is_asleep() {
            self.run_all(&STEP[FIRST_STAGE_AFTER_DAMPING..FIRST_CONTACT_STAGE], context, executor);
            self.measure_contact_bounds();
        }
    }

    /// Finishes a step: runs the existing stages of the body from the contacts on, unless it sleeps.
    pub(crate) fn finish_step(&mut self, context: &StepContext, part: &BodyContactPart, executor: &Executor) {
        match part {
            BodyContactPart::InIsland { contacts, island, member, index } => {
                self.apply_island(context, (island, *member, *index), contacts, executor);
                self.finish_contacts(context);
                self.apply_constraints(context);
            }
            _ if self.is_asleep() => {
                if let Some(contacts) = &mut self.contacts {
                    contacts.restore_pressures();
                }
                return;
            }
            BodyContactPart::Alone => self.run_all(&STEP[FIRST_CONTACT_STAGE..], context, executor),
            BodyContactPart::Near => {
                self.finish_alone(context);
                self.finish_contacts(context);
                self.apply_constraints(context);
            }
        }
        if !matches!(part, BodyContactPart::InIsland { .. }) {
            self.keep_contact_forces(context.interval.dt);
        }
        self.track_rest(context, executor);
    }

    /// Runs those of some stages that exist.
    fn run_all(&mut self, stages: &[Stage], context: &StepContext, executor: &Executor) {
        for &stage in stages {
            if self.has(stage) {
                self.run(stage, context, executor);
            }
        }
    }

    /// Returns whether a stage of the body exists. A missing stage takes no time and no memory.
    pub(super) fn has(&self, stage: Stage) -> bool {
        match stage {
            Stage::BeginConstraints | Stage::Constraints => self.constraints.is_some(),
            Stage::Forces => self.forces.is_some(),
            Stage::Inflation => self.inflation.is_some(),
            Stage::RegionDamping => self.region_damping.is_some(),
            Stage::ElasticDamping => self.elastic_damping.is_some(),
            Stage::BeginContacts => self.contacts.is_some() || self.body_contact.is_some(),
            Stage::Contacts => self.contacts.is_some(),
            Stage::Fracture => self.is_armed(),
            Stage::Momentum | Stage::Matching | Stage::Integration => true,
        }
    }

    /// Runs one stage. Each comment gives the module that implements the stage, and its formula.
    fn run(&mut self, stage: Stage, context: &StepContext, executor: &Executor) {
        match stage {
            // dynamics::constraints: pins and handles that become active capture the positions of their
            // vertices. dynamics::follow: targets of handles that follow an animated mesh.
            Stage::BeginConstraints => self.begin_constraints(context, executor),
            // dynamics::forces: v += h f/m and x += h² f/m. After the damping, so that a steady force acts whole.
            Stage::Forces => self.apply_external_forces(context),
            // dynamics::inflation: s, the ratios of the rest volumes of the regions, at the end of the step.
            Stage::Inflation => self.update_inflation(context.interval),
            // dynamics::momentum: P = Σ m v and L = Σ m (x - x̄) × v, in f64, of each free component whose
            // momenta are not known.
            Stage::Momentum => self.track_momentum(executor),
            // dynamics::damping: v += d (v̄ - v).
            Stage::RegionDamping => self.damp(context, executor),
            // dynamics::elastic_damping: r, the reference motion of each component. Before the acceleration, v becomes
            // r + exp(-2 c h) (v - r).
            Stage::ElasticDamping => self.begin_elastic_damping(context, executor),
            // body::escape: finds the components inside colliders. contact: stores v as the velocity before the
            // impacts of this step.
            Stage::BeginContacts => self.begin_contacts(context),
            // matching: R = rotation of Σ m/n (x - c)(x⁰ - c⁰)ᵀ; g = mean of R (x⁰ - c⁰) + c over the regions
            // that contain the vertex. matching::plastic: with plasticity, S (x⁰ - c⁰) takes the place of x⁰ - c⁰, and
            // then the plastic shapes S flow. dynamics::integration: v += alpha (g - x)/h + h a.
            // dynamics::recovery: a tangled body follows its rest shape as a whole.
            Stage::Matching => {
                let unconverged = self.match_shapes(context, executor);
                self.recover(context, unconverged);
            }
            // fracture: strains of the joints by the deformation gradients F = A C⁻¹ of the regions, which the matching
            // measured. The joints that exceed their limits break at the end of the step.
            Stage::Fracture => self.find_breaking(context, executor),
            // dynamics::integration: x += h v, after v is corrected such that the momenta are P and L.
            Stage::Integration => self.integrate(context, executor),
            // body::escape: components inside colliders are translated. contact: v += J/m and x += h J/m where
            // surface samples touch a collider. Samples that are then more than 0.01 cells inside a collider are pushed out by
            // a change of x alone.
            Stage::Contacts => self.resolve_contacts(context),
            // dynamics::constraints: x and v become the target position and velocity of the pin or handle.
            Stage::Constraints => self.apply_constraints(context),
        }
    }

    /// Returns whether the blocks of eight lattice vertices fit into one chunk. A step then runs on one
    /// thread.
    pub(crate) fn is_one_task(&self) -> bool {
        self.matching.layout.blocks() <= CHUNK
    }

    /// Allocates the missing buffers of the workspaces of `threads` threads, for those of some bodies that are a single
    /// task.
    pub(crate) fn reserve_workspaces(workspaces: &mut Workspaces, bodies: &[Self], threads: usize) {
        let small = bodies.iter().filter(|body| body.is_one_task());
        workspaces.reserve(threads, small.map(|body| body.matching.cascade.sizes()));
    }

    /// Returns whether the body is free: it has no active constraint and no contact stage.
    fn is_free(&self) -> bool {
        self.contacts.is_none() && !self.constraints.as_ref().is_some_and(Constraints::any_active)
    }

    /// Activates and deactivates pins and handles according to their time windows.
    fn begin_constraints(&mut self, context: &StepContext, executor: &Executor) {
        let Self { constraints: Some(constraints), matching, state, .. } = self else { return };
        let state_slots = (&state.body_state(), matching.layout.slots());
        if constraints.begin(context.interval, state_slots, executor) {
            self.track_constraints();
        }
    }

    /// Updates which components have constrained vertices. The momenta of such components are not conserved.
    pub(super) fn track_constraints(&mut self) {
        let Self { constraints, matching, momentum, state, .. } = self;
        match constraints {
            Some(constraints) => {
                momentum.set_constrained(
                    matching.layout.slots(),
                    constraints.constrained(),
                    &mut state.momenta,
                );
            }
            None => momentum.clear_constrained(),
        }
        self.update_fit_masses();
    }

    /// Gives the constrained vertices more mass in the fits of the regions: see `Regions::hold_factors`.
    ///
    /// The rigid motion of a region that a constraint holds at one side would otherwise be that of its larger free
    /// side, although nothing moves the held side. A bar of the length L that hangs from one layer of vertices would
    /// slip out of its hold by about 2 g L h²/(alpha s²) cells, with the step length h and the cell size s. Only the
    /// fits use these masses, so that momenta and forces are those of the masses of the vertices.
    fn update_fit_masses(&mut self) {
        let Self { constraints, masses, matching, momentum, region_damping, .. } = self;
        let constrained = constraints.as_ref().map_or(&[][..], |constraints| constraints.constrained());
        let factors = matching.regions.hold_factors(&matching.layout, constrained);
        let fit_masses: Vec<f32> = masses.iter().zip(factors).map(|(mass, factor)| mass * factor).collect();
        let slots = matching.layout.slots().iter();
        if slots.zip(&fit_masses).all(|(&slot, &mass)| matching.regions.weights.get(slot)[0] == mass) {
            return;
        }
        matching.set_masses(&fit_masses);
        momentum.set_masses(matching.layout.slots(), &fit_masses);
        if let Some(damper) = region_damping {
            *damper = RegionDamper::new(matching);
        }
    }

    /// Applies external forces: v += h f/m and x += h² f/m. Removes the stage when it has no more data.
    fn apply_external_forces(&mut self, context: &StepContext) {
        let cell_mass = self.cell_mass();
        let Self { forces: Some(forces), lattice, masses, matching, state, .. } = self else { return };
        let mass = |vertex: u32| cell_mass * f64::from(masses[vertex as usize]);
        let timing = (context.interval, context.is_frame_start);
        forces.apply(timing, (lattice, matching.layout.slots()), mass, state);
        if forces.is_empty() {
            self.forces = None;
        }
    }

    /// Measures the momenta of free components where they are invalidated, and keeps the f32 positions and
    /// velocities small.
    ///
    /// If the positions of any body have become large, the body is rebased: its origin moves near its center
    /// of mass. If momenta of a free body are invalidated, the velocity of its origin is set to the velocity
    /// of its center of mass. The origin of a body that is not free has velocity zero.
    fn track_momentum(&mut self, executor: &Executor) {
        let is_free = self.is_free();
        let Self { matching, momentum, state, .. } = self;
        let slots = matching.layout.slots();
        if !is_free {
            state.set_origin_velocity(slots, Vector3::zeros());
        }
        // Constraints, contacts, forces and assigned positions or velocities change the energy.
        if !is_free || state.momenta.contains(&None) {
            state.energy_limit = None;
        }
        let (task_blocks, weights) = (matching.cascade.task_blocks(), &matching.regions.weights);
        let (needs_rebase, invalidated) =
            (state.needs_rebase(slots[0], weights), momentum.any_invalidated(&state.momenta));
        if !needs_rebase && !invalidated {
            return;
        }
        momentum.measure(executor, task_blocks, weights, &state.positions, &state.velocities);
        if needs_rebase {
            state.rebase(slots, momentum.center());
        }
        if invalidated && is_free {
            state.set_origin_velocity(slots, state.frame.velocity() + momentum.velocity());
            momentum.measure(executor, task_blocks, weights, &state.positions, &state.velocities);
        }
        momentum.store_measured(&mut state.momenta);
    }

    /// Damps the velocities: v += d (v̄ - v).
    ///
    /// Region damping runs before shape matching. If it ran afterwards, it would spread the accelerations of
    /// constrained vertices to other vertices, although the constraints override the velocities of
    /// constrained vertices.
    fn damp(&mut self, context: &StepContext, executor: &Executor) {
        let mut shared = self.is_one_task().then(|| context.workspaces.lock(executor));
        let Self { region_damping: Some(region_damping), matching, workspace, material, state, .. } = self
        else {
            return;
        };
        let workspace = shared.as_deref_mut().unwrap_or(workspace);
        if !state.fitted {
            let fitted = (&state.positions, &mut state.rotations, Shapes::of(state.strains.as_ref()));
            matching.fit(workspace, executor, fitted, None, Purpose::Regions);
        }
        let fraction = material.region_damping_fraction(context.interval.dt) as f32;
        let shapes_velocities = (&state.rotations, state.strains.as_ref(), &mut state.velocities);
        let shares = matching.regions.shares();
        region_damping.apply(matching, workspace, executor, shapes_velocities, (fraction, shares));
    }

    /// Measures the motion before the step, and computes the reference motions of the damping.
    fn begin_elastic_damping(&mut self, context: &StepContext, executor: &Executor) {
        let dt = context.interval.dt;
        let keep = self.kept_fraction(dt, executor);
        let (size, rolling) = (self.size / self.lattice.cell_size(), self.rolling_resistance());
        let Self { elastic_damping: Some(damping), constraints, matching, momentum, state, .. } = self else {
            return;
        };
        let (task_blocks, weights) = (matching.cascade.task_blocks(), &matching.regions.weights);
        momentum.measure(executor, task_blocks, weights, &state.positions, &state.velocities);
        damping.begin(
            constraints.as_ref(),
            (state, matching.layout.slots()),
            momentum,
            (keep, size, rolling, dt),
        );
    }

    /// Stores the velocities before the impacts of this step.
    pub(super) fn begin_contacts(&mut self, context: &StepContext) {
        self.begin_body_contact();
        self.begin_escapes(context);
        if let Some(contacts) = &mut self.contacts {
            contacts.begin(&self.state.velocities);
        }
    }

    /// Accelerates the vertices towards their goal positions: v += alpha (g - x)/h + h a.
    ///
    /// Gravity changes the velocity of the frame of a free body. For a body that is not free, gravity changes
    /// the velocities of the vertices.
    ///
    /// If Newton's method did not converge for a region of a free body, the energy limiter is applied and the
    /// fit runs a second time, to sum the elastic potential. This happens only where the optimal rotation of
    /// the region is nearly not unique. Returns the number of such regions.
    fn match_shapes(&mut self, context: &StepContext, executor: &Executor) -> usize {
        let is_free = self.is_free();
        let dt = context.interval.dt;
        let alpha = self.alpha(dt);
        let mut shared = self.is_one_task().then(|| context.workspaces.lock(executor));
        let stiffness = self.is_armed().then(|| (self.modulus_in_force(dt), self.greatest_factor()));
        let Self {
            matching,
            workspace,
            momentum,
            energy,
            elastic_damping,
            lattice,
            material,
            state,
            breaking,
            ..
        } = self;
        let workspace = shared.as_deref_mut().unwrap_or(workspace);
        if let Some(damping) = elastic_damping {
            damping.finish(state, momentum);
        }
        let mut velocity_change = context.gravity * (dt / lattice.cell_size());
        if is_free {
            state.frame.advance_origin(velocity_change, dt);
            velocity_change = Vector3::zeros();
        }

        let shapes = match (&mut state.strains, &material.plastic) {
            (Some(strains), Some(plastic)) => Shapes::Flowing(strains, plastic.flow(dt)),
            _ => Shapes::Rest,
        };
        let fitted = (&state.positions, &mut state.rotations, shapes);
        let gradients = breaking.as_mut().zip(stiffness).and_then(|(breaking, stiffness)| {
            breaking.expect_gradients(material.plastic.is_some());
            breaking.fracture.gradients(stiffness, breaking.has_gradients)
        });
        let unconverged = match gradients {
            Some(gradients) => matching.fit_and_measure(workspace, executor, fitted, gradients),
            None => matching.fit(workspace, executor, fitted, None, Purpose::Vertices),
        };
        self.unconverged += unconverged;
        state.fitted = true;
        let limiter =
            (is_free && unconverged > 0).then(|| energy.get_or_insert_with(|| EnergyLimiter::new(matching)));
        if let Some(limiter) = &limiter {
            let fitted = (&state.positions, &mut state.rotations, Shapes::of(state.strains.as_ref()));
            let potential = Some(limiter.potential());
            matching.fit(workspace, executor, fitted, potential, Purpose::Vertices);
        }
        let limiter = limiter.map(|limiter| {
            limiter.begin(&state.velocities);
            &*limiter
        });

        let stiffness_rate = alpha / dt;
        let sums_momenta = momentum.any_free();
        let (weights, factors) = (&matching.regions.weights, matching.regions.factors());
        let (components, sums) = momentum.begin_sums();
        let update = Accelerate {
            weights,
            factors,
            positions: &state.positions,
            stiffness_rate: stiffness_rate as f32,
            velocity_change: velocity_change.map(|v| v as f32).into(),
            damping: elastic_damping
                .as_ref()
                .map(|damping| (damping.damped(), components, matching.layout.occupied())),
            components: sums_momenta.then_some(components),
        };
        let (layout, velocities) = (&matching.layout, state.velocities.blocks_mut());
        matching.cascade.adjoint(layout, executor, workspace, &update, velocities, sums);
        momentum.finish_sums();

        if let Some(limiter) = limiter {
            limiter.apply((stiffness_rate, dt), &matching.regions, state, momentum);
        }
        momentum.add_impulse(&mut state.momenta, velocity_change);
        unconverged
    }

    /// Corrects the velocities such that the momenta of free components are the tracked ones, then advances
    /// the positions: x += h v.
    fn integrate(&mut self, context: &StepContext, executor: &Executor) {
        let Self { matching, momentum, state, .. } = self;
        let (components, corrections) = momentum.corrections(&state.momenta);
        let occupied = matching.layout.occupied();
        let advance = Advance { occupied, components, corrections, dt: context.interval.dt };
        advance.run(executor, &mut state.positions, &mut state.compensation, &mut state.velocities);
    }

    /// Applies contact impulses and pushes samples out of colliders.
    fn resolve_contacts(&mut self, context: &StepContext) {
        self.detect_contacts(context);
        self.finish_alone(context);
        self.finish_contacts(context);
    }

    /// Applies the impulses of contacts with colliders alone, beginning with those of the step before.
    fn finish_alone(&mut self, context: &StepContext) {
        let unit = self.impulse_unit() / context.interval.dt;
        let Self { contacts: Some(contacts), state, .. } = self else { return };
        contacts.begin_with(|key| state.touches.force(key) / unit);
        contacts.finish_alone(&mut state.body_state(), context.colliders, context.interval);
    }

    /// Stores the forces of the contacts with colliders after a step of `dt` seconds in which no body was touched.
    fn keep_contact_forces(&mut self, dt: f64) {
        let unit = self.impulse_unit() / dt;
        if self.body_contact.is_some() {
            self.state.touches.clear();
        }
        let pressures = self.contacts.iter().flat_map(|contacts| contacts.pressures());
        self.state.touches.set_forces(pressures.map(|pressure| pressure.force(unit)));
    }

    /// Returns the unit of the impulses of contacts with colliders, in scene units.
    pub(super) fn impulse_unit(&self) -> f64 {
        self.cell_mass() * self.lattice.cell_size()
    }

    /// Moves components out of colliders in which they began, and finds the contacts with colliders.
    pub(super) fn detect_contacts(&mut self, context: &StepContext) {
        self.move_out();
        let is_asleep = self.is_asleep();
        let Self { contacts: Some(contacts), state, .. } = self else { return };
        if context.is_frame_start && !is_asleep {
            contacts.clear_displacements();
        }
        let (colliders, interval) = (context.colliders, context.interval);
        contacts.detect(&state.body_state(), colliders, interval, context.gravity.into());
    }

    /// Invalidates the momenta of the components that touched colliders, which the next step measures, and stores what
    /// supports the body.
    fn finish_contacts(&mut self, context: &StepContext) {
        let Self { contacts: Some(contacts), lattice, state, .. } = self else { return };
        for vertex in contacts.touched() {
            state.invalidate_momentum(lattice, vertex);
        }
        if self.elastic_damping.is_some() || context.sleep {
            state.supports.set(contacts.pressures().iter().filter(|pressure| pressure.impulse > 0.0).map(
                |pressure| {
                    let component = lattice.components().of_vertex[pressure.vertex as usize];
                    pressure.support_of(component)
                },
            ));
        }
    }

    /// Moves constrained vertices to the targets of their pins and handles.
    pub(super) fn apply_constraints(&mut self, context: &StepContext) {
        if let Some(constraints) = &self.constraints {
            constraints.apply(context.interval, &mut self.state.body_state(), self.matching.layout.slots());
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::contact::Colliders;
    use crate::state::Interval;
    use crate::{Collider, Lattice, Material, Selection, Simulation};

    fn known_momenta(simulation: &Simulation) -> Vec<bool> {
        simulation.body(0).state.momenta.iter().map(Option::is_some).collect()
    }

    #[test]
    fn contacts_and_forces_invalidate_momenta_of_their_components_only() {
        let lattice = Lattice::from_cells(&[[0, 0, 0], [4, 0, 0], [8, 0, 0]], 1.0, Point3::origin(), false);
        let mut body = Body::from_lattice(lattice.unwrap()).material(Material::fast_lsm()).build().unwrap();
        body.apply_forces(&[(2, [1.0, 0.0, 0.0])]).unwrap();
        let ball = Collider::sphere([8.5, -1.0, 0.5], 1.5);
        let mut simulation =
            Simulation::builder().body(body).collider(ball).gravity([0.0; 3]).build().unwrap();
        simulation.step();
        assert_eq!(known_momenta(&simulation), [true, false, false]);
        simulation.step();
        assert_eq!(known_momenta(&simulation), [true, true, false]);
        let body = simulation.body_mut(0);
        body.apply_force([1.0; 3], &Selection::Vertices(vec![2])).unwrap();
        let (gravity, interval) = (Vector3::zeros(), Interval::of_step(1, 1.0));
        let colliders = &Colliders::new(&[]).unwrap();
        let workspaces = &Workspaces::default();
        let context =
            StepContext { gravity, interval, is_frame_start: true, colliders, sleep: false, workspaces };
        body.apply_external_forces(&context);
        assert_eq!(known_momenta(&simulation), [true, false, false]);
    }
}
