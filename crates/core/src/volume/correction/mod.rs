//! Runs the volume correction of a deformed lattice: field, scales, cubics.
//!
//! | file | content |
//! |---|---|
//! | `ramp` | the field fades out beside constrained vertices |
//! | `passes` | several passes where a single cubic cannot restore the volume |
//! | `obstacles` | limits at colliders and other bodies |

mod obstacles;
mod passes;
mod ramp;

use std::sync::Arc;

use self::passes::Passes;
use self::ramp::Ramp;
use super::adjacency::Adjacency;
use super::clearance::LimitSearch;
use super::cubic::smallest_root;
use super::external_forces::{self, ExternalForce};
use super::field::{Field, rotated};
use super::limits::Limits;
use super::measure::Measure;
use super::regional::{Regional, RegionalScratch};
use super::report::residual;
use super::sums::Scratch;
use super::surface::Surface;
use super::{ComponentReport, FieldKind, VolumeError, VolumeMeasure, VolumeOptions, VolumeScope};
use crate::lattice::Lattice;
use crate::parallel::Executor;
use crate::simd::xyzx::xyzx;
use crate::skin::{ComponentMotion, SurfaceMotion};

/// Relative volume error up to which the volume counts as preserved: the accuracy that positions in `f32`
/// allow.
const VOLUME_TOLERANCE: f64 = 1e-6;

/// Volume correction of one body: moves its lattice vertices along a field to restore the rest volume.
///
/// It solves `vol(P^ + lambda V) = vol(P)` (Takamatsu & Kanai 2009, Eq. (1)): the deformed vertices `P^`,
/// moved by `lambda` times the field `V`, have the volume of the rest positions `P`. With the scope
/// `regional` each vertex first moves by its own scale. A correction does not change after its construction.
/// An evaluation writes to a [`CorrectionWorkspace`], so that several threads can share one correction.
#[derive(Clone, Debug)]
pub struct Correction {
    measure: Measure,
    field: Field,
    /// Links of the lattice. A [`Ramp`] refers to the adjacency for which it was built.
    adjacency: Arc<Adjacency>,
    cell_size: f64,
    /// Number of links over which the field fades in beside constrained vertices.
    ramp_links: u32,
    /// Volume of each component of the rest shape, in cubed cells.
    rest: Vec<f64>,
    /// Greatest magnitude of `lambda` of each component, in cells.
    caps: Vec<f64>,
    /// See [`VolumeOptions::max_correction`].
    max_correction: f64,
    regional: Option<Regional>,
}

/// The ratios of the rest volumes in force to those of the rest shape.
pub(crate) struct RestRatios<'a> {
    /// One for each component.
    pub(crate) components: &'a [f64],
    /// The one around each vertex.
    pub(crate) of_vertex: &'a dyn Fn(usize) -> f64,
}

/// Buffers and results of a [`Correction`].
///
/// One workspace may serve several corrections in sequence. It stops allocating once its buffers have the
/// size that the largest correction needs.
#[derive(Clone, Debug, Default)]
pub struct CorrectionWorkspace {
    /// Rest volume of each component in force, in cubed cells.
    rest: Vec<f64>,
    ramp: Option<Ramp>,
    scratch: Scratch,
    regional: RegionalScratch,
    /// Pairs `(vertex, index)` of the external forces, sorted.
    order: Vec<(u32, u32)>,
    passes: Passes,
    /// Displacement of each vertex, in cells, to which `lambda` times its direction is added. Empty if all are
    /// zero.
    offsets: Vec<[f32; 3]>,
    limits: Limits,
    limit_search: LimitSearch,
    /// Whether the surface points of `scratch` move from the present points along the present field.
    has_surface: bool,
    /// `lambda` of each component, in cells.
    lambdas: Vec<f64>,
    /// Motions of the surface points of each component.
    motions: Vec<ComponentMotion>,
    reports: Vec<ComponentReport>,
}

