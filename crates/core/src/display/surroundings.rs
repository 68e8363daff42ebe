//! The colliders around a displayed body.

use crate::body::{Body, BodyRef, DisplayContext, NearBodies};
use crate::contact::{Colliders, Contacts, SampleCells};
use crate::volume::Obstacles;

/// Colliders around a body, and the samples of its surface.
pub(super) struct Surroundings<'a> {
    pub(super) obstacles: Obstacles<'a>,
    samples: Option<&'a SampleCells>,
    /// Samples of a body that has not yet been stepped in this simulation and has no contact stage.
    new_samples: Option<SampleCells>,
}

impl<'a> Surroundings<'a> {
    pub(super) fn new(body: &'a Body, colliders: &'a Colliders, time: f64) -> Self {
        let is_missing = body.contacts().is_none() && !colliders.is_empty();
        Self {
            obstacles: Obstacles { colliders, time, frame: body.frame() },
            samples: body.contacts().map(Contacts::samples),
            new_samples: is_missing.then(|| body.create_samples(1.0)),
        }
    }

    /// Returns the samples; `None` if there is no collider.
    pub(super) fn samples(&self) -> Option<&SampleCells> {
        self.samples.or(self.new_samples.as_ref())
    }
}

/// Returns the colliders around a body; `None` if there is neither a collider nor a body near it.
pub(super) fn surroundings(body: BodyRef<'_>) -> Option<Surroundings<'_>> {
    let DisplayContext { colliders, time, near, .. } = body.context()?;
    let is_free = colliders.is_empty() && !near.is_some_and(NearBodies::is_any);
    (!is_free).then(|| Surroundings::new(body.get(), colliders, time))
}
