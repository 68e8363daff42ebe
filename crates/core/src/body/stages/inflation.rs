//! The ratios of the rest volumes.

use super::stage::{BodyStep, Stage, check_owner};
use crate::body::snapshot::BodySnapshot;
use crate::body::soft_body::Body;
use crate::body::transfer::Parents;
use crate::dynamics::Inflation;
use crate::error::StateError;

/// Updates the ratios of the rest volumes of the regions to the end of the step.
pub(super) struct UpdateInflation;

impl Stage for UpdateInflation {
    fn name(&self) -> &'static str {
        "inflation"
    }

    fn exists(&self, body: &Body) -> bool {
        body.inflation.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        body.update_inflation(step.context.interval);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        ("ratios of rest volumes".to_owned(), body.inflation.as_ref().map_or(0, Inflation::bytes))
    }

    fn rebuild(&self, body: &mut Body) {
        body.pass_inflation();
    }

    fn follow(&self, body: &mut Body, parents: &Parents) {
        if let Some(inflation) = &mut body.inflation {
            inflation.transfer(&parents.first);
        }
    }

    fn save(&self, body: &Body, snapshot: &mut BodySnapshot) {
        snapshot.inflation = body.inflation.clone();
    }

    fn check(&self, body: &Body, snapshot: &BodySnapshot, vertices: usize) -> Result<(), StateError> {
        let fits = snapshot.inflation.as_ref().is_none_or(|inflation| inflation.is_valid(vertices));
        check_owner(body, "inflation", fits)
    }

    fn restore(&self, body: &mut Body, snapshot: &BodySnapshot) {
        body.inflation = snapshot.inflation.clone();
        body.update_shapes();
        body.pass_inflation();
    }
}
