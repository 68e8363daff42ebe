//! The part of a step in which bodies touch each other, and their common rest.

use super::Simulation;
use crate::body::{Body, BodyContactPart, RestVote, StepContext};
use crate::contact::bodies::{BodyContacts, ContactFilter};
use crate::dynamics::Coupling;
use crate::mesh::UnionFind;
use crate::parallel::Executor;
use crate::state::PairSupports;

/// Which bodies can touch each other or themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ContactSettings {
    /// Whether bodies touch each other.
    pub(super) between: bool,
    /// Whether bodies touch themselves that do not say so themselves.
    pub(super) with_itself: bool,
}

/// Creates the contacts between bodies, or returns `None` if no body can touch another one or itself.
pub(super) fn create(bodies: &mut [Body], settings: ContactSettings) -> Option<BodyContacts> {
    let filter = filter(bodies, settings);
    for (index, body) in (0..).zip(&mut *bodies) {
        let with_itself = connected_parts_touch(body, settings);
        body.set_body_contact(
            filter.between || filter.with_itself.binary_search(&index).is_ok(),
            with_itself,
        );
    }
    (filter.between || !filter.with_itself.is_empty()).then(|| BodyContacts::new(filter))
}

/// Updates the contacts between bodies after bodies broke into pieces, which touch each other.
pub(super) fn update(bodies: &mut [Body], settings: ContactSettings, contacts: &mut Option<BodyContacts>) {
    let filter = filter(bodies, settings);
    for (index, body) in (0..).zip(&mut *bodies) {
        body.update_body_contact(filter.between || filter.with_itself.binary_search(&index).is_ok());
    }
    if !filter.between && filter.with_itself.is_empty() {
        *contacts = None;
        return;
    }
    match contacts {
        Some(contacts) => contacts.set_filter(filter),
        None => *contacts = Some(BodyContacts::new(filter)),
    }
}

/// Returns whether connected parts of a body touch each other.
fn connected_parts_touch(body: &Body, settings: ContactSettings) -> bool {
    body.touching().self_contact.unwrap_or(settings.with_itself)
}

/// Returns which bodies touch each other or themselves. The pieces of a body touch each other as bodies do.
fn filter(bodies: &[Body], settings: ContactSettings) -> ContactFilter {
    let between = settings.between && bodies.len() > 1;
    let touches_itself =
        |body: &Body| connected_parts_touch(body, settings) || settings.between && body.is_in_pieces();
    let with_itself: Vec<u32> =
        (0..).zip(bodies).filter(|(_, body)| touches_itself(body)).map(|(index, _)| index).collect();
    let mut ignored = Vec::new();
    for (index, body) in (0..).zip(bodies) {
        for (other, _) in
            (0..).zip(bodies).filter(|(_, b)| body.touching().ignored.iter().any(|n| n == b.name()))
        {
            ignored.push((index.min(other), index.max(other)));
        }
    }
    ignored.sort_unstable();
    ContactFilter { between, with_itself, ignored }
}

/// Buffers for what touching bodies decide and compute together.
#[derive(Debug, Default)]
pub(super) struct Groups {
    sets: UnionFind,
    /// The vote of each group of touching bodies, by its lowest body, and whether something holds or supports the
    /// group.
    votes: Vec<(RestVote, bool)>,
    sides: Vec<(u32, u32)>,
    coupling: Coupling,
}

impl Groups {
    /// Lets bodies fall asleep or wake up at the beginning of a step. Bodies that touch each other do so together.
    pub(super) fn settle(&mut self, bodies: &mut [Body], context: &StepContext) {
        let Self { sets, votes, .. } = self;
        if bodies.iter().all(|body| body.touches().is_empty()) {
            for body in bodies {
                body.follow(body.rest_vote(context));
            }
            return;
        }
        sets.reset(bodies.len());
        for (index, body) in (0..).zip(&*bodies) {
            for &(_, other) in body.touches().iter().filter(|(_, other)| (*other as usize) < bodies.len()) {
                sets.unite(index, other);
            }
        }
        votes.clear();
        votes.resize(bodies.len(), (RestVote::Asleep, false));
        for (index, body) in (0..).zip(&*bodies) {
            let (vote, is_supported) = &mut votes[sets.find(index) as usize];
            *vote = (*vote).min(body.rest_vote(context));
            *is_supported |= body.has_own_support();
        }
        for (index, body) in (0..).zip(bodies) {
            let (vote, is_supported) = votes[sets.find(index) as usize];
            body.follow(if is_supported { vote } else { vote.min(RestVote::Awake) });
        }
    }

    /// Couples the damping of bodies that pressed on each other in the last step.
    pub(super) fn couple_damping(&mut self, bodies: &mut [Body], supports: &mut PairSupports, dt: f64) {
        let Self { sides, coupling, .. } = self;
        // Positions that were set, or a body that was restored, end the support.
        supports.retain(|support| {
            let [first, second] = support.sides;
            let touches = |side: (u32, u32), other: (u32, u32)| {
                bodies.get(side.0 as usize).is_some_and(|body| body.touches().contains(&(side.1, other.0)))
            };
            touches(first, second) && touches(second, first)
        });
        sides.clear();
        sides.extend(supports.list().iter().flat_map(|support| support.sides));
        sides.sort_unstable();
        sides.dedup();
        coupling.components.clear();
        coupling.components.extend(sides.iter().filter_map(|&(body, component)| {
            bodies.get(body as usize).and_then(|found| found.coupled_component(body, component))
        }));
        coupling.solve(supports.list_mut(), dt);
        for component in &coupling.components {
            bodies[component.side.0 as usize].add_coupling(component);
        }
    }
}

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