impl CorrectionWorkspace {
    /// Returns the displacement of a vertex to which `lambda` times its direction is added; `None` if the
    /// displacements of all vertices are zero.
    fn offset(&self, vertex: usize) -> Option<[f32; 3]> {
        self.offsets.get(vertex).copied()
    }

    /// Returns the memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.rest)
            + self.ramp.as_ref().map_or(0, Ramp::bytes)
            + self.scratch.bytes()
            + self.regional.bytes()
            + size_of_val(&*self.order)
            + self.passes.bytes()
            + size_of_val(&*self.offsets)
            + self.limits.bytes()
            + self.limit_search.bytes()
            + size_of_val(&*self.lambdas)
            + size_of_val(&*self.motions)
            + size_of_val(&*self.reports)
    }
}

impl Correction {
    /// Creates the correction for `options`; `None` if `options` turn the correction off.
    ///
    /// Beside constrained vertices the field fades in, from a factor of 0 to 1, over half of the body's
    /// thickness and at least two links. A longer transition would leave too few vertices that can move, and
    /// a shorter transition would leave a visible crease.
    ///
    /// # Errors
    /// Returns a [`VolumeError`] if the chosen measure cannot use the surface, or if `max_correction` is out
    /// of range.
    pub fn new(
        lattice: &Lattice,
        surface: Option<Surface<'_>>,
        options: &VolumeOptions,
    ) -> Result<Option<Self>, VolumeError> {
        options.validate()?;
        let max_correction = options.max_correction;
        let adjacency = Adjacency::new(lattice);
        let Some(measure) = Measure::choose(options.measure, lattice, surface, &adjacency)? else {
            return Ok(None);
        };
        let kind = match (options.field, measure.kind()) {
            (FieldKind::Auto, VolumeMeasure::Mesh) => FieldKind::Surface,
            (kind, _) => kind,
        };
        let field = Field::new(kind, lattice, surface, &adjacency);
        let mut scratch = Scratch::default();
        scratch.set_rest_positions(lattice, &adjacency);
        measure.evaluate(&Executor::sequential(), &mut scratch);
        let regional = (options.scope == VolumeScope::Regional).then(|| {
            for (point, direction) in scratch.points.iter_mut().zip(&field.directions) {
                point.set_direction(*direction);
            }
            Regional::new(lattice, &adjacency, &scratch.points, &field.thickness)
        });
        Ok(Some(Self {
            measure,
            regional,
            cell_size: lattice.cell_size(),
            ramp_links: field.thickness.iter().fold(2.0, |links: f64, depth| links.max((depth / 2.0).ceil()))
                as u32,
            rest: scratch.coefficients.iter().map(|c| c[0]).collect(),
            caps: field.thickness.iter().map(|thickness| thickness * max_correction).collect(),
            max_correction,
            field,
            adjacency: Arc::new(adjacency),
        }))
    }

    /// Returns the measure by which the volume is preserved.
    pub fn measure(&self) -> VolumeMeasure {
        self.measure.kind()
    }

