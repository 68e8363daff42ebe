//! The momenta of free components.

use nalgebra::Vector3;

use super::stage::{BodyStep, Stage};
use crate::body::parts::Pipeline;
use crate::body::soft_body::Body;
use crate::dynamics::{Constraints, MomentumTracker};

/// Measures the momenta of free components where they are invalidated, and keeps the f32 positions and velocities small.
///
/// If the positions of any body have become large, the body is rebased: its origin moves near its center of mass. If momenta
/// of a free body are invalidated, the velocity of its origin is set to the velocity of its center of mass. The origin of a
/// body that is not free has velocity zero.
pub(super) struct TrackMomentum;

impl Stage for TrackMomentum {
    fn name(&self) -> &'static str {
        "momentum tracker"
    }

    fn exists(&self, body: &Body) -> bool {
        !body.is_rigid()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        let is_free = body.is_free();
        let Body { pipeline: Pipeline { matching, momentum, .. }, state, .. } = body;
        let slots = matching.layout.slots();
        if !is_free {
            state.set_origin_velocity(slots, Vector3::zeros());
        }
        // Constraints, contacts, forces and assigned positions or velocities change the energy.
        if !is_free || state.momenta.contains(&None) {
            state.energy_limit = None;
        }
        let needs_rebase = state.needs_rebase(slots[0], &matching.regions.weights);
        let invalidated = momentum.any_invalidated(&state.momenta);
        momentum.is_measured = false;
        if !needs_rebase && !invalidated {
            return;
        }
        momentum.measure((matching, state), step.executor);
        momentum.is_measured = !needs_rebase;
        if needs_rebase {
            state.rebase(slots, momentum.center());
        }
        if invalidated && is_free {
            state.set_origin_velocity(slots, state.frame.velocity() + momentum.velocity());
            momentum.measure((matching, state), step.executor);
        }
        momentum.store_measured(&mut state.momenta);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        let components = body.state.momenta.len();
        (format!("momenta in f64, connected components: {components}"), body.pipeline.momentum.bytes())
    }

    fn rebuild(&self, body: &mut Body) {
        let (layout, cascade) = (&body.pipeline.matching.layout, &body.pipeline.matching.cascade);
        body.pipeline.momentum =
            MomentumTracker::new(&body.shape.lattice, &body.shape.masses, layout, cascade.tasks());
    }
}

impl Body {
    /// Returns whether the body is free: it has no active constraint and no contact stage.
    pub(super) fn is_free(&self) -> bool {
        self.contact.contacts.is_none() && !self.constraints.as_ref().is_some_and(Constraints::any_active)
    }
}
