//! The contacts between the bodies of a simulation in a step.

use nalgebra::Vector3;

use super::bounds::Bounds;
use super::filter::ContactFilter;
use super::island::{Island, PairContact};
use super::motion::Nearness;
use super::posed::PosedLattice;
use super::search::{Search, Touch};
use super::view::{BodyView, ContactStep};
use crate::mesh::UnionFind;
use crate::parallel::Executor;
use crate::state::{PairSupports, SampleTouch};

/// Depth in cells of the smaller cell size from which bodies count as overlapping.
const OVERLAP: f64 = 0.1;

/// A body that can touch other ones.
pub(crate) trait TouchingBody: Send + Sync {
    /// Returns the body as contact between bodies reads it, or `None` if it touches no bodies.
    fn contact_view(&self) -> Option<BodyView<'_>>;

    /// Lists the cells of the body that may touch other cells of it, unless the last list has them.
    fn list_near_cells(&mut self);

    /// Returns whether the body sleeps. Two sleeping bodies do not touch.
    fn is_asleep(&self) -> bool;
}

/// The part of a body in the contacts between bodies of a step.
pub(crate) enum BodyContactPart<'a> {
    /// No body is near, and the body cannot touch itself.
    Alone,
    /// A body is near, or the body can touch itself, but nothing touches.
    Near,
    /// The body is the `member`-th one of an island, and the `index`-th one of the simulation.
    InIsland { contacts: &'a BodyContacts, island: &'a Island, member: usize, index: u32 },
}

/// A body in the contacts of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearBody {
    /// Box in which it is searched; empty if it is in no pair.
    pub(super) region: Bounds,
    /// Whether it is in a pair with another body.
    pub(super) has_partner: bool,
    /// Greatest number of times in the step at which it is searched.
    pub(super) times: u32,
    /// Greatest sum of its thickness and that of a body of a pair.
    pub(super) thickness: f64,
    /// Whether it is searched.
    pub(super) is_searched: bool,
    /// Whether only the cells that the body lists ([`TouchingBody::list_near_cells`]) are searched.
    is_listed: bool,
    /// Its island, and its index there.
    place: Option<(u32, u32)>,
}

impl NearBody {
    /// A body in no pair.
    pub(super) const ALONE: Self = Self {
        region: Bounds::EMPTY,
        has_partner: false,
        times: 1,
        thickness: 0.0,
        is_searched: false,
        is_listed: false,
        place: None,
    };
}

/// Two bodies that may touch in a step, or a body and itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearPair {
    /// The lesser one first.
    pub(super) bodies: (u32, u32),
    pub(super) near: Nearness,
}

/// The contacts between the bodies of a simulation. Its buffers are reused.
#[derive(Debug, Default)]
pub(crate) struct BodyContacts {
    pub(super) filter: ContactFilter,
    /// Box of the positions of each body during the step, with a margin for touching.
    pub(super) bounds: Vec<Bounds>,
    /// Bodies in increasing order of the lower x coordinates of their boxes.
    pub(super) order: Vec<u32>,
    pub(super) bodies: Vec<NearBody>,
    /// The searches of this step are the first `search_count` ones.
    pub(super) searches: Vec<Search>,
    pub(super) search_count: usize,
    /// In increasing order of the bodies.
    pub(super) pairs: Vec<NearPair>,
    /// The islands of this step are the first `island_count` ones.
    islands: Vec<Island>,
    pub(super) island_count: usize,
    /// The lattice of each body at the time of a search.
    posed: Vec<PosedLattice>,
    /// The contacts of the last step, and those in which sleeping bodies fell asleep, with their forces.
    records: Vec<(PairContact, Vector3<f64>)>,
    sets: UnionFind,
}

