//! Shape matching: goal positions, and the acceleration towards them.

use nalgebra::Vector3;

use super::stage::{BodyStep, Stage};
use crate::body::context::StepContext;
use crate::body::parts::{Pipeline, Settings, Shape};
use crate::body::soft_body::Body;
use crate::body::transfer::Parents;
use crate::dynamics::{Accelerate, ElasticDamper, EnergyLimiter};
use crate::matching::{Purpose, RegionFit, Shapes, Workspace, Workspaces};
use crate::parallel::{self, Executor};
use crate::state::State;

/// Accelerates the vertices towards their goal positions.
pub(super) struct MatchShapes;

impl Stage for MatchShapes {
    fn name(&self) -> &'static str {
        "shape matching"
    }

    fn exists(&self, body: &Body) -> bool {
        !body.is_rigid()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        body.pipeline.unconverged_in_step = body.match_shapes(step.context, step.executor);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        let limiter = body.pipeline.energy.as_ref();
        let plastic = if body.state.strains.is_some() { ", plastic shapes" } else { "" };
        let suffix = if limiter.is_some() { ", energy limiter" } else { "" };
        let (width, blocks) = (body.half_width(), body.pipeline.matching.layout.blocks());
        let bytes = body.pipeline.matching.bytes()
            + body.pipeline.workspace.bytes()
            + limiter.map_or(0, EnergyLimiter::bytes);
        let sums = "window sums along x, y, z, SIMD blocks";
        (format!("half-width {width}, {sums}: {blocks}{plastic}{suffix}"), bytes)
    }

    fn rebuild(&self, body: &mut Body) {
        // Frees the buffers before it allocates others. Small bodies use those of the threads of their simulation.
        body.pipeline.workspace = Workspace::default();
        if !body.is_one_task() {
            body.pipeline.workspace = body.pipeline.matching.cascade.workspace();
        }
        (body.pipeline.energy, body.state.energy_limit) = (None, None);
        body.pass_stiffness_factors();
        body.pass_yield_factors();
    }

    fn follow(&self, body: &mut Body, parents: &Parents) {
        if let Some(factors) = &mut body.stiffness_factors {
            factors.transfer(&parents.first);
        }
    }
}

impl Body {
    /// Returns whether the body is one task. A step then runs on one thread.
    pub(crate) fn is_one_task(&self) -> bool {
        parallel::is_one_task(self.pipeline.matching.layout.blocks())
    }

    /// Allocates the missing buffers of the workspaces of `threads` threads, for the bodies that are a single
    /// task.
    pub(crate) fn reserve_workspaces(workspaces: &mut Workspaces, bodies: &[Self], threads: usize) {
        let small = bodies.iter().filter(|body| body.is_one_task());
        workspaces.reserve(threads, small.map(|body| body.pipeline.matching.cascade.sizes()));
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
        let weakest = self.is_armed().then(|| self.weakest(dt));
        let Self {
            pipeline: Pipeline { matching, workspace, momentum, energy, elastic_damping, .. },
            shape: Shape { lattice, .. },
            settings: Settings { material, .. },
            state,
            breaking,
            ..
        } = self;
        let workspace = shared.as_deref_mut().unwrap_or(workspace);
        let mut velocity_change = context.gravity * (dt / lattice.cell_size());
        if is_free {
            state.frame.advance_origin(velocity_change, dt);
            velocity_change = Vector3::zeros();
        }

        let shapes = match (&mut state.strains, &material.plastic) {
            (Some(strains), Some(plastic)) => Shapes::Flowing(strains, plastic.flow(dt)),
            _ => Shapes::Rest,
        };
        let fitted = RegionFit { positions: &state.positions, rotations: &mut state.rotations, shapes };
        let gradients = breaking.as_mut().zip(weakest).and_then(|(breaking, weakest)| {
            breaking.begin_step(weakest, material.plastic.is_some());
            breaking.fracture.gradients(weakest, breaking.has_gradients)
        });
        let unconverged = match gradients {
            Some(gradients) => matching.fit_and_measure(workspace, executor, fitted, gradients),
            None => matching.fit(workspace, executor, fitted, None, Purpose::Vertices),
        };
        self.pipeline.unconverged += unconverged;
        state.fitted = true;
        let limiter =
            (is_free && unconverged > 0).then(|| energy.get_or_insert_with(|| EnergyLimiter::new(matching)));
        if let Some(limiter) = &limiter {
            let potential = Some(limiter.potential());
            matching.fit(workspace, executor, fitted_state(state), potential, Purpose::Vertices);
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
            shares: elastic_damping.as_ref().and_then(ElasticDamper::shares),
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
}

/// Returns the positions to which the regions are fitted in their present shapes, and the rotations that a fit updates.
pub(super) fn fitted_state(state: &mut State) -> RegionFit<'_> {
    RegionFit {
        positions: &state.positions,
        rotations: &mut state.rotations,
        shapes: Shapes::of(state.strains.as_ref()),
    }
}
