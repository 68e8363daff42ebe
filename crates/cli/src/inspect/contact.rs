//! Collects facts about contact between bodies, and of bodies with themselves.

use std::collections::BTreeSet;

use serde::Serialize;
use supple::{Body, BodyPlan, CONTACT_OF_BODIES};
use supple_io::run::{Caution, Overlap, Prepared};
use supple_io::scene::Scene;

/// Facts about contact between bodies.
#[derive(Debug, Serialize)]
pub(super) struct ContactFacts {
    /// Whether bodies touch each other, as the scene sets it.
    pub(super) between_bodies: bool,
    /// Whether bodies touch themselves that do not say so themselves, as the scene sets it.
    pub(super) self_contact: bool,
    /// Pairs of bodies that do not touch each other, by name.
    pub(super) ignored: Vec<[String; 2]>,
    /// Pairs of bodies that overlap at the start.
    pub(super) overlapping: Vec<OverlapFacts>,
}

/// Facts about two bodies that overlap at the start.
#[derive(Debug, Serialize)]
pub(super) struct OverlapFacts {
    pub(super) bodies: [String; 2],
    /// Depth in scene units.
    pub(super) depth: f64,
}

/// Facts about how a body touches other bodies and itself.
#[derive(Debug, Serialize)]
pub(super) struct TouchingFacts {
    pub(super) friction: f64,
    pub(super) restitution: f64,
    /// Distance outside of the surface at which the body touches, in scene units.
    pub(super) thickness: f64,
    /// Whether the body touches itself.
    pub(super) self_contact: bool,
    /// Number of samples of its surface.
    pub(super) samples: usize,
    /// Current memory in bytes.
    pub(super) bytes: usize,
}

/// Collects the facts about contact between bodies.
pub(super) fn contact(scene: &Scene, prepared: &Prepared) -> ContactFacts {
    let pairs = scene.bodies.iter().flat_map(|body| {
        body.touching
            .ignored
            .iter()
            .map(|other| [body.name.clone().min(other.clone()), body.name.clone().max(other.clone())])
    });
    // Each of two bodies may name the other.
    let ignored: BTreeSet<[String; 2]> = pairs.collect();
    let overlap = |caution: &Caution| match caution {
        Caution::Overlap(Overlap { bodies, depth, .. }) => {
            Some(OverlapFacts { bodies: bodies.clone(), depth: *depth })
        }
        _ => None,
    };
    ContactFacts {
        between_bodies: scene.simulation.contact,
        self_contact: scene.simulation.self_contact,
        ignored: ignored.into_iter().collect(),
        overlapping: prepared.cautions.iter().filter_map(overlap).collect(),
    }
}

/// Collects the facts about how a body touches other bodies and itself, or returns `None` if it can touch neither.
pub(super) fn touching(scene: &Scene, body: &Body, plan: &BodyPlan) -> Option<TouchingFacts> {
    let samples = body.contact_samples()?;
    let stage = plan.stages.iter().find(|stage| stage.name == CONTACT_OF_BODIES);
    let touching = body.touching();
    Some(TouchingFacts {
        friction: touching.friction,
        restitution: touching.restitution,
        thickness: touching.thickness,
        self_contact: touching.self_contact.unwrap_or(scene.simulation.self_contact),
        samples,
        bytes: stage.map_or(0, |stage| stage.bytes),
    })
}
