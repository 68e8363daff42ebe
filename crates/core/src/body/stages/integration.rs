//! The advance of the positions.

use super::stage::{BodyStep, Stage};
use crate::body::parts::Pipeline;
use crate::body::soft_body::Body;
use crate::dynamics::Advance;

/// Corrects the velocities such that the momenta of free components are the tracked ones, then advances the positions:
/// x += h v.
pub(super) struct Integrate;

impl Stage for Integrate {
    fn name(&self) -> &'static str {
        "integration"
    }

    fn exists(&self, body: &Body) -> bool {
        !body.is_rigid()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        let Body { pipeline: Pipeline { matching, momentum, .. }, state, .. } = body;
        let (components, corrections) = momentum.corrections(&state.momenta);
        let (occupied, dt) = (matching.layout.occupied(), step.context.interval.dt);
        let advance = Advance { occupied, components, corrections, dt };
        advance.run(step.executor, &mut state.positions, &mut state.compensation, &mut state.velocities);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        (format!("{} lattice vertices, f32", body.shape.lattice.len()), 0)
    }
}
