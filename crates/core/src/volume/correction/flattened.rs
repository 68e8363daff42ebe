//! Restores the volume of a body whose displayed surface lies flat on colliders.

use super::{Correction, CorrectionWorkspace, VOLUME_TOLERANCE};
use crate::flatten::{Displacements, FlattenTable, FlattenedSurface};
use crate::lattice::Embedding;
use crate::parallel::Executor;
use crate::volume::ComponentReport;
use crate::volume::cubic::smallest_root;
use crate::volume::report::residual;

impl Correction {
    /// Makes the motions of the surface points available, if they are mesh vertices; see
    /// [`Correction::surface_motion`].
    pub(crate) fn update_surface(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
        if !workspace.has_surface && self.measure.as_mesh().is_some() {
            self.evaluate(workspace, executor);
            self.update_surface_motions(workspace);
        }
    }

    /// Moves the corrected lattice on along the field, so that the body with a flattened surface has its rest volume.
    /// Has no effect if the measure is not `mesh`.
    ///
    /// The displacements add volume, so that the lattice moves away from the colliders. The displaced mesh vertices
    /// stay on them: their displacements grow by the part of the motion that is held back. All motions are straight, so
    /// that the volume is an exact cubic.
    ///
    /// Must be called after [`Correction::update_surface`], with the results of the correction in `corrected` and
    /// `reports`.
    pub(crate) fn solve_flattened(
        &self,
        workspace: &mut CorrectionWorkspace,
        (table, embedding): (&FlattenTable, &Embedding),
        displacements: &mut Displacements,
        corrected: &mut [[f32; 3]],
        reports: &mut [ComponentReport],
    ) {
        let Some(measure) = self.measure.as_mesh() else { return };
        let mut steps = std::mem::take(&mut workspace.steps);
        let CorrectionWorkspace { rest, scratch, lambdas, flattened, .. } = &mut *workspace;
        let surface = FlattenedSurface { table, embedding, displacements };
        let changes = flattened.update(measure, scratch, surface, lambdas);
        steps.clear();
        steps.resize(self.rest.len(), 0.0);
        for &(component, change) in changes {
            let component = component as usize;
            // A sliver that broke off has no volume to preserve.
            let rest = rest[component];
            if rest == 0.0 {
                continue;
            }
            let lambda = lambdas[component];
            let volume = std::array::from_fn(|k| scratch.coefficients[component][k] + change[k]);
            let [c0, c1, c2, c3] = taylor(volume, lambda);
            // After untangling, `lambda` counts from the untangled positions, and the report from the deformed ones.
            let total = reports[component].lambda / self.cell_size;
            let limit = self.caps[component].max(total.abs());
            // A correction that its limits have ended does not go on.
            let has_ended = reports[component].capped && c0 < rest;
            let step = if has_ended {
                0.0
            } else {
                let root = smallest_root([c0 - rest, c1, c2, c3], 2.0 * limit);
                root.lambda.clamp(-limit - total, limit - total)
            };
            steps[component] = step;
            lambdas[component] += step;
            let excess = c0 - rest + step * (c1 + step * (c2 + step * c3));
            let (report, residual) = (&mut reports[component], residual(excess, rest));
            *report = ComponentReport {
                after: (rest + excess) * self.cell_size.powi(3),
                lambda: report.lambda + step * self.cell_size,
                residual,
                capped: residual.abs() > VOLUME_TOLERANCE,
                ..*report
            };
        }
        for ((&component, point), corrected) in
            self.adjacency.component_of_vertex.iter().zip(&scratch.points).zip(corrected)
        {
            let (step, v) = (steps[component as usize] as f32, point.direction());
            *corrected = std::array::from_fn(|k| corrected[k] + step * v[k]);
        }
        flattened.follow(&steps, displacements);
        workspace.steps = steps;
        self.update_surface_motions(workspace);
    }
}

/// Returns the coefficients of a cubic about the point `x`.
fn taylor([c0, c1, c2, c3]: [f64; 4], x: f64) -> [f64; 4] {
    [c0 + x * (c1 + x * (c2 + x * c3)), c1 + x * (2.0 * c2 + x * (3.0 * c3)), c2 + 3.0 * c3 * x, c3]
}

#[cfg(test)]
mod tests {
    #[test]
    fn taylor_coefficients_have_the_values_of_the_cubic() {
        let value = |c: [f64; 4], x: f64| c[0] + x * (c[1] + x * (c[2] + x * c[3]));
        let c = [1.0, -2.0, 3.0, 0.5];
        for x in [-1.0, 0.25, 2.0] {
            assert_eq!(value(super::taylor(c, 0.5), x - 0.5), value(c, x));
        }
    }
}
