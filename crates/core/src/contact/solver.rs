//! The contact problem of a body or an island: its constraints, and their impulses, which `jacobi` computes.
//!
//! A contact s has a normal n_s, a target velocity target_s, a friction coefficient mu_s, and a contact
//! point, which is a mean of lattice vertices k with the weights w_sk. Vertex k has the mass m_k and the
//! velocity v_k relative to the collider. The impulse p_s is the sum of a normal impulse l_s n_s and a
//! friction impulse f_s.
//!
//! ```text
//! contact s:   velocity u_s = sum_k w_sk v_k        impulse p_s = l_s n_s + f_s
//! vertex k:    change of v_k = sum_s w_sk p_s / m_k
//! conditions:  l_s >= 0  and  n_s . u_s >= target_s,  at least one of the two with equality
//!              |f_s| <= mu_s l_s  and  f_s opposes the slip  (Coulomb friction cone)
//! ```
//!
//! A *row* is the number of a vertex in the problem, as the caller counts them, and the index of a vertex is its index
//! in `Solver::rows`. A contact of a rigid body has a link to the body in place of vertices: see `rigid`. A push-out uses the same solver with
//! displacements in place of velocities.

use super::constraint::{Contact, ContactConstraint};
use super::memory::buffer_bytes;
use super::rigid::RigidMembers;
use super::vec4::{Vec4, dot};
use crate::sparse_set::SparseSet;
use crate::state::Twist;

/// Link between a contact and one of its vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    /// Index of the vertex in `Solver::rows`.
    pub(super) vertex: u32,
    /// Weight of the vertex in the contact point.
    pub(super) weight: f32,
    /// Velocity change of the vertex per unit of impulse: the weight over the mass.
    pub(super) response: f32,
}

/// Factors that convert a problem to other units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Units {
    /// Factor of velocities.
    pub(super) velocity: f32,
    /// Factor of inverse masses.
    pub(super) mobility: f32,
}

/// Contact problem of one body, or of several bodies that touch each other, at one time. Its buffers are reused, and
/// grow if there are more contacts than before.
#[derive(Clone, Debug, Default)]
pub(super) struct Solver {
    pub(super) constraints: Vec<ContactConstraint>,
    /// Links of all constraints.
    pub(super) links: Vec<Link>,
    /// Rows of the vertices that have a link.
    rows: SparseSet,
    /// Velocity change of each vertex in `rows`.
    pub(super) changes: Vec<Vec4>,
    /// Scratch for each vertex in `rows`: velocity change by one pass, or sum of responses.
    pub(super) sums: Vec<Vec4>,
    pub(super) rigid: RigidMembers,
}

impl Solver {
    /// Creates the solver for vertices with rows in `0..rows`.
    pub(super) fn new(rows: usize) -> Self {
        Self { rows: SparseSet::new(rows), ..Self::default() }
    }

    /// Returns the memory of the buffers in bytes.
    pub(super) fn bytes(&self) -> usize {
        let contacts = buffer_bytes(&self.constraints) + buffer_bytes(&self.links);
        let changes = buffer_bytes(&self.changes) + buffer_bytes(&self.sums);
        contacts + self.rows.bytes() + changes + self.rigid.bytes()
    }

    /// Removes all contacts.
    pub(super) fn clear(&mut self) {
        self.constraints.clear();
        self.links.clear();
        self.rows.clear();
        self.changes.clear();
        self.sums.clear();
        self.rigid.clear();
    }

    /// Changes the possible rows to `0..rows`. The problem has to be empty.
    pub(super) fn resize(&mut self, rows: usize) {
        self.rows.resize(rows);
    }

    /// Returns the number of contacts.
    pub(super) fn len(&self) -> usize {
        self.constraints.len()
    }

    /// Adds the contacts of another problem, without its impulses. `row` returns the row of a row of the other problem,
    /// and `units` converts to the units of this problem.
    /// `rigid`: the index in this problem of the rigid body of the other one, if it has one.
    pub(super) fn append(
        &mut self,
        other: &Self,
        row: impl Fn(u32) -> u32,
        units: Units,
        rigid: Option<u32>,
    ) {
        for (index, ContactConstraint { contact, links, .. }) in other.constraints.iter().enumerate() {
            let links = other.links[links.clone()].iter();
            let vertices = links.map(|&Link { vertex, weight, response }| {
                let row = row(other.rows.list()[vertex as usize]);
                (row, weight, response / weight * units.mobility)
            });
            self.add(contact.scaled(units.velocity), vertices);
            if let Some(rigid) = rigid {
                self.rigid.append(self.len() - 1, &other.rigid, index, rigid, units.velocity);
            }
        }
    }

