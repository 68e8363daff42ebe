//! Contact between bodies, and of a body with itself.
//!
//! A step runs these parts after the integration of the positions:
//!
//! 1. The bodies whose boxes overlap are paired ([`BodyContacts::pair`]). Their pins and handles are applied, and their
//!    contacts with colliders found.
//! 2. The samples of each body of a pair are searched in the other one, several times in a step if they move fast.
//! 3. Bodies that touch form islands. The impulses of an island are computed together, with those of its contacts with
//!    colliders ([`BodyContacts::solve`]).
//! 4. Each body applies its part of the result.
//!
//! | file | content |
//! |---|---|
//! | `surface` | the surface of a body at rest: its triangles and samples |
//! | `view` | the data of a body that are read |
//! | `bounds`, `grid`, `deformed_cell` | axis-aligned boxes, a grid of them, and the geometry of one deformed cell |
//! | `motion` | boxes of the motion of a body and of its pieces |
//! | `posed` | the deformed lattice at one time; the cell that contains a point |
//! | `foot` | the point of a surface at rest that a sample touches |
//! | `search` | the samples of a body that touch another one |
//! | `island` | the contact problem of bodies that touch each other |
//! | `gaps` | the gaps between a body and those around it, which limit the displayed surface |

mod bounds;
mod deformed_cell;
mod foot;
mod gaps;
mod grid;
mod island;
mod motion;
mod posed;
mod search;
mod surface;
mod view;

pub(crate) use self::bounds::Bounds;
pub(crate) use self::gaps::{GapBody, GapSearch};
pub(crate) use self::island::{Island, PairContact};
pub(crate) use self::motion::PieceVertices;

pub(crate) use self::surface::ContactSurface;
pub(crate) use self::view::{BodyContact, BodyView, MomentumChange, SurfaceProperties};

use nalgebra::Vector3;

use self::motion::{MotionBounds, NearPieces};
use self::search::{Search, Touch};
use super::SKIN;
use super::stage::MIN_BOUNCE_STEPS;
use crate::mesh::UnionFind;
use crate::parallel::Executor;
use crate::state::SampleTouch;

/// Greatest motion of two bodies relative to each other between two searches, in cells, up to [`MAX_SEARCHES`], at the
/// velocities before the step.
const SEARCH_WAY: f64 = 0.5;

/// As [`SEARCH_WAY`], at the velocities at the end of the step without contacts. They include those with which vertices
/// that contacts press inwards spring back, and which the contacts take away again. This motion is fast, but short: it
/// ends at the surface from which it began.
const REBOUND_WAY: f64 = 1.0;

/// Distance in cells by which a body may move before its contacts are searched again. In the steps before, the samples
/// that touched at the last search follow their points of the other surface. Samples that begin to touch are so noticed
/// up to three times as deep: both bodies move, and one of them may have moved before the last search.
pub(crate) const SEARCH_DISTANCE: f64 = 0.02;

/// Depth in cells of the smaller cell size from which bodies count as overlapping.
const OVERLAP: f64 = 0.1;

/// Greatest number of searches of a pair in a step: a power of two.
const MAX_SEARCHES: u32 = 16;

/// Pairs of bodies that can touch.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactFilter {
    /// Whether different bodies touch each other.
    pub(crate) between: bool,
    /// The bodies that touch themselves, in increasing order.
    pub(crate) with_itself: Vec<u32>,
    /// Pairs of bodies that do not touch, the lesser index first, in increasing order.
    pub(crate) ignored: Vec<(u32, u32)>,
}

impl ContactFilter {
    /// Returns whether a body touches another one, or itself.
    fn may_touch(&self, body: u32, other: u32) -> bool {
        match body == other {
            true => self.with_itself.binary_search(&body).is_ok(),
            false => self.between && self.ignored.binary_search(&(body.min(other), body.max(other))).is_err(),
        }
    }
}

