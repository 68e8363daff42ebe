//! The impulses that contacts exchange with the lattice vertices under them.
//!
//! ```text
//! contact s:   velocity u_s = sum_k w_sk v_k        impulse p_s = l_s n_s + f_s
//! vertex k:    change of v_k = sum_s w_sk p_s / m_k
//! wanted:      l_s >= 0,  n_s . u_s >= leave_s,  the one or the other equal;  |f_s| <= friction l_s, against the slip
//! ```
//!
//! All contacts act together (Jacobi), so that a symmetric body stays symmetric, each as if all that share its
//! vertices gave what it gives: by the row sum of the matrix in place of its diagonal. Impulses on a surface that is met
//! evenly are then right at once. The matrix over its row sums has eigenvalues e from zero to one, of which a pass leaves
//! the share 1 - e. So after the first pass every other one goes twice as far: two leave (1 - 2e)(1 - e), four the square
//! of that, never less than nothing: impulses come near the answer and hardly pass it. Where they do all the same, by
//! contacts that let go or slip, a share of all is taken back, so that they give no energy.

use super::exchange::{Contact, Exchange};
use super::links::{Link, Links, mean};
use super::quad::{Quad, add, dot};

/// When the impulses are good enough: after so many passes, or when one changes no contact's velocity by more than
/// `least`, or by more than `share` of what the first changed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// One, and a multiple of four.
    pub(super) passes: usize,
    pub(super) share: f32,
    pub(super) least: f32,
}

/// Solves contacts; its buffers, which grow with the largest number of them and are kept.
#[derive(Clone, Debug, Default)]
pub(super) struct Solver {
    exchanges: Vec<Exchange>,
    links: Links,
    /// What each touched vertex is given, and what one pass adds to it.
    given: Vec<Quad>,
    sums: Vec<Quad>,
}

impl Solver {
    /// For vertices in so many rows.
    pub(super) fn new(rows: usize) -> Self {
        Self { links: Links::new(rows), ..Self::default() }
    }

    /// Forgets all contacts.
    pub(super) fn clear(&mut self) {
        self.exchanges.clear();
        self.links.clear();
        self.given.clear();
        self.sums.clear();
    }

    /// Whether there is no contact.
    pub(super) fn is_empty(&self) -> bool {
        self.exchanges.is_empty()
    }

    /// Names the vertices of which the next contact is the mean: rows and weights; `mobilities` has 1/mass of each row.
    pub(super) fn link(&mut self, vertices: impl Iterator<Item = (u32, f32)>, mobilities: &[f32]) {
        self.links.extend(vertices, mobilities);
        self.given.resize(self.links.rows.list().len(), [0.0; 4]);
        self.sums.resize(self.links.rows.list().len(), [0.0; 4]);
    }

    /// The vertices that were named for the next contact.
    pub(super) fn linked(&self) -> &[Link] {
        &self.links.list[self.exchanges.last().map_or(0, |last| last.links.end)..]
    }

    /// Adds the contact whose vertices were named.
    pub(super) fn add(&mut self, contact: Contact) {
        let end = self.links.list.len();
        self.exchanges.push(Exchange::new(contact, end - self.linked().len()..end));
    }

    /// Rows of the touched vertices, in the order in which they were first named.
    pub(super) fn rows(&self) -> &[u32] {
        self.links.rows.list()
    }

    /// Exchanges impulses.
    pub(super) fn solve(&mut self, effort: Effort) {
        self.find_responses();
        let mut enough = effort.least;
        for pass in 0..effort.passes {
            let change = self.pass(if pass % 2 == 1 { 2.0 } else { 1.0 });
            if pass == 0 {
                enough = enough.max(effort.share * change);
            }
            if change <= enough {
                break;
            }
        }
        self.take_back();
    }

