//! The part of the elastic damping that supports take, after the contacts.

use super::stage::{BodyStep, Stage};
use crate::body::parts::Pipeline;
use crate::body::soft_body::Body;
use crate::dynamics::{DampingStep, add_rigid};

/// Measures the motion after the contacts, and computes the motions of the components that meet the conditions of their
/// supports.
pub(super) struct MeetSupports;

impl Stage for MeetSupports {
    fn name(&self) -> &'static str {
        "supported motion"
    }

    fn is_main(&self) -> bool {
        false
    }

    fn exists(&self, body: &Body) -> bool {
        let can_touch = body.contact.contacts.is_some() || body.contact.body_contact.is_some();
        can_touch && body.pipeline.elastic_damping.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        let BodyStep { context, executor, .. } = *step;
        let rates = body.damping_rates(context.interval.dt, executor);
        let size = body.size() / body.shape.lattice.cell_size();
        let layers = body.contact_layers();
        let (own, colliders) = (body.rolling_resistance(), context.colliders);
        let rolling_resistance = &|collider: u32| colliders.rolling_resistance(collider).unwrap_or(own);
        let friction = &|collider: u32| colliders.friction(collider);
        let Body {
            pipeline: Pipeline { elastic_damping: Some(damping), matching, momentum, .. },
            constraints,
            state,
            ..
        } = body
        else {
            return;
        };
        if state.supports.list().is_empty() && state.touches.bodies().is_empty() {
            damping.clear_supports();
            return;
        }
        momentum.measure((matching, state), executor);
        momentum.is_measured = false;
        let step = DampingStep { rates, size, layers, rolling_resistance, friction };
        damping.begin_supports(constraints.as_ref(), (matching, state), momentum, (step, executor));
    }

    fn describe(&self, _body: &Body) -> (String, usize) {
        ("after the contacts".to_owned(), 0)
    }
}

/// Adds the velocities that the supports give.
pub(super) struct DampOnSupports;

impl Stage for DampOnSupports {
    fn name(&self) -> &'static str {
        "damping by supports"
    }

    fn is_main(&self) -> bool {
        false
    }

    fn exists(&self, body: &Body) -> bool {
        MeetSupports.exists(body)
    }

    fn run(&self, body: &mut Body, _step: &BodyStep<'_>) {
        let Body {
            pipeline: Pipeline { elastic_damping: Some(damping), matching, momentum, .. }, state, ..
        } = body
        else {
            return;
        };
        if let Some((added, shares)) = damping.finish_supports(&mut state.momenta, momentum) {
            let lanes = (matching.layout.occupied(), shares);
            add_rigid(momentum.components(), added, lanes, &state.positions, &mut state.velocities);
        }
    }

    fn describe(&self, _body: &Body) -> (String, usize) {
        ("rigid motions of components".to_owned(), 0)
    }
}
