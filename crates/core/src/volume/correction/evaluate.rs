//! A correction, and the parts of a solution: positions, field, volumes, one cubic for each component, results.

use std::sync::Arc;

use super::ramp::Ramp;
use super::workspace::CorrectionWorkspace;
use crate::lattice::Lattice;
use crate::parallel::Executor;
use crate::simd::xyzx::xyzx;
use crate::skin::{ComponentMotion, SurfaceMotion};
use crate::volume::adjacency::Adjacency;
use crate::volume::cubic::smallest_root;
use crate::volume::field::{Field, rotated};
use crate::volume::measure::Measure;
use crate::volume::regional::Regional;
use crate::volume::report::residual;
use crate::volume::sums::Scratch;
use crate::volume::surface::Surface;
use crate::volume::{ComponentReport, FieldKind, VolumeError, VolumeMeasure, VolumeOptions, VolumeScope};

/// Relative volume error up to which the volume counts as preserved: the accuracy that positions in `f32`
/// allow.
pub(super) const VOLUME_TOLERANCE: f64 = 1e-6;

/// Volume correction of one body: moves its lattice vertices along a field to restore the rest volume.
///
/// It solves `vol(P^ + lambda V) = vol(P)` (Takamatsu & Kanai 2009, Eq. (1)): the deformed vertices `P^`,
/// moved by `lambda` times the field `V`, have the volume of the rest positions `P`. With the scope
/// `regional` each vertex first moves by its own scale. A correction does not change after its construction.
/// An evaluation writes to a [`CorrectionWorkspace`], so that several threads can share one correction.
#[derive(Clone, Debug)]
pub struct Correction {
    pub(super) measure: Measure,
    pub(super) field: Field,
    /// Links of the lattice. A [`Ramp`] refers to the adjacency for which it was built.
    pub(super) adjacency: Arc<Adjacency>,
    pub(super) cell_size: f64,
    /// Number of links over which the field fades in beside constrained vertices.
    pub(super) ramp_links: u32,
    /// Volume of each component of the rest shape, in cubed cells.
    pub(super) rest: Vec<f64>,
    /// Greatest magnitude of `lambda` of each component, in cells.
    pub(super) caps: Vec<f64>,
    /// See [`VolumeOptions::max_correction`].
    pub(super) max_correction: f64,
    pub(super) regional: Option<Regional>,
}