    /// Takes back a share of all impulses where together they give energy. Twice the work of an impulse is its product
    /// with the velocities that the contact had before, at most, and has now; what it changed of them grows with it.
    fn take_back(&mut self) {
        let (mut due, mut taken) = (0.0, 0.0);
        for exchange in &self.exchanges {
            let Contact { normal, velocity, came, most, .. } = &exchange.contact;
            let impulse = exchange.impulse();
            due += dot(&impulse, normal) * most - dot(&impulse, velocity) - dot(&impulse, came);
            taken += dot(&impulse, &mean(self.links.of(&exchange.links), &self.given));
        }
        if taken > due {
            let share = (due / taken).max(0.0);
            for given in &mut self.given {
                *given = given.map(|x| x * share);
            }
            for exchange in &mut self.exchanges {
                exchange.along *= share;
                exchange.across = exchange.across.map(|x| x * share);
            }
        }
    }

    /// What each touched vertex was given: rows and velocities.
    pub(super) fn given(&self) -> impl Iterator<Item = (u32, &Quad)> {
        self.links.rows.list().iter().copied().zip(&self.given)
    }

    /// What each touched vertex was given along the normals: rows and velocities.
    pub(super) fn given_along(&mut self) -> impl Iterator<Item = (u32, &Quad)> {
        self.sums.fill([0.0; 4]);
        for exchange in &self.exchanges {
            for link in self.links.of(&exchange.links) {
                let sum = &mut self.sums[link.vertex as usize];
                add(sum, &exchange.contact.normal, exchange.along * link.response);
            }
        }
        self.links.rows.list().iter().copied().zip(&self.sums)
    }

    /// Contacts, and the velocity that each was given along its normal.
    pub(super) fn gains(&self) -> impl Iterator<Item = (&Contact, f32)> {
        self.exchanges.iter().map(|Exchange { contact, links, .. }| {
            (contact, dot(&mean(self.links.of(links), &self.given), &contact.normal))
        })
    }

    /// The velocity of each contact if all contacts gave a unit of impulse along one direction.
    fn find_responses(&mut self) {
        let Self { exchanges, links, sums, .. } = self;
        sums.fill([0.0; 4]);
        for link in &links.list {
            sums[link.vertex as usize][0] += link.response;
        }
        for exchange in exchanges {
            let links = links.of(&exchange.links).iter();
            exchange.set_response(links.map(|link| link.weight * sums[link.vertex as usize][0]).sum());
        }
    }