/// The contacts between the bodies of a simulation. Its buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct BodyContacts {
    filter: ContactFilter,
    /// Box of the positions of each body during the step, with a margin for touching.
    bounds: Vec<Bounds>,
    /// Bodies in increasing order of the lower x coordinates of their boxes.
    order: Vec<u32>,
    /// Box in which each body is searched; empty if it is in no pair.
    regions: Vec<Bounds>,
    /// Whether each body is in a pair with another one.
    has_partner: Vec<bool>,
    /// Greatest number of times in a step at which each body is searched.
    times: Vec<u32>,
    /// Whether each body is searched in this step.
    is_searched: Vec<bool>,
    /// The searches of this step are the first `search_count` ones.
    searches: Vec<Search>,
    search_count: usize,
    pairs: Vec<(u32, u32)>,
    /// The bodies whose pieces may touch each other, in increasing order.
    in_pieces: Vec<(u32, NearPieces)>,
    /// The islands of this step are the first `island_count` ones.
    islands: Vec<Island>,
    island_count: usize,
    /// Island of each body, and its index there.
    places: Vec<Option<(u32, u32)>>,
    /// The contacts of the last step, and those in which sleeping bodies fell asleep, with their forces.
    records: Vec<(PairContact, Vector3<f64>)>,
    sets: UnionFind,
}

impl BodyContacts {
    pub(crate) fn new(filter: ContactFilter) -> Self {
        Self { filter, ..Self::default() }
    }

    /// Changes which bodies touch each other.
    pub(crate) fn set_filter(&mut self, filter: ContactFilter) {
        self.filter = filter;
    }

    /// Returns whether a body touches another one, or itself.
    pub(crate) fn may_touch(&self, body: u32, other: u32) -> bool {
        self.filter.may_touch(body, other)
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self {
            bounds,
            order,
            regions,
            has_partner,
            times,
            is_searched,
            searches,
            pairs,
            in_pieces,
            islands,
            places,
            records,
            ..
        } = self;
        size_of_val(&**bounds)
            + size_of_val(&**is_searched)
            + size_of_val(&**order)
            + size_of_val(&**regions)
            + size_of_val(&**has_partner)
            + size_of_val(&**times)
            + searches.iter().map(Search::bytes).sum::<usize>()
            + size_of_val(&**searches)
            + size_of_val(&**pairs)
            + size_of_val(&**in_pieces)
            + islands.iter().map(Island::bytes).sum::<usize>()
            + size_of_val(&**places)
            + size_of_val(&**records)
    }

    /// Finds the pairs of bodies whose boxes overlap during a step of `dt` seconds. Returns whether there is one.
    /// `is_asleep` returns whether a body sleeps; two sleeping bodies are no pair.
    pub(crate) fn pair<'a>(
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
            let part = |way: f64, limit: f64| way / (limit * unit);
            let times = part(speed_before, SEARCH_WAY).max(part(speed, REBOUND_WAY));
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

    /// Returns the times of the searches, as parts of the step before its end: decreasing, the last one 0.
    pub(crate) fn search_times(&self) -> impl Iterator<Item = f64> + use<> {
        let times = self.times.iter().copied().max().unwrap_or(1);
        (1..=times).map(move |time| 1.0 - f64::from(time) / f64::from(times))
    }

    /// Returns the box in which a body is searched, or `None` if it is in no pair.
    pub(crate) fn region(&self, body: u32) -> Option<Bounds> {
        self.regions.get(body as usize).copied().filter(|region| !region.is_empty())
    }

    /// Returns whether a body is in a pair with another one.
    pub(crate) fn has_partner(&self, body: u32) -> bool {
        self.has_partner[body as usize]
    }

