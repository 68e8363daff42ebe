//! The part of a step in which bodies touch each other.

use super::world::Simulation;
use crate::body::{Body, StepContext};
use crate::contact::bodies::{BodyContacts, ContactStep};
use crate::parallel::Executor;
use crate::state::{PairSupports, PressingContact};

/// Stores which bodies press on each other. Bodies that sleep keep their supports.
pub(super) fn store_supports(bodies: &[Body], contacts: &BodyContacts, supports: &mut PairSupports) {
    let is_awake = |side: &(u32, u32)| bodies.get(side.0 as usize).is_none_or(|body| !body.is_asleep());
    let pressing = contacts.contacts().filter_map(|pair| {
        let (sides, normal, point) = (pair.sides(), pair.normal, pair.point.coords);
        let impulse = pair.pressure();
        let contact = PressingContact {
            impulse,
            friction_factor: pair.friction_factor,
            friction: pair.impulse - normal * impulse,
            point,
            normal,
        };
        (impulse > 0.0 && sides[0] != sides[1]).then_some((sides, contact))
    });
    supports.set(|support| support.sides.iter().any(is_awake), pressing);
}

impl Simulation {
    /// Runs the contacts between bodies, and the stages of the contacts of each body.
    pub(super) fn finish_bodies(
        bodies: &mut [Body],
        contacts: &mut BodyContacts,
        context: &StepContext,
        executor: &Executor,
    ) {
        let step = ContactStep { dt: context.interval.dt, gravity: context.gravity.norm() };
        let prepare = |body: &mut Body, is_alone| body.prepare_body_contact(context, is_alone);
        contacts.resolve(bodies, prepare, step, executor);
        let found = &*contacts;
        executor.for_each_indexed(bodies, |index, body| {
            body.finish_step(context, &found.part_of(index), executor);
        });
    }

    /// Returns the pairs of bodies that overlap at the start, before the first step, with the depth of the overlap in
    /// scene units if it is more than 0.1 cells of the smaller cell size. Bodies that do not touch each other
    /// ([`BodyBuilder::ignore`](crate::BodyBuilder::ignore)) are no pairs. Bodies that overlap at first are pushed
    /// apart.
    pub fn overlapping_bodies(&mut self) -> Vec<(usize, usize, f64)> {
        let Self { bodies, contacts, .. } = self;
        let Some(contacts) = contacts else { return Vec::new() };
        bodies.iter_mut().for_each(Body::measure_contact_bounds);
        contacts.overlaps(bodies, Body::create_contact_surface)
    }
}
