//! Runs the volume correction of a deformed lattice: field, scales, cubics.
//!
//! | file | content |
//! |---|---|
//! | `ramp` | the field fades out beside constrained vertices |
//! | `workspace` | buffers and results |
//! | `evaluate` | [`Correction`]; positions, field, one cubic for each component, results |
//! | `passes` | several passes where a single cubic cannot restore the volume |
//! | `within` | the solution within limits of the displacements |
//! | `mod` | the solution |

mod evaluate;
mod passes;
mod ramp;
mod within;
mod workspace;

pub use self::evaluate::Correction;
pub(crate) use self::evaluate::RestRatios;
pub use self::workspace::CorrectionWorkspace;

use super::ComponentReport;
use super::external_forces::{self, ExternalForce};
use crate::parallel::Executor;

impl Correction {
    /// Corrects a deformed lattice: writes `deformed + lambda V` to `corrected`. With the scope `regional`
    /// each vertex is also moved by its own scale.
    ///
    /// * `deformed`, `corrected`: positions of the lattice vertices, shape (n, 3), in cells, in the body's
    ///   frame, at any distance from the origin.
    /// * `rotations`: unit quaternions (x, y, z, w), shape (n, 4), that rotate vectors from the model's frame
    ///   to the frame of `deformed`. The field fits best if they are the shape-matching rotations of
    ///   `deformed`.
    /// * `forces`: external forces from contacts and from the user, in any order; see [`ExternalForce`].
    ///
    /// Returns one report per component of the lattice, in scene units. Finite positions never give NaN.
    ///
    /// # Panics
    /// Panics if the length of an array differs from the number of lattice vertices, or if the vertex of a
    /// force is out of range.
    #[cfg(feature = "internals")]
    pub fn apply<'w>(
        &self,
        workspace: &'w mut CorrectionWorkspace,
        deformed: &[[f32; 3]],
        rotations: &[[f32; 4]],
        forces: &[ExternalForce],
        corrected: &mut [[f32; 3]],
    ) -> &'w [ComponentReport] {
        self.set_rest(workspace, None);
        let mut slope_weights = crate::lattice::SlopeWeights::default();
        if let Some(smoothing) = self.measure.smoothing() {
            smoothing.update_slope_weights(deformed, &mut slope_weights);
        }
        self.solve(workspace, &Executor::sequential(), deformed, rotations, forces, slope_weights.values());
        self.write(workspace, deformed, corrected)
    }

    /// Computes the displacement of each vertex, without limits. The arguments have the meaning
    /// of the arguments of [`Correction::apply`]. `slope_weights`: of `deformed`, if the skin is smooth.
    pub(crate) fn solve(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        deformed: &[[f32; 3]],
        rotations: &[[f32; 4]],
        forces: &[ExternalForce],
        slope_weights: &[f32],
    ) {
        let n = self.adjacency.len();
        assert!(
            deformed.len() == n && rotations.len() == n,
            "{n} lattice vertices, but {} positions and {} rotations",
            deformed.len(),
            rotations.len(),
        );
        workspace.lambdas.resize(self.rest.len(), 0.0);
        workspace.reports.resize(self.rest.len(), ComponentReport::default());
        self.set_positions(workspace, deformed, slope_weights);
        self.rotate_field(workspace, rotations);
        let CorrectionWorkspace { scratch, order, regional: regional_scratch, offsets, .. } = workspace;
        external_forces::remove_force_directions(forces, |_| true, order, &mut scratch.points);
        if let Some(regional) = &self.regional {
            let out = (&mut *scratch.points, offsets);
            regional.correct(regional_scratch, executor, &self.adjacency, &self.caps, out);
        }
        self.solve_cubics(workspace, executor);
        let cell_volume = self.cell_size.powi(3);
        for (report, c) in workspace.reports.iter_mut().zip(&workspace.scratch.coefficients) {
            report.before = c[0] * cell_volume;
        }
        if workspace.reports.iter().any(|report| report.capped) {
            self.solve_in_passes(workspace, executor, forces);
        }
        workspace.restored.clear();
        workspace.restored.extend(workspace.reports.iter().map(|report| !report.capped));
    }
}
