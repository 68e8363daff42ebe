//! What a simulation lends its bodies.

use std::sync::Arc;

use super::Body;
use crate::contact::{Colliders, Contacts};
use crate::parallel::Executor;

/// What those who look at a body must know beside it.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    /// What bodies cannot enter.
    pub(crate) colliders: Arc<Colliders>,
    /// Time in seconds.
    pub(crate) time: f64,
    /// Length of the simulation's steps in seconds; zero before there is one.
    pub(crate) dt: f64,
    /// Its threads.
    pub(crate) executor: Executor,
}

impl Surroundings {
    /// Of a body that belongs to no simulation yet.
    pub(super) fn none() -> Self {
        Self { colliders: Arc::default(), time: 0.0, dt: 0.0, executor: Executor::sequential() }
    }
}

impl Body {
    /// Makes these the surroundings; where there are colliders, contacts are among the stages.
    pub(crate) fn lend(&mut self, surroundings: Surroundings) {
        if surroundings.colliders.is_empty() {
            self.contacts = None;
        } else if self.contacts.is_none() {
            self.contacts = Some(Contacts::new(self.samples()));
        }
        self.surroundings = surroundings;
    }
}
