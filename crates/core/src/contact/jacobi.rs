//! Computes the impulses of a contact problem by projected Jacobi iteration. The symbols are those of `solver`.
//!
//! A pass updates all contacts at the same time (Jacobi), so that a symmetric body stays symmetric. Let A_st
//! be the velocity change of contact s by a unit impulse at contact t. Each contact s computes its impulse as
//! if all contacts that share a vertex with it had the same impulse: it uses the sum of row s of the matrix A
//! in place of the diagonal entry A_ss. If all contacts hit a collider at the same velocity and the row sums
//! are equal, the impulses are therefore exact after one pass.
//!
//! The matrix A with each row divided by its sum has eigenvalues e in [0, 1], and a pass leaves the fraction
//! 1 - e of the error. Starting with the second pass, every other pass has an over-relaxation of 2. Two
//! passes then leave the fraction (1 - 2e)(1 - e). Four passes leave the square of this fraction, which is
//! not negative. The impulses therefore approach the solution and hardly exceed it. If contacts that separate
//! or slip make the impulses exceed the solution, `limit_energy` scales all impulses down until they add no
//! energy.

use super::constraint::Contact;
use super::solver::{Solver, mean};
use super::vec4::{Vec4, dot};

/// Stopping criterion of the solver.
///
/// The iteration stops after `passes` passes, or after a pass in which no velocity of a contact changes by
/// more than the threshold. The threshold is the greater of `absolute`, and `relative` times the greatest
/// change by the impulses with which the iteration begins, or in the first pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerance {
    /// Maximum number of passes: 1 plus a multiple of 4, so that the remaining fraction of the error is not
    /// negative.
    pub(super) passes: usize,
    /// Threshold as a fraction of the greatest change at the beginning.
    pub(super) relative: f32,
    /// Threshold in the unit of the solved quantity.
    pub(super) absolute: f32,
}

impl Tolerance {
    /// For impulses. Each solution begins with the impulses of the step before, so that impulses of bodies at rest
    /// become more exact from step to step, with few passes in each. An impact takes more passes.
    pub(super) const IMPACT: Self = Self { passes: 13, relative: 1e-4, absolute: 0.0 };

    /// For displacements in cells.
    pub(super) const PUSH: Self = Self { passes: 9, relative: 0.0, absolute: 1e-5 };

    /// Returns the criterion of a problem with rigid bodies. All contacts of a rigid body change each other, so that the
    /// passes converge more slowly.
    fn with_rigid_bodies(self) -> Self {
        Self { passes: 1 + 4 * (self.passes - 1), ..self }
    }
}

impl Solver {
    /// Computes the impulses.
    pub(super) fn solve(&mut self, tolerance: Tolerance) {
        if self.rigid.is_empty() {
            self.solve_with::<false>(tolerance);
        } else {
            self.solve_with::<true>(tolerance.with_rigid_bodies());
        }
    }

    /// Computes the impulses. `RIGID`: whether the problem has rigid bodies; without, their code is left out.
    fn solve_with<const RIGID: bool>(&mut self, tolerance: Tolerance) {
        self.find_responses::<RIGID>();
        let begun = self.constraints.iter().map(|constraint| constraint.speed_change(&constraint.impulse()));
        let begun = begun.fold(0.0, f32::max);
        let mut threshold = tolerance.absolute;
        for pass in 0..tolerance.passes {
            let change = self.pass::<RIGID>(if pass % 2 == 1 { 2.0 } else { 1.0 });
            if pass == 0 {
                threshold = threshold.max(tolerance.relative * change.max(begun));
            }
            if change <= threshold {
                break;
            }
        }
        self.limit_energy();
    }

    /// Scales all impulses down if their total work is positive.
    ///
    /// Twice the work of an impulse p is `p . (before + after)`. The velocity `before` is taken as
    /// `slip_before - limit * normal`. The velocity `after` is `velocity + change`, where `change` is the
    /// velocity change by all impulses. The total work is not positive if the sum `caused` of `p . change`
    /// over all contacts is at most the sum `allowed` of `p . (limit * normal - velocity - slip_before)`. If
    /// all impulses are scaled by s, `caused` is scaled by s^2 and `allowed` by s.
    fn limit_energy(&mut self) {
        let (mut allowed, mut caused) = (0.0, 0.0);
        for (index, constraint) in self.constraints.iter().enumerate() {
            let Contact { normal, velocity, slip_before, .. } = &constraint.contact;
            let limit = constraint.contact.limit();
            let impulse = constraint.impulse();
            allowed += dot(&impulse, normal) * limit - dot(&impulse, velocity) - dot(&impulse, slip_before);
            caused += dot(&impulse, &self.change_of(index, constraint));
        }
        if caused > allowed {
            let scale = (allowed / caused).max(0.0);
            for change in &mut self.changes {
                *change *= scale;
            }
            self.rigid.scale_changes(scale);
            for constraint in &mut self.constraints {
                constraint.normal_impulse *= scale;
                constraint.friction_impulse *= scale;
            }
        }
    }

    /// Computes the response of each constraint: the velocity change of its contact point if every constraint
    /// had a unit impulse in the direction that moves its point most.
    fn find_responses<const RIGID: bool>(&mut self) {
        let Self { constraints, links, sums, rigid, .. } = self;
        if RIGID {
            rigid.complete(constraints.len());
            rigid.find_responses();
        }
        sums.fill(Vec4::zeros());
        for link in &*links {
            sums[link.vertex as usize][0] += link.response.abs();
        }
        for (index, constraint) in constraints.iter_mut().enumerate() {
            let links = links[constraint.links.clone()].iter();
            let response = links.map(|link| link.weight.abs() * sums[link.vertex as usize][0]).sum();
            constraint.set_response(if RIGID { response + rigid.response(index) } else { response });
        }
    }

    /// Runs one pass; returns the greatest change of a contact's velocity.
    ///
    /// The accumulated impulses are clamped and not their changes, so that a later pass can reduce the
    /// impulse of an earlier pass.
    fn pass<const RIGID: bool>(&mut self, over_relaxation: f32) -> f32 {
        let Self { constraints, links, changes, sums, rigid, .. } = self;
        sums.fill(Vec4::zeros());
        if RIGID {
            rigid.begin_pass();
        }
        let mut greatest = 0.0_f32;
        for (index, constraint) in constraints.iter_mut().enumerate() {
            let mut velocity = mean(links, constraint, changes) + constraint.contact.velocity;
            if RIGID {
                velocity += rigid.velocity(index);
            }
            let change = constraint.update_impulses(&velocity, over_relaxation);
            greatest = greatest.max(constraint.speed_change(&change));
            for link in &links[constraint.links.clone()] {
                sums[link.vertex as usize] += change * link.response;
            }
            if RIGID {
                rigid.add_impulse(index, &change);
            }
        }
        if RIGID {
            rigid.end_pass();
        }
        for (change, sum) in changes.iter_mut().zip(&*sums) {
            *change += sum;
        }
        greatest
    }
}
