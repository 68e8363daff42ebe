//! The numbers of the material that have keyframes.

use super::stage::{BodyStep, Stage, check_owner};
use crate::body::snapshot::BodySnapshot;
use crate::body::soft_body::Body;
use crate::dynamics::KeyedMaterial;
use crate::error::StateError;
use crate::range::Range;

/// Sets the numbers of the material that have keyframes to those at the end of the step.
pub(super) struct KeyMaterial;

impl Stage for KeyMaterial {
    fn name(&self) -> &'static str {
        "keyed material"
    }

    fn is_main(&self) -> bool {
        false
    }

    fn exists(&self, body: &Body) -> bool {
        body.keyed.is_some()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        body.update_keyed(step.context.interval);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        let names: Vec<_> = body.keyed.iter().flat_map(|keyed| keyed.names()).collect();
        (names.join(", "), size_of::<KeyedMaterial>())
    }

    fn save(&self, body: &Body, snapshot: &mut BodySnapshot) {
        snapshot.keyed = body.keyed.as_deref().cloned();
        snapshot.modulus_share = body.settings.modulus_share;
        let friction = body.keyed.as_ref().and_then(|keyed| keyed.friction.as_ref());
        snapshot.friction = friction.map(|_| body.settings.touching.friction);
    }

    fn check(&self, body: &Body, snapshot: &BodySnapshot, _vertices: usize) -> Result<(), StateError> {
        let share = snapshot.modulus_share;
        let is_valid = snapshot.keyed.as_ref().is_none_or(KeyedMaterial::is_valid);
        let friction = snapshot.friction.is_none_or(|friction| Range::NOT_NEGATIVE.contains(friction));
        check_owner(body, "keyed material", is_valid && friction && share > 0.0 && share <= 1.0)
    }

    fn restore(&self, body: &mut Body, snapshot: &BodySnapshot) {
        body.keyed = snapshot.keyed.clone().map(Box::new);
        body.settings.modulus_share = snapshot.modulus_share;
        if let Some(friction) = snapshot.friction {
            body.settings.touching.friction = friction;
        }
    }
}