    /// Adds a contact. `vertices`: the contact point as a mean of vertices: row, weight, and inverse mass. If the
    /// contact is one between two points, its velocity is the difference of theirs, and the weights of the second one
    /// are negative.
    pub(super) fn add(&mut self, contact: Contact, vertices: impl Iterator<Item = (u32, f32, f32)>) {
        let start = self.links.len();
        for (row, weight, mobility) in vertices {
            let (vertex, response) = (self.rows.index_or_insert(row), weight * mobility);
            self.links.push(Link { vertex, weight, response });
        }
        self.changes.resize(self.rows.list().len(), Vec4::zeros());
        self.sums.resize(self.rows.list().len(), Vec4::zeros());
        self.constraints.push(ContactConstraint::new(contact, start..self.links.len()));
    }

    /// Sets the initial impulses of [`solve`](Self::solve): the impulses of the step before, one for each contact,
    /// without the parts that no contact can have. Contacts that were faster than `slow` before the step begin without
    /// an impulse: the impulse of an impact differs from step to step, and would add energy.
    pub(super) fn begin_with(&mut self, impulses: &[Vec4], slow: f32) {
        self.rigid.complete(self.constraints.len());
        self.rigid.begin_pass();
        for (index, impulse) in impulses.iter().enumerate().take(self.constraints.len()) {
            let Contact { slip_before, approach, .. } = &self.constraints[index].contact;
            let is_fast = dot(slip_before, slip_before) + approach.max(0.0).powi(2) >= slow * slow;
            if is_fast || !impulse.iter().all(|x| x.is_finite()) {
                continue;
            }
            self.constraints[index].set_impulse(impulse);
            self.add_changes(index);
        }
        self.rigid.end_pass();
    }

    /// Returns the row and the velocity change of each vertex that has a link.
    pub(super) fn changes(&self) -> impl Iterator<Item = (u32, &Vec4)> {
        self.rows.list().iter().copied().zip(&self.changes)
    }

    /// As [`changes`](Self::changes), in increasing order of the rows.
    pub(super) fn changes_by_row(&self) -> impl Iterator<Item = (u32, Vec4)> {
        self.rows.increasing().map(|(row, index)| (row, self.changes[index as usize]))
    }

    /// Returns the row of each vertex that has a link, and its velocity change by the normal impulses alone.
    pub(super) fn normal_changes(&mut self) -> impl Iterator<Item = (u32, &Vec4)> {
        self.sums.fill(Vec4::zeros());
        for ContactConstraint { contact, links, normal_impulse, .. } in &self.constraints {
            for link in &self.links[links.clone()] {
                self.sums[link.vertex as usize] += contact.normal * (normal_impulse * link.response);
            }
        }
        self.rows.list().iter().copied().zip(&self.sums)
    }

    /// Returns each contact and the change of its normal velocity.
    pub(super) fn contacts(&self) -> impl Iterator<Item = (&Contact, f32)> {
        self.constraints.iter().enumerate().map(|(index, constraint)| {
            let change = self.change_of(index, constraint);
            (&constraint.contact, dot(&change, &constraint.contact.normal))
        })
    }

    /// Returns the least change of the normal velocity of a vertex of each contact.
    pub(super) fn least_changes(&self) -> impl Iterator<Item = f32> {
        self.constraints.iter().map(|constraint| {
            let links = self.links[constraint.links.clone()].iter();
            let changes =
                links.map(|link| dot(&self.changes[link.vertex as usize], &constraint.contact.normal));
            changes.fold(f32::INFINITY, f32::min)
        })
    }

    /// Returns the normal impulse and the friction impulse of each contact.
    pub(super) fn impulses(&self) -> impl Iterator<Item = (f32, Vec4)> {
        self.constraints.iter().map(|constraint| (constraint.normal_impulse, constraint.friction_impulse))
    }