    /// Returns the memory in bytes: field, measure, scope `regional`, links.
    pub fn bytes(&self) -> usize {
        let regional = self.regional.as_ref().map_or(0, Regional::bytes);
        size_of_val(&*self.field.directions) + self.measure.bytes() + regional + self.adjacency.bytes()
    }

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
        let mut trust = crate::lattice::Trust::default();
        if let Some(smoothing) = self.measure.smoothing() {
            smoothing.update_trust(deformed, &mut trust);
        }
        self.solve(workspace, &Executor::sequential(), deformed, rotations, forces, trust.values());
        self.write(workspace, deformed, corrected)
    }

    /// Iterates over the greatest magnitude of the scale `lambda` of each component, in scene units.
    pub(crate) fn caps(&self) -> impl Iterator<Item = f64> {
        self.caps.iter().map(|cap| cap * self.cell_size)
    }

    /// Returns whether each vertex moves by its own scale: the scope `regional`.
    pub(crate) fn is_regional(&self) -> bool {
        self.regional.is_some()
    }

    /// Sets the rest volumes to those of the body times `ratios`. It must be called before the other functions.
    pub(crate) fn set_rest(&self, workspace: &mut CorrectionWorkspace, ratios: Option<&RestRatios>) {
        let ratio = |component: usize| ratios.map_or(1.0, |ratios| ratios.components[component]);
        workspace.rest.clear();
        workspace.rest.extend(self.rest.iter().enumerate().map(|(component, rest)| rest * ratio(component)));
        if let Some(regional) = &self.regional {
            regional.set_rest(&mut workspace.regional, ratios.map(|ratios| ratios.of_vertex));
        }
    }

    /// Computes the displacement of each vertex, without limits at colliders. The arguments have the meaning
    /// of the arguments of [`Correction::apply`]. `trust`: trust in the slopes of `deformed`, if the skin is smooth.
    pub(crate) fn solve(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        deformed: &[[f32; 3]],
        rotations: &[[f32; 4]],
        forces: &[ExternalForce],
        trust: &[f32],
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
        self.set_positions(workspace, deformed, trust);
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
    }

    /// Returns the volume of each component of a lattice with these positions, in cubed scene units. `trust`: as in
    /// [`Correction::solve`].
    pub(crate) fn volumes<'w>(
        &'w self,
        workspace: &'w mut CorrectionWorkspace,
        executor: &Executor,
        positions: &[[f32; 3]],
        trust: &[f32],
    ) -> impl Iterator<Item = f64> + 'w {
        self.set_positions(workspace, positions, trust);
        self.evaluate(workspace, executor);
        let cell_volume = self.cell_size.powi(3);
        workspace.scratch.coefficients.iter().map(move |c| c[0] * cell_volume)
    }

    /// Replaces the corrected positions by `positions`, which differ from the result of the correction, and returns the
    /// reports on their volumes.
    pub(crate) fn replace<'w>(
        &self,
        workspace: &'w mut CorrectionWorkspace,
        executor: &Executor,
        positions: &[[f32; 3]],
        trust: &[f32],
    ) -> &'w [ComponentReport] {
        self.set_positions(workspace, positions, trust);
        self.evaluate(workspace, executor);
        workspace.lambdas.fill(0.0);
        for component in 0..self.rest.len() {
            let excess = workspace.scratch.coefficients[component][0] - workspace.rest[component];
            self.report(workspace, component, excess);
        }
        workspace.has_surface = false;
        &workspace.reports
    }

    /// Sets the positions from which the vertices move, and the trust in their slopes. Removes the limits and offsets.
    fn set_positions(&self, workspace: &mut CorrectionWorkspace, positions: &[[f32; 3]], trust: &[f32]) {
        workspace.limits.clear();
        workspace.offsets.clear();
        let scratch = &mut workspace.scratch;
        scratch.set_positions(positions, &self.adjacency);
        scratch.trust.clear();
        scratch.trust.extend_from_slice(trust);
    }

    /// Writes the corrected positions to `corrected`, and returns one report per component.
    ///
    /// # Panics
    /// Panics if the length of an array differs from the number of lattice vertices.
    pub(crate) fn write<'w>(
        &self,
        workspace: &'w mut CorrectionWorkspace,
        deformed: &[[f32; 3]],
        corrected: &mut [[f32; 3]],
    ) -> &'w [ComponentReport] {
        let n = self.adjacency.len();
        assert!(
            deformed.len() == n && corrected.len() == n,
            "{n} lattice vertices, but {} deformed and {} corrected positions",
            deformed.len(),
            corrected.len()
        );
        let lambda = lambda_of(&workspace.lambdas, &self.adjacency);
        let points = deformed.iter().zip(&workspace.scratch.points);
        for (i, (corrected, (deformed, point))) in corrected.iter_mut().zip(points).enumerate() {
            let (lambda, v) = (lambda(i as u32) as f32, point.direction());
            *corrected = std::array::from_fn(|k| deformed[k] + lambda * v[k]);
            if let Some(offset) = workspace.offset(i) {
                *corrected = std::array::from_fn(|k| corrected[k] + offset[k]);
            }
        }
        workspace.limits.write(lambda, deformed, corrected);
        self.update_surface_motions(workspace);
        &workspace.reports
    }

    /// Updates the motions of the surface points for the present `lambda`.
    fn update_surface_motions(&self, workspace: &mut CorrectionWorkspace) {
        workspace.motions.clear();
        workspace.motions.extend(workspace.lambdas.iter().enumerate().map(|(component, lambda)| {
            let center = xyzx(workspace.scratch.center(component));
            ComponentMotion { lambda: *lambda as f32, center }
        }));
    }

    /// Sets the directions of the points to the field at rest, rotated, times the factors of the ramp.
    fn rotate_field(&self, workspace: &mut CorrectionWorkspace, rotations: &[[f32; 4]]) {
        for (point, (q, v)) in
            workspace.scratch.points.iter_mut().zip(rotations.iter().zip(&self.field.directions))
        {
            point.set_direction(rotated(q, v));
        }
        if let Some(ramp) = self.ramp_of(&workspace.ramp) {
            for (point, factor) in workspace.scratch.points.iter_mut().zip(&ramp.factors) {
                point.set_direction(point.direction().map(|v| v * factor));
            }
        }
    }

    /// Solves Eq. (1) of Takamatsu & Kanai 2009: one cubic for each component.
    fn solve_cubics(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
        self.evaluate(workspace, executor);
        for component in 0..self.rest.len() {
            let c = workspace.scratch.coefficients[component];
            let root =
                smallest_root([c[0] - workspace.rest[component], c[1], c[2], c[3]], self.caps[component]);
            workspace.lambdas[component] = root.lambda;
            self.report(workspace, component, root.residual);
        }
    }

    /// Evaluates the measure for the present points and field.
    fn evaluate(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
        self.measure.evaluate(executor, &mut workspace.scratch);
        workspace.has_surface = true;
    }

    /// Returns the motions of the surface points, in the order of
    /// [`Embedding::by_cell`](crate::lattice::Embedding::by_cell). Returns `None` if the correction has not computed
    /// them: it does so for the measure `mesh` with a smooth skin.
    ///
    /// Must be called after [`Correction::write`].
    pub(crate) fn surface_motion<'w>(
        &'w self,
        workspace: &'w CorrectionWorkspace,
    ) -> Option<SurfaceMotion<'w>> {
        let CorrectionWorkspace { scratch, motions, has_surface, .. } = workspace;
        (*has_surface && self.measure.smoothing().is_some()).then(|| SurfaceMotion {
            points: &scratch.surface_points,
            component_of_vertex: &self.adjacency.component_of_vertex,
            components: motions,
        })
    }

    /// Writes the report of a component. `excess`: corrected volume minus rest volume, in cubed cells.
    fn report(&self, workspace: &mut CorrectionWorkspace, component: usize, excess: f64) {
        let (cell_volume, rest) = (self.cell_size.powi(3), workspace.rest[component]);
        let residual = residual(excess, rest);
        workspace.reports[component] = ComponentReport {
            rest: rest * cell_volume,
            before: workspace.reports[component].before,
            after: (rest + excess) * cell_volume,
            lambda: workspace.lambdas[component] * self.cell_size,
            residual,
            capped: residual.abs() > VOLUME_TOLERANCE,
        };
    }
}

/// Returns a function from a vertex to the `lambda` of its component.
fn lambda_of(lambdas: &[f64], adjacency: &Adjacency) -> impl Fn(u32) -> f64 {
    |vertex| lambdas[adjacency.component(vertex as usize)]
}
