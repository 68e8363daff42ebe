//! The contact solver: the impulses of all contacts of a body together, by projected Jacobi iteration.
//!
//! ```text
//! contact s:   velocity u_s = sum_k w_sk v_k        impulse p_s = l_s n_s + f_s
//! vertex k:    change of v_k = sum_s w_sk p_s / m_k
//! wanted:      l_s >= 0,  n_s . u_s >= target_s,  one of the two with equality;  |f_s| <= friction l_s, against the slip
//! ```
//!
//! All contacts act at once (Jacobi), so that a symmetric body stays symmetric. Each takes its impulse as if all contacts
//! that share its vertices took the same: the diagonal of the matrix is replaced by its row sums. The impulses of a surface
//! that hits evenly are then exact after one pass. The matrix over its row sums has eigenvalues e in [0, 1], and a pass
//! leaves the share 1 - e of the error. After the first pass every other one is over-relaxed by 2: two passes leave
//! (1 - 2e)(1 - e), four the square of that, which is not negative: impulses approach the solution and hardly exceed it.
//! Where contacts that separate or slip exceed it all the same, all impulses are scaled down until they add no energy.

use super::constraint::{Contact, ContactConstraint};
use super::rows::{RowSet, held};
use super::vec4::{Vec4, dot};

/// When to stop: after `passes`, or when a pass changes no contact's velocity by more than `absolute`, or by more than
/// `relative` times the change of the first pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance {
    /// One, and a multiple of four.
    pub(super) passes: usize,
    pub(super) relative: f32,
    pub(super) absolute: f32,
}

/// A vertex under a contact.
#[derive(Clone, Copy, Debug)]
struct Link {
    /// Number of the vertex among those under any contact.
    vertex: u32,
    weight: f32,
    /// Velocity of the vertex for a unit of impulse: the weight over the mass.
    response: f32,
}

/// The contacts of one body at one time. Its buffers grow with the largest number of contacts and are kept.
#[derive(Clone, Debug, Default)]
pub(super) struct Solver {
    constraints: Vec<ContactConstraint>,
    /// Links of all constraints.
    links: Vec<Link>,
    /// Rows of the vertices under contacts.
    rows: RowSet,
    /// The velocity change of each vertex, and what one pass adds to it.
    changes: Vec<Vec4>,
    sums: Vec<Vec4>,
}

impl Solver {
    /// For vertices in `rows` rows.
    pub(super) fn new(rows: usize) -> Self {
        Self { rows: RowSet::new(rows), ..Self::default() }
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let contacts = held(&self.constraints) + held(&self.links);
        contacts + self.rows.bytes() + held(&self.changes) + held(&self.sums)
    }

    /// Removes all contacts.
    pub(super) fn clear(&mut self) {
        self.constraints.clear();
        self.links.clear();
        self.rows.clear();
        self.changes.clear();
        self.sums.clear();
    }

    /// Adds a contact of the mean of vertices, given as rows and weights; `mobilities` has 1/mass of each row.
    pub(super) fn add(
        &mut self,
        contact: Contact,
        vertices: impl Iterator<Item = (u32, f32)>,
        mobilities: &[f32],
    ) {
        let start = self.links.len();
        for (row, weight) in vertices {
            let (vertex, response) = (self.rows.number(row), weight * mobilities[row as usize]);
            self.links.push(Link { vertex, weight, response });
        }
        self.changes.resize(self.rows.list().len(), Vec4::zeros());
        self.sums.resize(self.rows.list().len(), Vec4::zeros());
        self.constraints.push(ContactConstraint::new(contact, start..self.links.len()));
    }

    /// Finds the impulses.
    pub(super) fn solve(&mut self, tolerance: Tolerance) {
        self.find_responses();
        let mut enough = tolerance.absolute;
        for pass in 0..tolerance.passes {
            let change = self.pass(if pass % 2 == 1 { 2.0 } else { 1.0 });
            if pass == 0 {
                enough = enough.max(tolerance.relative * change);
            }
            if change <= enough {
                break;
            }
        }
        self.limit_energy();
    }

