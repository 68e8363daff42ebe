//! Solves for the volume within limits of the displacements.

use nalgebra::Vector3;

use super::evaluate::Correction;
use super::workspace::{CorrectionWorkspace, LimitedVertex};
use crate::parallel::Executor;
use crate::simd::vector::wide;
use crate::volume::limits::{Limits, Motion, project};

/// Maximum number of passes of the active-set iteration in [`Correction::solve_within`]. Three to five
/// passes are common. The reported residual is the volume error after the last pass.
const PASSES: usize = 8;

impl Correction {
    /// Solves again within limits, by an active-set iteration. Without any limit the solution stays as it is.
    ///
    /// A vertex at its limits slides along an obstacle, or between two of them, or stops, and the other vertices restore
    /// the volume. In each pass all vertices move along straight lines, so that the volume remains an exact cubic.
    ///
    /// Must be called after [`Correction::solve`].
    pub(crate) fn solve_within(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        limits: &Limits,
    ) {
        let CorrectionWorkspace { limited, scratch, .. } = &mut *workspace;
        // Without the limits before, vertices may move farther.
        let mut has_changed = limited.iter().any(|limited| limited.motion != Motion::Free);
        for LimitedVertex { vertex, free, .. } in limited.drain(..) {
            scratch.points[vertex as usize] = free;
        }
        limited.extend(limits.by_vertex().map(|limits| {
            let (vertex, motion) = (limits[0].vertex, Motion::Free);
            let free = scratch.points[vertex as usize];
            LimitedVertex { vertex, free, motion, displacement: Vector3::zeros() }
        }));
        for _ in 0..PASSES {
            has_changed |= self.update_motions(workspace, limits);
            if !has_changed {
                return;
            }
            self.solve_cubics(workspace, executor);
            has_changed = false;
        }
        self.update_motions(workspace, limits);
        self.report_residuals(workspace, executor);
    }

    /// Removes the [soft](crate::volume::Limit::is_soft) limits of the components whose volume is restored without
    /// limits, and not with them. Returns whether there were any.
    pub(crate) fn remove_soft(&self, workspace: &CorrectionWorkspace, limits: &mut Limits) -> bool {
        let limits = limits.list_mut();
        let count = limits.len();
        limits.retain(|limit| {
            let component = self.adjacency.component(limit.vertex as usize);
            !(limit.is_soft && workspace.restored[component] && workspace.reports[component].capped)
        });
        limits.len() < count
    }

    /// Updates the motions of the limited vertices, and their points, for the current `lambda`. Returns
    /// whether any motion has changed.
    fn update_motions(&self, workspace: &mut CorrectionWorkspace, limits: &Limits) -> bool {
        let CorrectionWorkspace { limited, lambdas, scratch, offsets, .. } = workspace;
        let mut has_changed = false;
        for (limited, limits) in limited.iter_mut().zip(limits.by_vertex()) {
            let (index, free) = (limited.vertex as usize, limited.free);
            let lambda = lambdas[self.adjacency.component(index)];
            let (offset, along) = (offsets.get(index).copied().unwrap_or_default(), wide(free.direction()));
            let (displacement, motion) = project(limits, Vector3::zeros(), wide(offset) + along * lambda);
            has_changed |=
                motion != limited.motion || motion == Motion::Stopped && displacement != limited.displacement;
            (limited.motion, limited.displacement) = (motion, displacement);
            let direction = match motion {
                Motion::Free => along,
                Motion::Sliding(normal) => along - normal * normal.dot(&along),
                Motion::Along(axis) => axis * axis.dot(&along),
                Motion::Stopped => Vector3::zeros(),
            };
            // The point reaches the displacement at the current `lambda`.
            let position = wide(free.position()) - wide(offset) + displacement - direction * lambda;
            let point = &mut scratch.points[index];
            point.set_position(position.map(|x| x as f32).into());
            point.set_direction(direction.map(|x| x as f32).into());
        }
        has_changed
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