    /// Takes the impulses from a problem to which these contacts were [appended](Self::append) with `units`,
    /// and the velocity changes by those that these impulses cause.
    pub(super) fn set_impulses(&mut self, impulses: &[(f32, Vec4)], units: Units) {
        let scale = units.mobility / units.velocity;
        self.changes.fill(Vec4::zeros());
        self.rigid.complete(self.constraints.len());
        self.rigid.scale_changes(0.0);
        self.rigid.begin_pass();
        for (index, (normal, friction)) in impulses.iter().enumerate().take(self.constraints.len()) {
            let constraint = &mut self.constraints[index];
            constraint.normal_impulse = normal * scale;
            constraint.friction_impulse = friction * scale;
            self.add_changes(index);
        }
        self.rigid.end_pass();
    }

    /// Adds the velocity changes by the impulse of a constraint; those of rigid bodies count from the end of the pass.
    fn add_changes(&mut self, index: usize) {
        let constraint = &self.constraints[index];
        let impulse = constraint.impulse();
        for link in &self.links[constraint.links.clone()] {
            self.changes[link.vertex as usize] += impulse * link.response;
        }
        if !self.rigid.is_empty() {
            self.rigid.add_impulse(index, &impulse);
        }
    }

    /// Begins another problem with the same contact points: without impulses, and with the contacts that `contact`
    /// returns for the index of a constraint, its contact and the change of its velocity.
    pub(super) fn restart(&mut self, mut contact: impl FnMut(usize, &Contact, &Vec4) -> Contact) {
        for index in 0..self.constraints.len() {
            let constraint = &self.constraints[index];
            let contact = contact(index, &constraint.contact, &self.change_of(index, constraint));
            self.constraints[index] = ContactConstraint::new(contact, constraint.links.clone());
        }
        self.changes.fill(Vec4::zeros());
        self.rigid.scale_changes(0.0);
    }

    /// Returns the change of the velocity of a constraint.
    #[inline(always)]
    pub(super) fn change_of(&self, index: usize, constraint: &ContactConstraint) -> Vec4 {
        let change = mean(&self.links, constraint, &self.changes);
        if self.rigid.is_empty() { change } else { change + self.rigid.velocity(index) }
    }

    /// Returns the impulses on each rigid body in f64.
    pub(super) fn rigid_totals(&self, totals: &mut Vec<Twist>) {
        self.rigid.totals(self.constraints.iter().map(ContactConstraint::impulse), totals);
    }
}