    /// Decides which pairs are searched in a step of `dt` seconds, and for which the contacts of the last search are
    /// followed. All bodies of pairs know their search distance. `gravity` is the magnitude of gravity.
    pub(crate) fn choose_searches<'a>(
        &mut self,
        view: impl Fn(u32) -> Option<BodyView<'a>>,
        (dt, gravity): (f64, f64),
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
            search.follows = is_near && !can_bounce(&both, MIN_BOUNCE_STEPS * gravity * dt);
            for body in [search.body, search.other] {
                is_searched[body as usize] |= !search.follows;
            }
        }
    }

    /// Returns the box in which a body is searched at the time `past`, a part of the step before its end, or `None` if
    /// it is not searched then.
    pub(crate) fn region_at(&self, body: u32, past: f64) -> Option<Bounds> {
        let is_searched = |body: usize| self.is_searched[body] && is_search_time(past, self.times[body]);
        self.region(body).filter(|_| is_searched(body as usize))
    }

    /// Searches the touching samples at the time `past`, a part of the step of `dt` seconds before its end. All bodies
    /// of pairs are posed at this time. Samples that touched at an earlier time are not searched again.
    pub(crate) fn search<'a>(
        &mut self,
        view: impl Fn(u32) -> Option<BodyView<'a>> + Sync + Send,
        (past, dt): (f64, f64),
        executor: &Executor,
    ) {
        executor.for_each_mut(&mut self.searches[..self.search_count], |search| {
            let is_search_time =
                if search.follows { past == 0.0 } else { is_search_time(past, search.times) };
            if let (true, Some(body), Some(other)) = (is_search_time, view(search.body), view(search.other)) {
                match search.follows {
                    true => search.update_touches(&body, &other),
                    false => search.run(&body, &other, past * dt, dt),
                }
            }
        });
    }

    /// Forms the islands, and computes their impulses in a step of `dt` seconds. `gravity` is the magnitude of gravity.
    pub(crate) fn solve<'a>(
        &mut self,
        view: impl Fn(u32) -> Option<BodyView<'a>> + Sync + Send,
        (dt, gravity): (f64, f64),
        executor: &Executor,
    ) {
        let Self { searches, search_count, islands, places, sets, .. } = self;
        let searches = &searches[..*search_count];
        sets.reset(places.len());
        places.fill(None);
        for search in searches.iter().filter(|search| !search.touches.is_empty()) {
            sets.unite(search.body, search.other);
            // Marks the bodies that touch; the islands follow.
            for body in [search.body, search.other] {
                places[body as usize] = Some((0, 0));
            }
        }
        self.island_count = 0;
        for body in 0..places.len() as u32 {
            if places[body as usize].is_none() {
                continue;
            }
            let root = sets.find(body);
            if root == body {
                if self.island_count == islands.len() {
                    islands.push(Island::default());
                }
                islands[self.island_count].begin(self.island_count as u32);
                self.island_count += 1;
            }
            // The root is the first body of its island.
            let index = if root == body { self.island_count as u32 - 1 } else { island_index(places, root) };
            let member = islands[index as usize].add_body(body);
            places[body as usize] = Some((index, member));
        }
        let places = &*places;
        executor.for_each_mut(&mut islands[..self.island_count], |island| {
            let index = island.index();
            let searches = searches.iter().filter(|search| !search.touches.is_empty());
            let own = searches.filter(|search| island_index(places, search.body) == index);
            let view = |body| view(body).expect("bodies that touch have a surface");
            island.solve(view, own, (dt, gravity));
        });
    }

    /// Returns the island of a body, and the index of the body there, or `None` if it touches no body.
    pub(crate) fn island_of(&self, body: u32) -> Option<(&Island, usize)> {
        let (island, member) = (*self.places.get(body as usize)?)?;
        Some((&self.islands[island as usize], member as usize))
    }

    /// Returns whether two bodies are a pair of this step.
    pub(crate) fn is_pair(&self, body: u32, other: u32) -> bool {
        self.pairs.binary_search(&(body.min(other), body.max(other))).is_ok()
    }

    /// Returns the samples of a body that touch bodies.
    pub(crate) fn touches(&self, body: u32) -> impl Iterator<Item = SampleTouch> {
        let searches = self.searches[..self.search_count].iter().filter(move |search| search.body == body);
        searches.flat_map(|search| {
            let touch = |touch: &Touch, is_touching: bool| SampleTouch {
                other: search.other,
                sample: touch.sample,
                is_touching,
                normal: touch.normal.map(|x| x as f32).into(),
                foot: touch.foot,
            };
            let lifted = search.lifted.iter().map(move |lifted| touch(lifted, false));
            search.touches.iter().map(move |touching| touch(touching, true)).chain(lifted)
        })
    }

    /// Records the contacts of a step of `dt` seconds. Those of sleeping bodies remain.
    pub(crate) fn record(&mut self, is_asleep: impl Fn(u32) -> bool, dt: f64) {
        let Self { records, islands, island_count, .. } = self;
        records.retain(|(pair, _)| pair.bodies.iter().all(|&body| is_asleep(body)));
        let pairs = islands[..*island_count].iter().flat_map(Island::pairs);
        records.extend(pairs.map(|pair| (*pair, pair.impulse / dt)));
    }

    /// Returns the pairs of different bodies that overlapped in the last search, with the greatest depth of a sample in
    /// scene units, if that is more than [`OVERLAP`].
    pub(crate) fn overlaps(&self, cell_size: impl Fn(u32) -> f64) -> Vec<(usize, usize, f64)> {
        let mut overlaps: Vec<(usize, usize, f64)> = Vec::new();
        for search in self.searches[..self.search_count].iter().filter(|search| search.body != search.other) {
            let (a, b) = (search.body.min(search.other), search.body.max(search.other));
            let depth = search.touches.iter().map(|touch| -touch.gap).fold(0.0, f64::max);
            if depth > OVERLAP * cell_size(a).min(cell_size(b)) {
                let pair = (a as usize, b as usize);
                // Both searches of a pair follow each other.
                match overlaps.last_mut().filter(|last| (last.0, last.1) == pair) {
                    Some(last) => last.2 = last.2.max(depth),
                    None => overlaps.push((pair.0, pair.1, depth)),
                }
            }
        }
        overlaps
    }

    /// Forgets the recorded contacts.
    pub(crate) fn clear_records(&mut self) {
        self.records.clear();
    }

    /// Returns the recorded contacts, with the force on the first body of each.
    pub(crate) fn records(&self) -> &[(PairContact, Vector3<f64>)] {
        &self.records
    }

    /// Returns the contacts between bodies of this step.
    pub(crate) fn contacts(&self) -> impl Iterator<Item = &PairContact> {
        self.islands[..self.island_count].iter().flat_map(Island::pairs)
    }
}

