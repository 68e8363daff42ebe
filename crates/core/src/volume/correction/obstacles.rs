//! Limits the correction at obstacles: colliders, and other bodies that the body touches or that are near.

use super::evaluate::{Correction, lambda_of};
use super::workspace::CorrectionWorkspace;
use crate::contact::{SMOOTH_DISPLACEMENT, SampleCells};
use crate::parallel::Executor;
use crate::volume::clearance::{FindLimits, Obstacles};
use crate::volume::limits::Limit;
use crate::volume::line::Moving;

/// Maximum number of passes of the active-set iteration in [`Correction::solve_with_limits`]. Three to five
/// passes are common. The reported residual is the volume error after the last pass.
const LIMITED_PASSES: usize = 8;

/// Maximum number of rounds of [`Correction::limit_at_obstacles`]. Each round finds limits and solves again.
///
/// A further round is needed if vertices move farther than the search distance, or if the corrected surface
/// still enters a collider other than a plane, or with a smooth skin any collider. One or two rounds are common.
const ROUNDS: usize = 16;

/// Search distance for limits, as a multiple of the greatest displacement. The margin avoids a second search
/// if the displacements grow in a later round.
const MARGIN: f64 = 1.25;

impl Correction {
    /// Returns the greatest displacement of a vertex, in cells.
    fn greatest_displacement(&self, workspace: &CorrectionWorkspace) -> f64 {
        let lambda = lambda_of(&workspace.lambdas, &self.adjacency);
        let length = |(i, point): (usize, &Moving)| {
            let (lambda, offset) = (lambda(i as u32), workspace.offset(i).unwrap_or_default());
            let displacement = point.direction().into_iter().zip(offset);
            displacement.map(|(v, o)| (lambda * f64::from(v) + f64::from(o)).powi(2)).sum::<f64>().sqrt()
        };
        workspace.scratch.points.iter().enumerate().map(length).fold(0.0, f64::max)
    }

    /// Limits the displacements and solves again, until the correction moves no surface sample into a
    /// collider, or [`ROUNDS`] times. [Soft](Limit::is_soft) limits are left out for components whose volume is
    /// restored without limits, and not with them. `samples` is absent if there is no collider, and `find_at_bodies`
    /// finds the limits at other bodies.
    ///
    /// Must be called after [`Correction::solve`], with the same `deformed`. `corrected` is scratch.
    pub(crate) fn limit_at_obstacles(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        (samples, obstacles): (Option<&SampleCells>, &Obstacles<'_>),
        find_at_bodies: &mut FindLimits<'_>,
        deformed: &[[f32; 3]],
        corrected: &mut [[f32; 3]],
    ) {
        // Taken out of the workspace, so that `solve_with_limits` can borrow the workspace and the limits.
        let mut search = std::mem::take(&mut workspace.limit_search);
        search.begin(&workspace.reports);
        let mut has_removed_soft = false;
        let mut search_distance = 0.0;
        let entered_cells = samples.filter(|samples| obstacles.need_entered_cells(samples));
        let is_smooth = samples.is_some_and(|samples| samples.stencils().is_some());
        let factor = if is_smooth { SMOOTH_DISPLACEMENT } else { 1.0 };
        for _ in 0..ROUNDS {
            let greatest = factor * self.greatest_displacement(workspace);
            let has_new_limits = if greatest > search_distance {
                search_distance = MARGIN * greatest;
                search.replace(samples, deformed, obstacles, search_distance, find_at_bodies);
                !search.limits.is_empty()
            } else if let Some(samples) = entered_cells.filter(|_| search_distance > 0.0) {
                self.write(workspace, deformed, corrected);
                search.add_limits_for_entered_cells(samples, corrected, obstacles)
            } else {
                false
            };
            let mut are_fewer = false;
            if !has_new_limits || has_removed_soft {
                if !has_removed_soft {
                    search.keep_unsolved(&workspace.reports);
                }
                are_fewer = search.remove_soft(|vertex| self.adjacency.component(vertex as usize));
                has_removed_soft = true;
            }
            if !has_new_limits && !are_fewer {
                break;
            }
            self.solve_with_limits(workspace, executor, (&search.limits, are_fewer));
        }
        workspace.limit_search = search;
    }

    /// Solves again with limits, by an active-set iteration.
    ///
    /// A vertex at its limit slides along the obstacle or stops, and the other vertices restore the volume.
    /// In each pass all vertices move along straight lines, so that the volume remains an exact cubic. `are_fewer`:
    /// whether limits were left out, so that vertices move farther.
    fn solve_with_limits(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        (limits, are_fewer): (&[Limit], bool),
    ) {
        let CorrectionWorkspace { limits: active_set, scratch, offsets, has_surface, .. } = &mut *workspace;
        // The points of vertices that neither slide nor stop do not change.
        *has_surface &= !active_set.is_any_limited();
        active_set.replace(limits, &mut scratch.points, offsets);
        for pass in 0..LIMITED_PASSES {
            let has_changed = self.update_motions(workspace) || (are_fewer && pass == 0);
            if !has_changed {
                return;
            }
            self.solve_cubics(workspace, executor);
        }
        self.update_motions(workspace);
        self.report_residuals(workspace, executor);
    }

    /// Updates the motions of the limited vertices for the current `lambda`. Returns whether any motion has
    /// changed.
    fn update_motions(&self, workspace: &mut CorrectionWorkspace) -> bool {
        let CorrectionWorkspace { limits, lambdas, scratch, .. } = workspace;
        limits.update_motions(lambda_of(lambdas, &self.adjacency), &mut scratch.points)
    }

    /// Reports the volume error for the current `lambda`, without solving again.
    fn report_residuals(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
        self.evaluate(workspace, executor);
        for component in 0..self.rest.len() {
            let [c0, c1, c2, c3] = workspace.scratch.coefficients[component];
            let lambda = workspace.lambdas[component];
            let volume = c0 + lambda * (c1 + lambda * (c2 + lambda * c3));
            self.report(workspace, component, volume - workspace.rest[component]);
        }
    }
}
