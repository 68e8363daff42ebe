//! Finds the bodies that may touch in a step, and how often they are searched.

use super::bounds::Bounds;
use super::contacts::{BodyContacts, NearBody, NearPair};
use super::motion::MotionBounds;
use super::search::Search;
use super::view::{BodyView, ContactStep};
use crate::contact::SKIN;
use crate::contact::stage::MIN_BOUNCE_STEPS;

/// Greatest motion of two bodies relative to each other between two searches, in cells, up to [`MAX_SEARCHES`], at the
/// velocities before the step.
const SEARCH_DISPLACEMENT: f64 = 0.5;

/// As [`SEARCH_DISPLACEMENT`], at the velocities at the end of the step without contacts. They include those with
/// which vertices that contacts press inwards spring back, and which the contacts take away again. This motion is
/// fast, but short: it ends at the surface from which it began.
const REBOUND_DISPLACEMENT: f64 = 1.0;

/// Distance in cells by which a body may move before its contacts are searched again. In the steps before, the samples
/// that touched at the last search follow their points of the other surface. Samples that begin to touch are so noticed
/// up to three times as deep: both bodies move, and one of them may have moved before the last search.
pub(crate) const SEARCH_DISTANCE: f64 = 0.02;

/// Greatest number of searches of a pair in a step: a power of two.
const MAX_SEARCHES: u32 = 16;

impl BodyContacts {
    /// Finds the pairs of bodies whose boxes overlap during a step of `dt` seconds. Returns whether there is one.
    /// `is_asleep` returns whether a body sleeps; two sleeping bodies are no pair.
    pub(super) fn pair<'a>(
        &mut self,
        count: u32,
        view: impl Fn(u32) -> Option<BodyView<'a>>,
        is_asleep: impl Fn(u32) -> bool,
        dt: f64,
    ) -> bool {
        let Self { filter, bounds, order, pairs, .. } = self;
        let motion = |index: u32| {
            let motion = view(index).map_or(MotionBounds::EMPTY, |body| body.contact.motions.all);
            match is_asleep(index) {
                true => MotionBounds { velocities: Bounds::ZERO, velocities_before: Bounds::ZERO, ..motion },
                false => motion,
            }
        };
        let margin = |body: BodyView| SKIN * body.lattice.cell_size() + body.properties.thickness;
        bounds.clear();
        bounds.extend((0..count).map(|index| {
            view(index).map_or(Bounds::EMPTY, |body| motion(index).swept(dt).enlarged(margin(body)))
        }));
        pairs.clear();
        for &index in filter.with_itself.iter().filter(|body| !is_asleep(**body)) {
            let Some(body) = view(index) else { continue };
            let near = body.contact.motions.near(body.touches_itself, dt, margin(body), order);
            pairs.extend(near.map(|near| NearPair { bodies: (index, index), near }));
        }
        if filter.between {
            let swept = |body: u32| bounds[body as usize];
            Bounds::for_each_pair(count, swept, false, order, |a, b| {
                if !(is_asleep(a) && is_asleep(b)) && filter.may_touch(a, b) {
                    let near = motion(a).nearness(&motion(b), swept(a).intersection(&swept(b)));
                    pairs.push(NearPair { bodies: (a.min(b), a.max(b)), near });
                }
            });
            pairs.sort_unstable_by_key(|pair| pair.bodies);
        }
        let unit = |index| view(index).map_or(f64::INFINITY, |body| body.lattice.cell_size()) / dt;
        self.add_searches(count as usize, unit, |index| {
            view(index).map_or(0.0, |body| body.properties.thickness)
        });
        !self.pairs.is_empty()
    }

    /// Adds the searches of the pairs. `unit`: the speed of a body that moves by one of its cells in the step.
    /// `thickness`: that of a body.
    fn add_searches(&mut self, count: usize, unit: impl Fn(u32) -> f64, thickness: impl Fn(u32) -> f64) {
        (self.island_count, self.search_count) = (0, 0);
        self.bodies.clear();
        self.bodies.resize(count, NearBody::ALONE);
        for index in 0..self.pairs.len() {
            let NearPair { bodies: (a, b), near } = self.pairs[index];
            let (unit, thickness) = (unit(a).min(unit(b)), thickness(a) + thickness(b));
            let part = |displacement: f64, limit: f64| displacement / (limit * unit);
            let times =
                part(near.speed_before, SEARCH_DISPLACEMENT).max(part(near.speed, REBOUND_DISPLACEMENT));
            let times = (times.clamp(1.0, MAX_SEARCHES.into()).ceil() as u32).next_power_of_two();
            for body in [a, b] {
                let body = &mut self.bodies[body as usize];
                body.region = body.region.union(&near.region);
                body.has_partner |= a != b;
                body.times = body.times.max(times);
                body.thickness = body.thickness.max(thickness);
            }
            self.add_search([a, b], times, thickness);
            if a != b {
                self.add_search([b, a], times, thickness);
            }
        }
    }

    fn add_search(&mut self, bodies: [u32; 2], times: u32, thickness: f64) {
        if self.search_count == self.searches.len() {
            self.searches.push(Search::default());
        }
        self.searches[self.search_count].begin(bodies, times, thickness);
        self.search_count += 1;
    }

    /// Decides which pairs are searched in a step, and for which the contacts of the last search are followed. The
    /// bodies of all pairs must have their search distances.
    pub(super) fn choose_searches<'a>(
        &mut self,
        view: impl Fn(u32) -> Option<BodyView<'a>>,
        step: ContactStep,
    ) {
        let Self { searches, search_count, bodies, .. } = self;
        for search in &mut searches[..*search_count] {
            let both = [search.body, search.other].map(&view);
            let cell_size = |body: &Option<BodyView>| body.map_or(0.0, |body| body.lattice.cell_size());
            let distance = |body: &Option<BodyView>| {
                body.map_or(f64::INFINITY, |body| body.contact.searched.distance * body.lattice.cell_size())
            };
            let limit = 2.0 * SEARCH_DISTANCE * cell_size(&both[0]).min(cell_size(&both[1]));
            let is_near = distance(&both[0]) + distance(&both[1]) <= limit;
            search.follows = is_near && !can_bounce(&both, MIN_BOUNCE_STEPS * step.gravity * step.dt);
            for body in [search.body, search.other] {
                bodies[body as usize].is_searched |= !search.follows;
            }
        }
    }
}

/// Returns whether two bodies may bounce off each other: one of them bounces, and they move faster than `speed`
/// relative to each other. A contact that is noticed late does not bounce.
fn can_bounce(bodies: &[Option<BodyView>; 2], speed: f64) -> bool {
    let [Some(first), Some(second)] = bodies else { return false };
    let [a, b] = [first, second].map(|body| &body.contact.motions.all.velocities_before);
    first.properties.restitution.max(second.properties.restitution) > 0.0 && a.greatest_difference(b) > speed
}