/// Returns whether the time `past`, a part of the step before its end, is one of `times` evenly spaced ones.
fn is_search_time(past: f64, times: u32) -> bool {
    (past * f64::from(times)).fract() == 0.0
}

/// Returns whether two bodies may bounce off each other: one of them bounces, and they move faster than `speed`
/// relative to each other. A contact that is noticed late does not bounce.
fn can_bounce(bodies: &[Option<BodyView>; 2], speed: f64) -> bool {
    let [Some(first), Some(second)] = bodies else { return false };
    let [a, b] = [first, second].map(|body| &body.contact.motion.velocities_before);
    first.properties.restitution.max(second.properties.restitution) > 0.0 && a.greatest_difference(b) > speed
}

/// Returns the island of a body that touches another one.
fn island_index(places: &[Option<(u32, u32)>], body: u32) -> u32 {
    places[body as usize].map_or(u32::MAX, |(island, _)| island)
}

/// Returns where the pieces of a body touch each other, if the pair is one of a body with itself, and searched by its
/// pieces.
fn near_pieces(in_pieces: &[(u32, NearPieces)], a: u32, b: u32) -> Option<NearPieces> {
    let found = in_pieces.binary_search_by_key(&a, |(body, _)| *body).ok().filter(|_| a == b)?;
    Some(in_pieces[found].1)
}
