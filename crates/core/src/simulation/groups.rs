//! Selects the bodies that can touch each other, and computes for groups of touching bodies.

use nalgebra::Vector3;

use crate::body::{Body, RestVote, StepContext};
use crate::contact::bodies::{BodyContacts, ContactFilter, ContactKind, mean_friction};
use crate::dynamics::Coupling;
use crate::mesh::UnionFind;
use crate::state::{PairSupport, PairSupports};

/// The contacts between bodies that are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ContactSettings {
    /// Whether bodies touch each other.
    pub(super) between: bool,
    /// The default self-contact, of bodies without a setting of their own.
    pub(super) with_itself: bool,
}

/// Creates the contacts between bodies, or returns `None` if no body can touch another one or itself.
pub(super) fn create(bodies: &mut [Body], settings: ContactSettings) -> Option<BodyContacts> {
    let mut contacts = None;
    begin(bodies, 0, settings, &mut contacts);
    contacts
}

/// Updates the contacts between bodies for new bodies: those from the index `first` on.
pub(super) fn begin(
    bodies: &mut [Body],
    first: usize,
    settings: ContactSettings,
    contacts: &mut Option<BodyContacts>,
) {
    for body in &mut bodies[first..] {
        body.set_self_contact(connected_parts_touch(body, settings));
    }
    update(bodies, settings, contacts);
}

/// Updates the contacts between bodies after bodies broke into pieces, which touch each other.
pub(super) fn update(bodies: &mut [Body], settings: ContactSettings, contacts: &mut Option<BodyContacts>) {
    let filter = filter(bodies, settings);
    for (index, body) in (0..).zip(&mut *bodies) {
        body.update_body_contact(filter.between || filter.with_itself.binary_search(&index).is_ok());
    }
    match filter.between || !filter.with_itself.is_empty() {
        true => contacts.get_or_insert_default().set_filter(filter),
        false => *contacts = None,
    }
}

/// Returns whether connected parts of a body touch each other.
fn connected_parts_touch(body: &Body, settings: ContactSettings) -> bool {
    !body.is_rigid() && body.touching().self_contact.unwrap_or(settings.with_itself)
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
    let kind = |body: &Body| ContactKind { is_rigid: body.is_rigid(), soft_only: body.touching().soft_only };
    let mut kinds: Vec<_> = bodies.iter().map(kind).collect();
    if !kinds.iter().any(|kind| kind.soft_only) {
        kinds.clear();
    }
    ContactFilter { between, with_itself, ignored, kinds }
}

/// Buffers for the computations of groups of touching bodies.
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

    /// Couples the damping of bodies that press on each other.
    pub(super) fn couple_damping(&mut self, bodies: &mut [Body], supports: &mut PairSupports, dt: f64) {
        if supports.list().is_empty() {
            return;
        }
        let Self { sides, coupling, .. } = self;
        sides.clear();
        sides.extend(supports.list().iter().flat_map(|support| support.sides));
        sides.sort_unstable();
        sides.dedup();
        coupling.components.clear();
        coupling.components.extend(sides.iter().filter_map(|&(body, component)| {
            bodies.get(body as usize).and_then(|found| found.coupled_component(body, component))
        }));
        let friction = |support: &PairSupport| {
            mean_friction(support.sides.map(|(body, _)| bodies[body as usize].touching().friction))
        };
        coupling.solve(supports.list_mut(), dt, friction);
        for component in &coupling.components {
            bodies[component.side.0 as usize].add_coupling(component);
        }
    }

    /// Returns the reactions of the supports of bodies by each other in the last step.
    pub(super) fn reactions(&self) -> &[Vector3<f64>] {
        &self.coupling.reactions
    }
}
