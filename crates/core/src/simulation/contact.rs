//! The part of a step in which bodies touch each other.

use super::world::Simulation;
use crate::body::{Body, BodyContactPart, StepContext};
use crate::contact::bodies::BodyContacts;
use crate::parallel::Executor;
use crate::state::PairSupports;

/// Stores which bodies press on each other. Bodies that sleep keep their supports.
fn store_supports(bodies: &[Body], contacts: &BodyContacts, supports: &mut PairSupports) {
    let is_awake = |side: &(u32, u32)| bodies.get(side.0 as usize).is_none_or(|body| !body.is_asleep());
    let pressing = contacts.contacts().filter_map(|pair| {
        let sides = [0, 1].map(|side| (pair.bodies[side], pair.components[side]));
        let impulse = pair.impulse.dot(&pair.normal);
        (impulse > 0.0 && sides[0] != sides[1]).then_some((sides, impulse, pair.point.coords, pair.normal))
    });
    supports.set(|support| support.sides.iter().any(is_awake), pressing);
}

impl Simulation {
    /// Runs the contacts between bodies, and finishes the step of each body.
    pub(super) fn finish_bodies(
        bodies: &mut [Body],
        (contacts, supports): (&mut BodyContacts, &mut PairSupports),
        context: &StepContext,
        executor: &Executor,
    ) {
        let (dt, count) = (context.interval.dt, bodies.len() as u32);
        let is_asleep = |index: u32| bodies[index as usize].is_asleep();
        let has_pairs = contacts.pair(count, |index| bodies[index as usize].contact_view(), is_asleep, dt);
        if has_pairs {
            executor.for_each_indexed(bodies, |index, body| {
                if contacts.region(index).is_some() {
                    body.prepare_body_contact(context, !contacts.has_partner(index));
                }
            });
            let view = |index: u32| bodies[index as usize].contact_view();
            contacts.choose_searches(view, (dt, context.gravity.norm()));
            for past in contacts.search_times() {
                executor.for_each_indexed(bodies, |index, body| {
                    if let Some(region) = contacts.region_at(index, past) {
                        body.pose_for_contact(past * dt, &region);
                    }
                });
                contacts.search(|index| bodies[index as usize].contact_view(), (past, dt), executor);
            }
            contacts.solve(
                |index| bodies[index as usize].contact_view(),
                (dt, context.gravity.norm()),
                executor,
            );
        }
        let found = &*contacts;
        executor.for_each_indexed(bodies, |index, body| {
            let part = match (found.region(index), found.island_of(index)) {
                (None, _) => BodyContactPart::Alone,
                (Some(_), None) => BodyContactPart::Near,
                (Some(_), Some((island, member))) => {
                    BodyContactPart::InIsland { contacts: found, island, member, index }
                }
            };
            body.finish_step(context, &part, executor);
        });
        store_supports(bodies, contacts, supports);
        contacts.record(|body| bodies[body as usize].is_asleep(), dt);
    }

    /// Returns the pairs of bodies that overlap at the start, before the first step, with the depth of the overlap in
    /// scene units if it is more than 0.1 cells of the smaller cell size. Bodies that do not touch each other
    /// ([`BodyBuilder::ignore`](crate::BodyBuilder::ignore)) are no pairs. Bodies that overlap at first are pushed
    /// apart.
    pub fn overlapping_bodies(&mut self) -> Vec<(usize, usize, f64)> {
        let Self { bodies, contacts, .. } = self;
        let Some(contacts) = contacts else { return Vec::new() };
        bodies.iter_mut().for_each(Body::measure_contact_bounds);
        let count = bodies.len() as u32;
        if !contacts.pair(count, |index| bodies[index as usize].contact_view(), |_| false, 0.0) {
            return Vec::new();
        }
        // On the calling thread, which may hold locks of the caller.
        let executor = Executor::sequential();
        executor.for_each_indexed(bodies, |index, body| {
            if let Some(region) = contacts.region(index) {
                body.create_contact_surface();
                body.pose_for_contact(0.0, &region);
            }
        });
        contacts.search(|index| bodies[index as usize].contact_view(), (0.0, 0.0), &executor);
        contacts.overlaps(|body| bodies[body as usize].lattice().cell_size())
    }
}
