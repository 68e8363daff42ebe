//! Finds the bodies that may touch in a step, and how often they are searched.

use super::bounds::Bounds;
use super::contacts::BodyContacts;
use super::motion::{MotionBounds, NearPieces};
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
        let Self { filter, bounds, order, regions, has_partner, times, pairs, in_pieces, places, .. } = self;
        self.island_count = 0;
        self.search_count = 0;
        let motion = |index: u32| {
            let motion = view(index).map_or(MotionBounds::EMPTY, |body| body.contact.motion);
            match is_asleep(index) {
                true => MotionBounds { velocities: Bounds::ZERO, velocities_before: Bounds::ZERO, ..motion },
                false => motion,
            }
        };
        bounds.clear();
        bounds.extend((0..count).map(|index| {
            let margin = |body: BodyView| SKIN * body.lattice.cell_size();
            view(index).map_or(Bounds::EMPTY, |body| motion(index).swept(dt).enlarged(margin(body)))
        }));
        pairs.clear();
        in_pieces.clear();
        for &index in filter.with_itself.iter().filter(|body| !is_asleep(**body)) {
            let Some(body) = view(index) else { continue };
            if body.contact.pieces.is_any() && !body.touches_itself {
                let near = body.contact.pieces.near(dt, SKIN * body.lattice.cell_size(), order);
                let Some(near) = near else { continue };
                in_pieces.push((index, near));
            }
            pairs.push((index, index));
        }
        if filter.between {
            order.clear();
            order.extend((0..count).filter(|&body| !bounds[body as usize].is_empty()));
            order.sort_unstable_by(|&a, &b| {
                let low = |body: u32| bounds[body as usize].low.x;
                low(a).total_cmp(&low(b)).then(a.cmp(&b))
            });
            for (place, &a) in order.iter().enumerate() {
                let own = bounds[a as usize];
                let later = order[place + 1..].iter();
                for &b in later.take_while(|&&b| bounds[b as usize].low.x <= own.high.x) {
                    if bounds[b as usize].intersects(&own)
                        && !(is_asleep(a) && is_asleep(b))
                        && filter.may_touch(a, b)
                    {
                        pairs.push((a.min(b), a.max(b)));
                    }
                }
            }
            pairs.sort_unstable();
        }
        regions.clear();
        regions.resize(count as usize, Bounds::EMPTY);
        places.clear();
        places.resize(count as usize, None);
        has_partner.clear();
        has_partner.resize(count as usize, false);
        times.clear();
        times.resize(count as usize, 1);
        for &(a, b) in &*pairs {
            let overlap = match near_pieces(in_pieces, a, b) {
                Some(near) => near.region,
                None => bounds[a as usize].intersection(&bounds[b as usize]),
            };
            for body in [a, b] {
                let region = &mut regions[body as usize];
                *region = region.union(&overlap);
                has_partner[body as usize] |= a != b;
            }
        }
        for index in 0..self.pairs.len() {
            let (a, b) = self.pairs[index];
            let cell_size = |body| view(body).map_or(f64::INFINITY, |body| body.lattice.cell_size());
            let (speed_before, speed) = match near_pieces(&self.in_pieces, a, b) {
                Some(near) => (near.speed_before, near.speed),
                None => motion(a).greatest_speeds(&motion(b)),
            };
            let unit = cell_size(a).min(cell_size(b)) / dt;
            let part = |displacement: f64, limit: f64| displacement / (limit * unit);
            let times = part(speed_before, SEARCH_DISPLACEMENT).max(part(speed, REBOUND_DISPLACEMENT));
            let times = (times.clamp(1.0, MAX_SEARCHES.into()).ceil() as u32).next_power_of_two();
            for body in [a, b] {
                self.times[body as usize] = self.times[body as usize].max(times);
            }
            self.add_search(a, b, times);
            if a != b {
                self.add_search(b, a, times);
            }
        }
        !self.pairs.is_empty()
    }

    fn add_search(&mut self, body: u32, other: u32, times: u32) {
        if self.search_count == self.searches.len() {
            self.searches.push(Search::default());
        }
        self.searches[self.search_count].begin(body, other, times);
        self.search_count += 1;
    }

    /// Decides which pairs are searched in a step, and for which the contacts of the last search are followed. The
    /// bodies of all pairs must have their search distances.
    pub(super) fn choose_searches<'a>(
        &mut self,
        view: impl Fn(u32) -> Option<BodyView<'a>>,
        step: ContactStep,
    ) {
        let Self { searches, search_count, is_searched, times, .. } = self;
        is_searched.clear();
        is_searched.resize(times.len(), false);
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
                is_searched[body as usize] |= !search.follows;
            }
        }
    }
}

/// Returns whether two bodies may bounce off each other: one of them bounces, and they move faster than `speed`
/// relative to each other. A contact that is noticed late does not bounce.
fn can_bounce(bodies: &[Option<BodyView>; 2], speed: f64) -> bool {
    let [Some(first), Some(second)] = bodies else { return false };
    let [a, b] = [first, second].map(|body| &body.contact.motion.velocities_before);
    first.properties.restitution.max(second.properties.restitution) > 0.0 && a.greatest_difference(b) > speed
}

/// Returns where the pieces of a body touch each other, if the pair is one of a body with itself, and searched by its
/// pieces.
fn near_pieces(in_pieces: &[(u32, NearPieces)], a: u32, b: u32) -> Option<NearPieces> {
    let found = in_pieces.binary_search_by_key(&a, |(body, _)| *body).ok().filter(|_| a == b)?;
    Some(in_pieces[found].1)
}