    /// Scales all impulses down if together they add energy. Twice the work of an impulse is its product with the sum of
    /// the contact's velocities before, at most, and after; the part of it that the impulses cause grows with them.
    fn limit_energy(&mut self) {
        let (mut allowed, mut caused) = (0.0, 0.0);
        for constraint in &self.constraints {
            let Contact { normal, velocity, slip_before, limit, .. } = &constraint.contact;
            let impulse = constraint.impulse();
            allowed += dot(&impulse, normal) * limit - dot(&impulse, velocity) - dot(&impulse, slip_before);
            caused += dot(&impulse, &mean(&self.links, constraint, &self.changes));
        }
        if caused > allowed {
            let scale = (allowed / caused).max(0.0);
            for change in &mut self.changes {
                *change *= scale;
            }
            for constraint in &mut self.constraints {
                constraint.normal_impulse *= scale;
                constraint.friction_impulse *= scale;
            }
        }
    }

    /// Rows and velocity changes of the vertices under contacts.
    pub(super) fn changes(&self) -> impl Iterator<Item = (u32, &Vec4)> {
        self.rows.list().iter().copied().zip(&self.changes)
    }

    /// Rows and velocity changes by the normal impulses alone.
    pub(super) fn normal_changes(&mut self) -> impl Iterator<Item = (u32, &Vec4)> {
        self.sums.fill(Vec4::zeros());
        for ContactConstraint { contact, links, normal_impulse, .. } in &self.constraints {
            for link in &self.links[links.clone()] {
                self.sums[link.vertex as usize] += contact.normal * (normal_impulse * link.response);
            }
        }
        self.rows.list().iter().copied().zip(&self.sums)
    }

    /// Contacts, and the change of the normal velocity of each.
    pub(super) fn contacts(&self) -> impl Iterator<Item = (&Contact, f32)> {
        self.constraints.iter().map(|constraint| {
            let change = mean(&self.links, constraint, &self.changes);
            (&constraint.contact, dot(&change, &constraint.contact.normal))
        })
    }

    /// The response of each constraint: its velocity if all constraints had a unit of impulse along one direction.
    fn find_responses(&mut self) {
        let Self { constraints, links, sums, .. } = self;
        sums.fill(Vec4::zeros());
        for link in &*links {
            sums[link.vertex as usize][0] += link.response;
        }
        for constraint in constraints {
            let links = links[constraint.links.clone()].iter();
            constraint.set_response(links.map(|link| link.weight * sums[link.vertex as usize][0]).sum());
        }
    }

    /// One pass; the greatest change of a contact's velocity.
    ///
    /// The sums of the impulses of all passes are clamped, so that a later pass may take back some of an earlier one.
    fn pass(&mut self, over_relaxation: f32) -> f32 {
        let Self { constraints, links, changes, sums, .. } = self;
        sums.fill(Vec4::zeros());
        let mut greatest = 0.0_f32;
        for constraint in constraints {
            let velocity = mean(links, constraint, changes) + constraint.contact.velocity;
            let change = constraint.correct(&velocity, over_relaxation);
            greatest = greatest.max(constraint.speed(&change));
            for link in &links[constraint.links.clone()] {
                sums[link.vertex as usize] += change * link.response;
            }
        }
        for (change, sum) in changes.iter_mut().zip(&*sums) {
            *change += sum;
        }
        greatest
    }
}