/// The ratios of the rest volumes in force to the volumes of the rest shape.
pub(crate) struct RestRatios<'a> {
    /// One for each component.
    pub components: &'a [f64],
    /// The one around each vertex.
    pub of_vertex: &'a dyn Fn(usize) -> f64,
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

    /// Sets the lattice vertices that pins and handles constrain.
    ///
    /// The correction does not move these vertices, and fades in beside them. The workspace keeps the
    /// constrained vertices until it is used for another lattice. Allocates only if the constrained vertices
    /// change.
    pub fn set_constrained(
        &self,
        workspace: &mut CorrectionWorkspace,
        constrained: impl Iterator<Item = u32> + Clone,
    ) {
        let ramp = self.ramp_of(&workspace.ramp);
        if !ramp.map_or(&[][..], |ramp| &ramp.constrained).iter().copied().eq(constrained.clone()) {
            let constrained: Vec<u32> = constrained.collect();
            workspace.ramp =
                (!constrained.is_empty()).then(|| Ramp::new(&self.adjacency, constrained, self.ramp_links));
        }
    }

    /// Returns the ramp of a workspace, if it was built for this lattice.
    pub(super) fn ramp_of<'w>(&self, ramp: &'w Option<Ramp>) -> Option<&'w Ramp> {
        ramp.as_ref().filter(|ramp| ramp.belongs_to(&self.adjacency))
    }

    /// Iterates over the greatest magnitude of the scale `lambda` of each component, in scene units.
    pub(crate) fn caps(&self) -> impl Iterator<Item = f64> {
        self.caps.iter().map(|cap| cap * self.cell_size)
    }

    /// Returns whether each vertex moves by its own scale: the scope `regional`.
    pub(crate) fn is_regional(&self) -> bool {
        self.regional.is_some()
    }

    /// Sets the rest volumes to the volumes of the body times `ratios`. It must be called before the other functions.
    pub(crate) fn set_rest(&self, workspace: &mut CorrectionWorkspace, ratios: Option<&RestRatios>) {
        let ratio = |component: usize| ratios.map_or(1.0, |ratios| ratios.components[component]);
        workspace.rest.clear();
        workspace.rest.extend(self.rest.iter().enumerate().map(|(component, rest)| rest * ratio(component)));
        if let Some(regional) = &self.regional {
            regional.set_rest(&mut workspace.regional, ratios.map(|ratios| ratios.of_vertex));
        }
    }

    /// Returns the volume of each component of a lattice with these positions, in cubed scene units. `slope_weights`:
    /// as in [`Correction::solve`].
    pub(crate) fn volumes<'w>(
        &'w self,
        workspace: &'w mut CorrectionWorkspace,
        executor: &Executor,
        positions: &[[f32; 3]],
        slope_weights: &[f32],
    ) -> impl Iterator<Item = f64> + 'w {
        self.set_positions(workspace, positions, slope_weights);
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
        slope_weights: &[f32],
    ) -> &'w [ComponentReport] {
        self.set_positions(workspace, positions, slope_weights);
        self.evaluate(workspace, executor);
        workspace.lambdas.fill(0.0);
        for component in 0..self.rest.len() {
            let excess = workspace.scratch.coefficients[component][0] - workspace.rest[component];
            self.report(workspace, component, excess);
        }
        workspace.has_surface = false;
        &workspace.reports
    }

    /// Sets the positions from which the vertices move, and the slope weights. Removes the limits and offsets.
    pub(super) fn set_positions(
        &self,
        workspace: &mut CorrectionWorkspace,
        positions: &[[f32; 3]],
        slope_weights: &[f32],
    ) {
        workspace.limited.clear();
        workspace.offsets.clear();
        let scratch = &mut workspace.scratch;
        scratch.set_positions(positions, &self.adjacency);
        scratch.slope_weights.clear();
        scratch.slope_weights.extend_from_slice(slope_weights);
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
        let points = deformed.iter().zip(&workspace.scratch.points);
        for (i, (corrected, (deformed, point))) in corrected.iter_mut().zip(points).enumerate() {
            let (lambda, v) = (workspace.lambdas[self.adjacency.component(i)] as f32, point.direction());
            *corrected = std::array::from_fn(|k| deformed[k] + lambda * v[k]);
            if let Some(offset) = workspace.offsets.get(i) {
                *corrected = std::array::from_fn(|k| corrected[k] + offset[k]);
            }
        }
        for limited in &workspace.limited {
            let (vertex, displacement) = (limited.vertex as usize, limited.displacement);
            corrected[vertex] = std::array::from_fn(|k| deformed[vertex][k] + displacement[k] as f32);
        }
        self.update_surface_motions(workspace);
        &workspace.reports
    }

    /// Updates the motions of the surface points for the present `lambda`.
    pub(super) fn update_surface_motions(&self, workspace: &mut CorrectionWorkspace) {
        workspace.motions.clear();
        workspace.motions.extend(workspace.lambdas.iter().enumerate().map(|(component, lambda)| {
            let center = xyzx(workspace.scratch.center(component));
            ComponentMotion { lambda: *lambda as f32, center }
        }));
    }

    /// Sets the directions of the points to the field at rest, rotated, times the factors of the ramp.
    pub(super) fn rotate_field(&self, workspace: &mut CorrectionWorkspace, rotations: &[[f32; 4]]) {
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
    pub(super) fn solve_cubics(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
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
    pub(super) fn evaluate(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
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
    pub(super) fn report(&self, workspace: &mut CorrectionWorkspace, component: usize, excess: f64) {
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
