//! Fracture: the joints that break.

use super::stage::{BodyStep, Stage};
use crate::body::soft_body::Body;

/// Finds the joints that break at the end of the step.
pub(super) struct FindBreaking;

impl Stage for FindBreaking {
    fn name(&self) -> &'static str {
        "fracture"
    }

    fn exists(&self, body: &Body) -> bool {
        body.is_armed()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        body.find_breaking(step.context, step.executor);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        let cracks = body.fracture().map_or(0, |options| options.cracks);
        let broken = body.broken_joints();
        (format!("cracks that grow at a time: {cracks}, broken joints: {broken}"), body.breaking_bytes())
    }
}