/// The weighted mean of `vectors` over the vertices of a constraint.
#[inline(always)]
fn mean(links: &[Link], constraint: &ContactConstraint, vectors: &[Vec4]) -> Vec4 {
    // Two sums, which do not wait for each other.
    let (mut even, mut odd) = (Vec4::zeros(), Vec4::zeros());
    let (pairs, last) = links[constraint.links.clone()].as_chunks::<2>();
    for [a, b] in pairs {
        even += vectors[a.vertex as usize] * a.weight;
        odd += vectors[b.vertex as usize] * b.weight;
    }
    for link in last {
        even += vectors[link.vertex as usize] * link.weight;
    }
    even + odd
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOLERANCE: Tolerance = Tolerance { passes: 41, relative: 0.0, absolute: 1e-6 };
    const ONE_PASS: Tolerance = Tolerance { passes: 1, relative: 0.0, absolute: 0.0 };

    fn vector(x: f32, y: f32, z: f32) -> Vec4 {
        Vec4::new(x, y, z, 0.0)
    }

    fn up(target: f32, velocity: Vec4) -> Contact {
        Contact { normal: vector(0.0, 1.0, 0.0), velocity, target, limit: target, ..Contact::default() }
    }

    /// A contact's velocity afterwards, and its impulse.
    fn outcome(solver: &Solver, index: usize) -> (Vec4, Vec4) {
        let constraint = &solver.constraints[index];
        let change = mean(&solver.links, constraint, &solver.changes);
        (change + constraint.contact.velocity, constraint.impulse())
    }

    #[test]
    fn even_impact_is_solved_in_one_pass() {
        let mobilities = [2.0, 1.0, 1.0, 1.0, 2.0];
        let falling = vector(0.0, -3.0, 0.0);
        let mut solver = Solver::new(5);
        for row in 0..4 {
            solver.add(up(0.0, falling), [(row, 0.5), (row + 1, 0.5)].into_iter(), &[1.0; 5]);
        }
        solver.solve(ONE_PASS);
        assert!(solver.changes().all(|(_, change)| (change.y - 3.0).abs() < 1.5));
        // Each vertex its own contact: whatever the masses.
        solver.clear();
        for row in 0..5 {
            solver.add(up(1.5, falling), std::iter::once((row, 1.0)), &mobilities);
        }
        solver.solve(ONE_PASS);
        assert!(solver.changes().all(|(_, change)| *change == vector(0.0, 4.5, 0.0)));
        assert!(solver.normal_changes().all(|(_, change)| *change == vector(0.0, 4.5, 0.0)));
    }

    #[test]
    fn contact_that_separates_faster_than_its_target_gets_no_impulse() {
        let mut solver = Solver::new(1);
        let contact = Contact { friction: 1.0, ..up(1.0, vector(5.0, 1.5, 0.0)) };
        solver.add(contact, std::iter::once((0, 1.0)), &[1.0]);
        solver.solve(TOLERANCE);
        assert!(solver.changes().all(|(_, change)| *change == Vec4::zeros()));
    }

    #[test]
    fn friction_stops_within_its_cone_and_slows_outside_it() {
        for (friction, slip) in [(0.0, 3.0), (0.5, 2.0), (1.5, 0.0), (f32::MAX, 0.0)] {
            let mut solver = Solver::new(2);
            let contact = Contact { friction, ..up(0.0, vector(3.0, -2.0, 0.0)) };
            solver.add(contact, [(0, 0.5), (1, 0.5)].into_iter(), &[1.0, 1.0]);
            solver.solve(TOLERANCE);
            let (velocity, _) = outcome(&solver, 0);
            assert!((velocity.x - slip).abs() < 1e-5 && velocity.y.abs() < 1e-5, "{friction}: {velocity:?}");
        }
    }

    #[test]
    fn impulses_add_no_energy_after_any_number_of_passes() {
        let mut seed = 1_u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        for case in 0..300 {
            let mobilities: Vec<f32> = (0..12).map(|_| 1.0 + 7.0 * random()).collect();
            let velocities: Vec<Vec4> =
                (0..12).map(|_| vector(random() - 0.5, -random(), random() - 0.5)).collect();
            let mut solver = Solver::new(12);
            for contact in 0..10 {
                let (a, b, share) = (contact, 1 + (7.0 * random()) as u32 + contact % 4, random());
                let velocity = velocities[a as usize] * share + velocities[b as usize] * (1.0 - share);
                let friction = if case % 2 == 0 { 0.0 } else { random() };
                // The velocity before the step is the velocity without contact.
                let slip_before = vector(velocity.x, 0.0, velocity.z);
                let contact = Contact { friction, slip_before, ..up(-velocity.y, velocity) };
                solver.add(contact, [(a, share), (b, 1.0 - share)].into_iter(), &mobilities);
            }
            solver.solve(Tolerance { passes: 1 + case % 8, ..ONE_PASS });
            let work: f32 = (0..10)
                .map(|contact| {
                    let (velocity, impulse) = outcome(&solver, contact);
                    dot(&(velocity + solver.constraints[contact].contact.velocity), &impulse)
                })
                .sum();
            assert!(work < 1e-5, "case {case}: {work}");
        }
    }
}
