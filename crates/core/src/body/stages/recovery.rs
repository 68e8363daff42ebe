//! The return of a tangled body to its rest shape.

use super::stage::{BodyStep, Stage};
use crate::body::parts::Pipeline;
use crate::body::soft_body::Body;
use crate::dynamics::{Constraints, is_tangled, most_steps, recover};

/// Sets the velocities of a tangled body, which follows its rest shape as a whole.
///
/// The stage acts on a body in one piece whose regions are cells or that has a Poisson's ratio, if nothing touches or holds it.
/// Wide regions without a volume term return without it. A body is examined in steps in which Newton's method fails to
/// converge for a rotation: from a tangled start it does so at once.
pub(super) struct Recover;

impl Stage for Recover {
    fn name(&self) -> &'static str {
        "recovery"
    }

    fn is_main(&self) -> bool {
        false
    }

    fn exists(&self, body: &Body) -> bool {
        body.state.recovery_steps > 0 || body.pipeline.unconverged_in_step > 0
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        if body.constraints.as_ref().is_some_and(Constraints::any_active) {
            body.state.recovery_steps = 0;
            return;
        }
        let dt = step.context.interval.dt;
        let alpha = body.alpha(dt);
        let can_start = body.can_recover() && !body.state.touches.has_forces();
        let Body { pipeline: Pipeline { matching, momentum, .. }, shape, state, .. } = body;
        let (lattice, extent, slots) = (&shape.lattice, shape.extent, matching.layout.slots());
        if state.recovery_steps == 0 && can_start && is_tangled(lattice, &matching.layout, extent, state) {
            state.recovery_steps = most_steps(extent, alpha);
        }
        if state.recovery_steps > 0 {
            let (weights, measured) = (&matching.regions.weights, &momentum.states()[0]);
            let is_near = recover((lattice, slots), weights, measured, state, (alpha, dt));
            state.recovery_steps = if is_near { 0 } else { state.recovery_steps - 1 };
            // The energy that the recovery takes does not come back.
            state.energy_limit = None;
        }
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        (format!("at most {} more steps", body.state.recovery_steps), 0)
    }
}

impl Body {
    /// Returns whether the body is in one piece, and can come to rest tangled.
    fn can_recover(&self) -> bool {
        let can_tangle = self.half_width().is_cell() || self.settings.material.poisson_ratio() > 0.0;
        can_tangle && self.shape.lattice.components().count == 1
    }
}