/// Returns the weighted mean of `vectors` over the vertices of a constraint. `vectors`: one per vertex index.
#[inline(always)]
pub(super) fn mean(links: &[Link], constraint: &ContactConstraint, vectors: &[Vec4]) -> Vec4 {
    // Two independent sums, which the processor can compute in parallel.
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
    use super::super::jacobi::Tolerance;
    use super::*;

    const TOLERANCE: Tolerance = Tolerance { passes: 41, relative: 0.0, absolute: 1e-6 };
    const ONE_PASS: Tolerance = Tolerance { passes: 1, relative: 0.0, absolute: 0.0 };

    fn vector(x: f32, y: f32, z: f32) -> Vec4 {
        Vec4::new(x, y, z, 0.0)
    }

    fn up(target: f32, velocity: Vec4) -> Contact {
        Contact { normal: vector(0.0, 1.0, 0.0), velocity, target, approach: target, ..Contact::default() }
    }

    /// Returns the velocity of a contact after the solve, and its impulse.
    fn outcome(solver: &Solver, index: usize) -> (Vec4, Vec4) {
        let constraint = &solver.constraints[index];
        let change = mean(&solver.links, constraint, &solver.changes);
        (change + constraint.contact.velocity, constraint.impulse())
    }

    #[test]
    fn one_pass_is_exact_for_contacts_without_common_vertices() {
        let mobilities = [2.0, 1.0, 1.0, 1.0, 2.0];
        let falling = vector(0.0, -3.0, 0.0);
        let mut solver = Solver::new(5);
        // Contacts with common vertices: one pass is approximate, because the row sums differ.
        for row in 0..4 {
            solver.add(up(0.0, falling), [(row, 0.5, 1.0), (row + 1, 0.5, 1.0)].into_iter());
        }
        solver.solve(ONE_PASS);
        assert!(solver.changes().all(|(_, change)| (change.y - 3.0).abs() < 1.5));
        // One contact per vertex: one pass is exact for any masses.
        solver.clear();
        for row in 0..5 {
            solver.add(up(1.5, falling), std::iter::once((row, 1.0, mobilities[row as usize])));
        }
        solver.solve(ONE_PASS);
        assert!(solver.changes().all(|(_, change)| *change == vector(0.0, 4.5, 0.0)));
        assert!(solver.normal_changes().all(|(_, change)| *change == vector(0.0, 4.5, 0.0)));
    }

    #[test]
    fn contact_that_separates_faster_than_its_target_gets_no_impulse() {
        let mut solver = Solver::new(1);
        let contact = Contact { friction: 1.0, ..up(1.0, vector(5.0, 1.5, 0.0)) };
        solver.add(contact, std::iter::once((0, 1.0, 1.0)));
        solver.solve(TOLERANCE);
        assert!(solver.changes().all(|(_, change)| *change == Vec4::zeros()));
    }

    #[test]
    fn friction_stops_slip_inside_the_coulomb_cone_and_slows_it_outside() {
        for (friction, slip) in [(0.0, 3.0), (0.5, 2.0), (1.5, 0.0), (f32::MAX, 0.0)] {
            let mut solver = Solver::new(2);
            let contact = Contact { friction, ..up(0.0, vector(3.0, -2.0, 0.0)) };
            solver.add(contact, [(0, 0.5, 1.0), (1, 0.5, 1.0)].into_iter());
            solver.solve(TOLERANCE);
            let (velocity, _) = outcome(&solver, 0);
            assert!((velocity.x - slip).abs() < 1e-5 && velocity.y.abs() < 1e-5, "{friction}: {velocity:?}");
        }
    }

    #[test]
    fn solution_that_begins_with_the_impulses_of_the_solution_keeps_them() {
        let slow = 10.0;
        let problem = |solver: &mut Solver| {
            solver.clear();
            for row in 0..4 {
                let contact = Contact { friction: 0.3, ..up(0.0, vector(0.4, -1.0 - row as f32, 0.0)) };
                solver.add(contact, [(row, 0.7, 1.0), (row + 1, 0.3, 2.0)].into_iter());
            }
        };
        let mut solver = Solver::new(5);
        problem(&mut solver);
        solver.solve(TOLERANCE);
        let solution: Vec<Vec4> = solver.constraints.iter().map(ContactConstraint::impulse).collect();
        assert!(solution.iter().all(|impulse| impulse.norm() > 0.1), "{solution:?}");
        let difference = |solver: &Solver| {
            let impulses = solver.constraints.iter().map(ContactConstraint::impulse).zip(&solution);
            impulses.map(|(impulse, expected)| (impulse - expected).norm()).fold(0.0, f32::max)
        };
        // One pass finds the solution only from the solution.
        problem(&mut solver);
        solver.solve(ONE_PASS);
        assert!(difference(&solver) > 0.1);
        problem(&mut solver);
        solver.begin_with(&solution, slow);
        solver.solve(ONE_PASS);
        assert!(difference(&solver) < 1e-4, "{}", difference(&solver));
        // A contact that was fast before the step begins without an impulse.
        problem(&mut solver);
        solver.constraints[2].contact.approach = slow;
        solver.begin_with(&solution, slow);
        let begun: Vec<bool> = solver.constraints.iter().map(|c| c.impulse().norm() > 0.0).collect();
        assert_eq!(begun, [true, true, false, true]);
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
                let (a, b, weight) = (contact, 1 + (7.0 * random()) as u32 + contact % 4, random());
                let velocity = velocities[a as usize] * weight + velocities[b as usize] * (1.0 - weight);
                let friction = if case % 2 == 0 { 0.0 } else { random() };
                // The velocity before the step is the velocity without contact.
                let slip_before = vector(velocity.x, 0.0, velocity.z);
                let contact = Contact { friction, slip_before, ..up(-velocity.y, velocity) };
                let links = [(a, weight), (b, 1.0 - weight)];
                solver.add(contact, links.map(|(row, w)| (row, w, mobilities[row as usize])).into_iter());
            }
            solver.solve(Tolerance { passes: 1 + case % 8, ..ONE_PASS });
            let work: f32 = (0..10)
                .map(|contact| {
                    let (velocity, impulse) = outcome(&solver, contact);
                    dot(&(velocity + solver.constraints[contact].contact.velocity), &impulse)
                })
                .sum();
            assert!(work < 1e-5, "case {case}: work {work}");
        }
    }
}
