//! Lets a tangled body return to its rest shape: see [`dynamics::recovery`](crate::dynamics).

use super::context::StepContext;
use super::parts::{Pipeline, Shape};
use super::soft_body::Body;
use crate::dynamics::{Constraints, is_tangled, most_steps, recover};

impl Body {
    /// Starts a recovery if the body is tangled, and sets the velocities of a step of a recovery. `unconverged` is
    /// the number of regions for whose rotation Newton's method did not converge in this step; without any, the body
    /// is not tangled.
    ///
    /// Only a body of cells or with a Poisson's ratio recovers, in one piece and if nothing touches or holds it. Wide
    /// regions without a volume term return by themselves.
    pub(super) fn recover(&mut self, context: &StepContext, unconverged: usize) {
        if self.state.recovery_steps == 0 && unconverged == 0 {
            return;
        }
        let dt = context.interval.dt;
        let alpha = self.alpha(dt);
        let can_tangle = self.half_width().is_cell() || self.settings.material.poisson_ratio() > 0.0;
        let can_start = can_tangle && self.is_untouched();
        let Self {
            shape: Shape { lattice, extent, .. },
            pipeline: Pipeline { matching, momentum, .. },
            state,
            ..
        } = self;
        let slots = matching.layout.slots();
        if state.recovery_steps == 0 && can_start && is_tangled(lattice, slots, state) {
            state.recovery_steps = most_steps(*extent, alpha);
        }
        if state.recovery_steps > 0 {
            let (weights, measured) = (&matching.regions.weights, &momentum.states()[0]);
            let is_near = recover((lattice, slots), weights, measured, state, (alpha, dt));
            state.recovery_steps = if is_near { 0 } else { state.recovery_steps - 1 };
            // The energy that the recovery takes does not come back.
            state.energy_limit = None;
        }
    }

    /// Returns whether the body is in one piece, and nothing touched or held it in the last step.
    fn is_untouched(&self) -> bool {
        let Self { shape: Shape { lattice, .. }, constraints, state, .. } = self;
        lattice.components().count == 1
            && !constraints.as_ref().is_some_and(Constraints::any_active)
            && state.supports.list().is_empty()
            && state.touches.bodies().is_empty()
    }
}