    /// One pass, which goes `far` times as far as it takes for each contact alone; the greatest change of a contact's
    /// velocity.
    ///
    /// Impulses are summed and the sums clamped, so that a later pass may take back what an earlier one gave too much.
    fn pass(&mut self, far: f32) -> f32 {
        let Self { exchanges, links, given, sums, .. } = self;
        sums.fill([0.0; 4]);
        let mut greatest = 0.0_f32;
        for exchange in exchanges {
            let links = links.of(&exchange.links);
            let mut velocity = mean(links, given);
            add(&mut velocity, &exchange.contact.velocity, 1.0);
            let change = exchange.change(&velocity, far);
            greatest = greatest.max(exchange.effect(&change));
            for link in links {
                add(&mut sums[link.vertex as usize], &change, link.response);
            }
        }
        for (given, sum) in given.iter_mut().zip(&*sums) {
            add(given, sum, 1.0);
        }
        greatest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EFFORT: Effort = Effort { passes: 41, share: 0.0, least: 1e-6 };

    fn up(leave: f32, velocity: Quad) -> Contact {
        Contact { normal: [0.0, 1.0, 0.0, 0.0], velocity, leave, most: leave, ..Contact::default() }
    }

    /// A contact's velocity afterwards, and its impulse.
    fn outcome(solver: &Solver, index: usize) -> (Quad, Quad) {
        let exchange = &solver.exchanges[index];
        let mut velocity = mean(solver.links.of(&exchange.links), &solver.given);
        add(&mut velocity, &exchange.contact.velocity, 1.0);
        (velocity, exchange.impulse())
    }

    #[test]
    fn an_evenly_met_surface_is_right_at_once() {
        let mobilities = [2.0, 1.0, 1.0, 1.0, 2.0];
        let mut solver = Solver::new(5);
        for row in 0..4 {
            solver.link([(row, 0.5), (row + 1, 0.5)].into_iter(), &[1.0; 5]);
            solver.add(up(0.0, [0.0, -3.0, 0.0, 0.0]));
        }
        solver.solve(Effort { passes: 1, share: 0.0, least: 0.0 });
        assert!(solver.given().all(|(_, given)| (given[1] - 3.0).abs() < 1.5));
        // Each vertex its own contact: whatever the masses.
        solver.clear();
        for row in 0..5 {
            solver.link(std::iter::once((row, 1.0)), &mobilities);
            solver.add(up(1.5, [0.0, -3.0, 0.0, 0.0]));
        }
        solver.solve(Effort { passes: 1, share: 0.0, least: 0.0 });
        assert!(solver.given().all(|(_, given)| *given == [0.0, 4.5, 0.0, 0.0]));
        assert!(solver.given_along().all(|(_, along)| *along == [0.0, 4.5, 0.0, 0.0]));
    }

    #[test]
    fn what_leaves_faster_than_it_must_is_left_alone() {
        let mut solver = Solver::new(1);
        solver.link(std::iter::once((0, 1.0)), &[1.0]);
        solver.add(Contact { friction: 1.0, ..up(1.0, [5.0, 1.5, 0.0, 0.0]) });
        solver.solve(EFFORT);
        assert!(solver.given().all(|(_, given)| *given == [0.0; 4]));
    }

    #[test]
    fn friction_stops_within_its_cone_and_slows_outside_it() {
        for (friction, slip) in [(0.0, 3.0), (0.5, 2.0), (1.5, 0.0), (f32::MAX, 0.0)] {
            let mut solver = Solver::new(2);
            solver.link([(0, 0.5), (1, 0.5)].into_iter(), &[1.0, 1.0]);
            solver.add(Contact { friction, ..up(0.0, [3.0, -2.0, 0.0, 0.0]) });
            solver.solve(EFFORT);
            let (velocity, _) = outcome(&solver, 0);
            assert!(
                (velocity[0] - slip).abs() < 1e-5 && velocity[1].abs() < 1e-5,
                "{friction}: {velocity:?}"
            );
        }
    }

    #[test]
    fn impulses_give_no_energy_however_few_the_passes() {
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        for case in 0..300 {
            let mobilities: Vec<f32> = (0..12).map(|_| 1.0 + 7.0 * random()).collect();
            let velocities: Vec<Quad> =
                (0..12).map(|_| [random() - 0.5, -random(), random() - 0.5, 0.0]).collect();
            let mut solver = Solver::new(12);
            for contact in 0..10 {
                let (a, b, share) = (contact, 1 + (7.0 * random()) as u32 + contact % 4, random());
                solver.link([(a, share), (b, 1.0 - share)].into_iter(), &mobilities);
                let mut velocity = [0.0; 4];
                add(&mut velocity, &velocities[a as usize], share);
                add(&mut velocity, &velocities[b as usize], 1.0 - share);
                // As fast as it came, which is as it would go on.
                let friction = if case % 2 == 0 { 0.0 } else { random() };
                let came = [velocity[0], 0.0, velocity[2], 0.0];
                solver.add(Contact { friction, came, ..up(-velocity[1], velocity) });
            }
            solver.solve(Effort { passes: 1 + case % 8, share: 0.0, least: 0.0 });
            let work: f32 = (0..10)
                .map(|contact| {
                    let (mut velocity, impulse) = outcome(&solver, contact);
                    add(&mut velocity, &solver.exchanges[contact].contact.velocity, 1.0);
                    dot(&velocity, &impulse)
                })
                .sum();
            assert!(work < 1e-5, "case {case}: {work}");
        }
    }
}
