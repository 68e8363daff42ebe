//! The advance of the positions.

use super::stage::{BodyStep, Stage};
use crate::body::context::StepContext;
use crate::body::parts::Pipeline;
use crate::body::soft_body::Body;
use crate::dynamics::Advance;
use crate::parallel::Executor;

/// Advances the positions, after the velocities are corrected such that the momenta are the tracked ones.
pub(super) struct Integrate;

impl Stage for Integrate {
    fn name(&self) -> &'static str {
        "integration"
    }

    fn exists(&self, body: &Body) -> bool {
        !body.is_rigid()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        body.integrate(step.context, step.executor);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        (format!("{} lattice vertices, f32", body.shape.lattice.len()), 0)
    }
}

impl Body {
    /// Corrects the velocities such that the momenta of free components are the tracked ones, then advances
    /// the positions: x += h v.
    fn integrate(&mut self, context: &StepContext, executor: &Executor) {
        let Self { pipeline: Pipeline { matching, momentum, .. }, state, .. } = self;
        let (components, corrections) = momentum.corrections(&state.momenta);
        let occupied = matching.layout.occupied();
        let advance = Advance { occupied, components, corrections, dt: context.interval.dt };
        advance.run(executor, &mut state.positions, &mut state.compensation, &mut state.velocities);
    }
}