impl BodyContacts {
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
        let Self { bounds, order, bodies, searches, pairs, islands, posed, records, .. } = self;
        size_of_val(&**bounds)
            + size_of_val(&**order)
            + size_of_val(&**bodies)
            + searches.iter().map(Search::bytes).sum::<usize>()
            + size_of_val(&**searches)
            + size_of_val(&**pairs)
            + islands.iter().map(Island::bytes).sum::<usize>()
            + posed.iter().map(PosedLattice::bytes).sum::<usize>()
            + size_of_val(&**posed)
            + size_of_val(&**records)
    }

    /// Runs the contacts of a step: pairs the bodies, searches where they touch, and computes the
    /// impulses of the islands. `prepare` prepares a body that is near another one or near itself; its second
    /// argument is whether only the body itself is near.
    pub(crate) fn resolve<B: TouchingBody>(
        &mut self,
        bodies: &mut [B],
        prepare: impl Fn(&mut B, bool) + Send + Sync,
        step: ContactStep,
        executor: &Executor,
    ) {
        let is_asleep = |index: u32| bodies[index as usize].is_asleep();
        if !self.pair(bodies.len() as u32, |index| bodies[index as usize].contact_view(), is_asleep, step.dt)
        {
            return;
        }
        executor.for_each_indexed(bodies, |index, body| {
            if self.region(index).is_some() {
                prepare(body, !self.bodies[index as usize].has_partner);
            }
        });
        self.choose_searches(|index| bodies[index as usize].contact_view(), step);
        for body in &mut self.bodies {
            // The list is one for the positions at the end of the step.
            body.is_listed = body.is_searched && !body.has_partner && body.times == 1;
        }
        if self.bodies.iter().any(|body| body.is_listed) {
            executor.for_each_indexed(bodies, |index, body| {
                if self.bodies[index as usize].is_listed {
                    body.list_near_cells();
                }
            });
        }
        let view = |index: u32| bodies[index as usize].contact_view();
        for past in self.search_times() {
            self.search(view, past, step.dt, executor);
        }
        self.solve(view, step, executor);
    }

    /// Returns the pairs of different bodies that overlap, with the greatest depth of a sample in scene units, if
    /// that is more than [`OVERLAP`]. `prepare` prepares a body that is near another one.
    pub(crate) fn overlaps<B: TouchingBody>(
        &mut self,
        bodies: &mut [B],
        prepare: impl Fn(&mut B) + Send + Sync,
    ) -> Vec<(usize, usize, f64)> {
        if !self.pair(bodies.len() as u32, |index| bodies[index as usize].contact_view(), |_| false, 0.0) {
            return Vec::new();
        }
        // On the calling thread, which may hold locks of the caller.
        let executor = Executor::sequential();
        executor.for_each_indexed(bodies, |index, body| {
            if self.region(index).is_some() {
                prepare(body);
            }
        });
        self.bodies.iter_mut().for_each(|body| body.is_searched = true);
        let view = |index: u32| bodies[index as usize].contact_view();
        self.search(view, 0.0, 0.0, &executor);
        self.found_overlaps(|body| view(body).map_or(f64::INFINITY, |body| body.lattice.cell_size()))
    }

    /// Returns the part of a body in the contacts of the step.
    pub(crate) fn part_of(&self, body: u32) -> BodyContactPart<'_> {
        match (self.region(body), self.island_of(body)) {
            (None, _) => BodyContactPart::Alone,
            (Some(_), None) => BodyContactPart::Near,
            (Some(_), Some((island, member))) => {
                BodyContactPart::InIsland { contacts: self, island, member, index: body }
            }
        }
    }

    /// Returns the box in which a body is searched, or `None` if it is in no pair.
    fn region(&self, body: u32) -> Option<Bounds> {
        self.bodies.get(body as usize).map(|body| body.region).filter(|region| !region.is_empty())
    }

    /// Returns the times of the searches, as parts of the step before its end: decreasing, the last one 0.
    fn search_times(&self) -> impl Iterator<Item = f64> + use<> {
        let times = self.bodies.iter().map(|body| body.times).max().unwrap_or(1);
        (1..=times).map(move |time| 1.0 - f64::from(time) / f64::from(times))
    }

    /// Searches the touching samples at the time `past`, a part of the step of `dt` seconds before its end, in the
    /// lattices at this time. Samples that touched at an earlier time are not searched again.
    fn search<'a>(
        &mut self,
        view: impl Fn(u32) -> Option<BodyView<'a>> + Sync + Send,
        past: f64,
        dt: f64,
        executor: &Executor,
    ) {
        let Self { posed, bodies, searches, search_count, .. } = self;
        posed.resize_with(bodies.len(), PosedLattice::default);
        executor.for_each_indexed(posed, |body, posed| {
            let NearBody { region, times, thickness, is_searched, is_listed, .. } = &bodies[body as usize];
            if *is_searched
                && is_search_time(past, *times)
                && !region.is_empty()
                && let Some(body) = view(body)
            {
                let among = if *is_listed { body.contact.near_cells.list() } else { None };
                body.pose(posed, past * dt, region, *thickness, among);
            }
        });
        let posed = &*posed;
        executor.for_each_mut(&mut searches[..*search_count], |search| {
            let is_search_time =
                if search.follows { past == 0.0 } else { is_search_time(past, search.times) };
            if let (true, Some(body), Some(other)) = (is_search_time, view(search.body), view(search.other)) {
                let lattices = [search.body, search.other].map(|body| &posed[body as usize]);
                match search.follows {
                    true => search.update_touches(&body, &other),
                    false => search.run([&body, &other], lattices, past * dt, dt),
                }
            }
        });
    }

    /// Forms the islands, and computes their impulses in a step.
    fn solve<'a>(
        &mut self,
        view: impl Fn(u32) -> Option<BodyView<'a>> + Sync + Send,
        step: ContactStep,
        executor: &Executor,
    ) {
        let Self { searches, search_count, islands, bodies, sets, .. } = self;
        let searches = &searches[..*search_count];
        sets.reset(bodies.len());
        for search in searches.iter().filter(|search| !search.touches.is_empty()) {
            sets.unite(search.body, search.other);
            // Marks the bodies that touch; the islands follow.
            for body in [search.body, search.other] {
                bodies[body as usize].place = Some((0, 0));
            }
        }
        self.island_count = 0;
        for body in 0..bodies.len() as u32 {
            if bodies[body as usize].place.is_none() {
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
            let index = if root == body { self.island_count as u32 - 1 } else { island_index(bodies, root) };
            let member = islands[index as usize].add_body(body);
            bodies[body as usize].place = Some((index, member));
        }
        let bodies = &*bodies;
        executor.for_each_mut(&mut islands[..self.island_count], |island| {
            let index = island.index;
            let searches = searches.iter().filter(|search| !search.touches.is_empty());
            let own = searches.filter(|search| island_index(bodies, search.body) == index);
            let view = |body| view(body).expect("bodies that touch have a surface");
            island.solve(view, own, step);
        });
    }

    /// Returns the island of a body, and the index of the body there, or `None` if it touches no body.
    fn island_of(&self, body: u32) -> Option<(&Island, usize)> {
        let (island, member) = self.bodies.get(body as usize)?.place?;
        Some((&self.islands[island as usize], member as usize))
    }

    /// Returns whether two bodies are a pair of this step.
    pub(crate) fn is_pair(&self, body: u32, other: u32) -> bool {
        self.pairs.binary_search_by_key(&(body.min(other), body.max(other)), |pair| pair.bodies).is_ok()
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
                touched: touch.touched,
            };
            let separated = search.separated.iter().map(move |separated| touch(separated, false));
            search.touches.iter().map(move |touching| touch(touching, true)).chain(separated)
        })
    }

    /// Records the contacts of a step of `dt` seconds. Contacts of sleeping bodies remain. `reactions` are those of the
    /// supports, which the contacts of each share in proportion to their pressures.
    pub(crate) fn record<B: TouchingBody>(
        &mut self,
        bodies: &[B],
        (supports, reactions): (&PairSupports, &[Vector3<f64>]),
        dt: f64,
    ) {
        let Self { records, islands, island_count, .. } = self;
        records.retain(|(pair, _)| pair.bodies.iter().all(|&body| bodies[body as usize].is_asleep()));
        let reaction = |pair: &PairContact| {
            let (support, is_in_order) = supports.find(pair.sides())?;
            let sign = if is_in_order { 1.0 } else { -1.0 };
            let share = pair.pressure().max(0.0) / supports.list()[support].pressing.impulse;
            Some(reactions[support] * (sign * share))
        };
        let force = |pair: &PairContact| (pair.impulse + reaction(pair).unwrap_or_default()) / dt;
        let pairs = islands[..*island_count].iter().flat_map(|island| &island.pairs);
        records.extend(pairs.map(|pair| (*pair, force(pair))));
    }

    /// Returns the pairs of different bodies that overlapped in the last search, with the greatest depth of a sample in
    /// scene units, if that is more than [`OVERLAP`].
    fn found_overlaps(&self, cell_size: impl Fn(u32) -> f64) -> Vec<(usize, usize, f64)> {
        let mut overlaps: Vec<(usize, usize, f64)> = Vec::new();
        for search in self.searches[..self.search_count].iter().filter(|search| search.body != search.other) {
            let (a, b) = (search.body.min(search.other), search.body.max(search.other));
            // Bodies that are nearer than their thicknesses do not overlap.
            let depth = search.touches.iter().map(|touch| -touch.gap - search.thickness).fold(0.0, f64::max);
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
        self.islands[..self.island_count].iter().flat_map(|island| &island.pairs)
    }
}

/// Returns whether the time `past`, a part of the step before its end, is one of `times` evenly spaced ones.
fn is_search_time(past: f64, times: u32) -> bool {
    (past * f64::from(times)).fract() == 0.0
}

/// Returns the island of a body that touches another one.
fn island_index(bodies: &[NearBody], body: u32) -> u32 {
    bodies[body as usize].place.map_or(u32::MAX, |(island, _)| island)
}
