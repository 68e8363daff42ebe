//! Volume-preserving correction of a deformed lattice.

use std::sync::{Arc, Weak};

use super::adjacency::Adjacency;
use super::clearance::{Clearance, Obstacles};
use super::cubic::smallest_root;
use super::external_forces::{self, ExternalForce};
use super::field::{Field, rotated};
use super::limits::{Limit, Limits};
use super::line::Moving;
use super::measure::Measure;
use super::regional::{Regional, RegionalScratch};
use super::sums::Scratch;
use super::surface::Surface;
use super::{ComponentReport, VolumeError, VolumeMeasure, VolumeOptions, VolumeScope};
use crate::contact::SampleCells;
use crate::lattice::Lattice;
use crate::parallel::Executor;

/// Greatest relative residual of a kept volume: the accuracy that positions in `f32` allow.
const VOLUME_TOLERANCE: f64 = 1e-6;

/// Maximum number of passes of the active-set iteration over limited vertices. Three to five are common. The
/// residual reports the volume error after the last pass.
const LIMITED_PASSES: usize = 8;

/// Maximum number of rounds of [`Correction::limit_at_colliders`].
///
/// A further round is needed if vertices move farther than the searched distance, or if the corrected surface
/// still enters a curved collider. One or two rounds are common.
const ROUNDS: usize = 16;

/// Search distance of limits, as a multiple of the greatest displacement. The margin avoids a second search
/// in a later round with larger displacements.
const MARGIN: f64 = 1.25;

/// Volume correction of one body: moves its lattice vertices along a field to restore the rest volume.
///
/// It solves Takamatsu & Kanai 2009, Eq. (1): `vol(P^ + lambda V) = vol(P)`. With the scope `regional` each
/// vertex first moves by its own scale. The correction is constant after its construction. An evaluation
/// writes to a [`CorrectionWorkspace`], so that several threads can share one correction.
#[derive(Clone, Debug)]
pub struct Correction {
    measure: Measure,
    field: Field,
    /// Shared with the workspaces whose ramps belong to this lattice.
    adjacency: Arc<Adjacency>,
    cell_size: f64,
    /// Length of the ramp beside constrained vertices, in links.
    ramp_links: u32,
    /// Volume of each component at rest, in cubed cells.
    rest: Vec<f64>,
    /// Cap on `lambda` of each component, in cells.
    caps: Vec<f64>,
    regional: Option<Regional>,
}

/// Buffers and results of a [`Correction`].
///
/// One workspace may serve several corrections in sequence. It stops allocating once its buffers have the
/// size that the largest correction needs.
#[derive(Clone, Debug, Default)]
pub struct CorrectionWorkspace {
    ramp: Option<Ramp>,
    scratch: Scratch,
    regional: RegionalScratch,
    /// Pairs of vertex and index of the external forces, sorted.
    order: Vec<(u32, u32)>,
    limits: Limits,
    clearance: Clearance,
    /// Scale of each component, in cells.
    lambdas: Vec<f64>,
    reports: Vec<ComponentReport>,
}

/// Factors of the field beside constrained vertices.
#[derive(Clone, Debug)]
struct Ramp {
    adjacency: Weak<Adjacency>,
    constrained: Vec<u32>,
    /// Factor of each vertex, [0, 1].
    factors: Vec<f32>,
}

impl Ramp {
    /// Returns whether the ramp was built for this lattice.
    fn belongs_to(&self, adjacency: &Arc<Adjacency>) -> bool {
        self.adjacency.as_ptr() == Arc::as_ptr(adjacency)
    }
}

impl CorrectionWorkspace {
    /// Returns the memory in bytes.
    pub fn bytes(&self) -> usize {
        let ramp = self
            .ramp
            .as_ref()
            .map_or(0, |ramp| size_of_val(&*ramp.constrained) + size_of_val(&*ramp.factors));
        ramp + self.scratch.bytes()
            + self.regional.bytes()
            + size_of_val(&*self.order)
            + self.limits.bytes()
            + self.clearance.bytes()
            + size_of_val(&*self.lambdas)
            + size_of_val(&*self.reports)
    }
}

impl Correction {
    /// Creates the correction for `options`; `None` if they turn it off.
    ///
    /// Beside constrained vertices the field rises from 0 to 1 over half of the body's thickness, at least
    /// two links. A longer ramp would leave too few vertices that can move, and a shorter one would leave a
    /// visible crease.
    ///
    /// # Errors
    /// Returns a [`VolumeError`] if the chosen measure cannot use the surface, or if the cap is out of range.
    pub fn new(
        lattice: &Lattice,
        surface: Option<Surface<'_>>,
        options: &VolumeOptions,
    ) -> Result<Option<Self>, VolumeError> {
        let max_correction = options.max_correction;
        if !(max_correction.is_finite() && max_correction >= 0.0) {
            return Err(VolumeError::MaxCorrection(max_correction));
        }
        let adjacency = Adjacency::new(lattice);
        let Some(measure) = Measure::choose(options.measure, lattice, surface, &adjacency)? else {
            return Ok(None);
        };
        let field = Field::new(options.field, lattice, surface, &adjacency);
        let mut scratch = Scratch::default();
        scratch.place_at_rest(lattice, &adjacency);
        measure.evaluate(&Executor::sequential(), &mut scratch);
        let regional = (options.scope == VolumeScope::Regional).then(|| {
            for (point, direction) in scratch.points.iter_mut().zip(&field.directions) {
                point.set_direction(*direction);
            }
            Regional::new(&adjacency, &scratch.points)
        });
        Ok(Some(Self {
            measure,
            regional,
            cell_size: lattice.cell_size(),
            ramp_links: field.thickness.iter().fold(2.0, |links: f64, depth| links.max((depth / 2.0).ceil()))
                as u32,
            rest: scratch.coefficients.iter().map(|c| c[0]).collect(),
            caps: field.thickness.iter().map(|thickness| thickness * max_correction).collect(),
            field,
            adjacency: Arc::new(adjacency),
        }))
    }

    /// Returns the measure whose value is kept.
    pub fn measure(&self) -> VolumeMeasure {
        self.measure.kind()
    }

    /// Returns the memory in bytes: the field, the measure, the links.
    pub fn bytes(&self) -> usize {
        let regional = self.regional.as_ref().map_or(0, Regional::bytes);
        size_of_val(&*self.field.directions) + self.measure.bytes() + regional + self.adjacency.bytes()
    }

    /// Sets the lattice vertices that pins and handles constrain.
    ///
    /// The correction does not move these vertices, and fades in beside them. The workspace keeps them until
    /// it serves the correction of another lattice. Allocates only if the vertices change.
    pub fn set_constrained(
        &self,
        workspace: &mut CorrectionWorkspace,
        constrained: impl Iterator<Item = u32> + Clone,
    ) {
        let ramp = workspace.ramp.as_ref().filter(|ramp| ramp.belongs_to(&self.adjacency));
        if !ramp.map_or(&[][..], |ramp| &ramp.constrained).iter().copied().eq(constrained.clone()) {
            let constrained: Vec<u32> = constrained.collect();
            workspace.ramp = (!constrained.is_empty()).then(|| Ramp {
                adjacency: Arc::downgrade(&self.adjacency),
                factors: external_forces::ramp(&self.adjacency, &constrained, self.ramp_links),
                constrained,
            });
        }
    }

    /// Corrects a deformed lattice: `corrected = deformed + lambda V`.
    ///
    /// * `deformed`, `corrected`: (n, 3), lattice vertices in cells, in the body's frame, at any distance
    ///   from the origin.
    /// * `rotations`: (n, 4), unit quaternions (x, y, z, w) from the model's frame to that of `deformed`. The
    ///   field fits best with the rotations of the shape matching of `deformed`.
    /// * `forces`: external forces from contacts and from the user, in any order; see [`ExternalForce`].
    ///
    /// Returns one report per component of the lattice, in scene units. Finite positions never give NaN.
    ///
    /// # Panics
    /// If a length differs from the number of lattice vertices, or the vertex of a force is out of range.
    pub fn apply<'w>(
        &self,
        workspace: &'w mut CorrectionWorkspace,
        deformed: &[[f32; 3]],
        rotations: &[[f32; 4]],
        forces: &[ExternalForce],
        corrected: &mut [[f32; 3]],
    ) -> &'w [ComponentReport] {
        self.solve(workspace, &Executor::sequential(), deformed, rotations, forces);
        self.write(workspace, deformed, corrected)
    }

    /// Computes the displacement of each vertex; the arguments are those of [`Correction::apply`].
    pub(crate) fn solve(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        deformed: &[[f32; 3]],
        rotations: &[[f32; 4]],
        forces: &[ExternalForce],
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
        workspace.limits.clear();
        workspace.scratch.place(deformed.iter().map(|p| p.map(f64::from)), &self.adjacency);
        self.rotate_field(workspace, rotations);
        let CorrectionWorkspace { scratch, order, regional: scales, .. } = workspace;
        external_forces::remove_force_directions(forces, order, &mut scratch.points);
        if let Some(regional) = &self.regional {
            regional.correct(scales, executor, &self.adjacency, &self.caps, &mut scratch.points);
        }
        self.solve_cubics(workspace, executor);
        let unit = self.cell_size.powi(3);
        for (report, c) in workspace.reports.iter_mut().zip(&workspace.scratch.coefficients) {
            report.before = c[0] * unit;
        }
    }

    /// Returns the greatest displacement of a vertex, in cells.
    fn greatest_displacement(&self, workspace: &CorrectionWorkspace) -> f64 {
        let lambda = lambda_of(&workspace.lambdas, &self.adjacency);
        let scales = self.scales(&workspace.regional);
        let length = |(i, point): (usize, &Moving)| {
            let scale = lambda(i as u32) + scales.map_or(0.0, |s| f64::from(s[i]));
            let square: f64 = point.direction().iter().map(|&v| f64::from(v).powi(2)).sum();
            scale.abs() * square.sqrt()
        };
        workspace.scratch.points.iter().enumerate().map(length).fold(0.0, f64::max)
    }

    /// Limits displacements and solves again until the correction moves no surface sample into a collider.
    ///
    /// Must be called after [`Correction::solve`]; `corrected` is scratch.
    pub(crate) fn limit_at_colliders(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        samples: &SampleCells,
        obstacles: &Obstacles<'_>,
        deformed: &[[f32; 3]],
        corrected: &mut [[f32; 3]],
    ) {
        // Taken out of the workspace so that `limit` can borrow both.
        let mut clearance = std::mem::take(&mut workspace.clearance);
        let mut searched = 0.0;
        let curved = obstacles.are_curved();
        for _ in 0..ROUNDS {
            let greatest = self.greatest_displacement(workspace);
            let limited = if greatest > searched {
                searched = MARGIN * greatest;
                clearance.find(samples, deformed, obstacles, searched);
                !clearance.limits.is_empty()
            } else if searched > 0.0 && curved {
                self.write(workspace, deformed, corrected);
                clearance.add_entered(samples, corrected, obstacles)
            } else {
                false
            };
            if !limited {
                break;
            }
            self.limit(workspace, executor, &clearance.limits);
        }
        workspace.clearance = clearance;
    }

    /// Solves again with limits, by an active-set iteration in which the volume remains an exact cubic.
    ///
    /// A vertex at its limit slides along the obstacle; the others take up the volume.
    fn limit(&self, workspace: &mut CorrectionWorkspace, executor: &Executor, limits: &[Limit]) {
        let scales = self.scales(&workspace.regional);
        workspace.limits.begin(limits, &mut workspace.scratch.points, scales);
        for _ in 0..LIMITED_PASSES {
            if !self.update_motions(workspace) {
                return;
            }
            self.solve_cubics(workspace, executor);
        }
        self.update_motions(workspace);
        self.report_residuals(workspace, executor);
    }

    /// Updates the motions of limited vertices for the current `lambda`. Returns whether any has changed.
    fn update_motions(&self, workspace: &mut CorrectionWorkspace) -> bool {
        let CorrectionWorkspace { limits, lambdas, scratch, .. } = workspace;
        limits.update_motions(lambda_of(lambdas, &self.adjacency), &mut scratch.points)
    }

    /// Evaluates the volume for the current `lambda` and reports its residual, without a new solve.
    fn report_residuals(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
        self.measure.evaluate(executor, &mut workspace.scratch);
        for component in 0..self.rest.len() {
            let [c0, c1, c2, c3] = workspace.scratch.coefficients[component];
            let lambda = workspace.lambdas[component];
            let volume = c0 + lambda * (c1 + lambda * (c2 + lambda * c3));
            self.report(workspace, component, volume - self.rest[component]);
        }
    }

    /// Writes the corrected positions: `corrected = deformed + lambda V`. Returns one report per component.
    ///
    /// # Panics
    /// If a length differs from the number of lattice vertices.
    pub(crate) fn write<'w>(
        &self,
        workspace: &'w CorrectionWorkspace,
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
        let scales = self.scales(&workspace.regional);
        let lambda = lambda_of(&workspace.lambdas, &self.adjacency);
        let points = deformed.iter().zip(&workspace.scratch.points);
        for (i, (corrected, (deformed, point))) in corrected.iter_mut().zip(points).enumerate() {
            let scale = lambda(i as u32) as f32 + scales.map_or(0.0, |scales| scales[i]);
            let v = point.direction();
            *corrected = std::array::from_fn(|k| deformed[k] + scale * v[k]);
        }
        workspace.limits.write(&lambda, deformed, corrected);
        &workspace.reports
    }

    /// Returns the scale of each vertex with the scope `regional`, else `None`.
    fn scales<'w>(&self, regional: &'w RegionalScratch) -> Option<&'w [f32]> {
        self.regional.as_ref().map(|_| &*regional.scales)
    }

    /// Sets the directions of the points: the field at rest, rotated, times the ramp.
    fn rotate_field(&self, workspace: &mut CorrectionWorkspace, rotations: &[[f32; 4]]) {
        for (point, (q, v)) in
            workspace.scratch.points.iter_mut().zip(rotations.iter().zip(&self.field.directions))
        {
            point.set_direction(rotated(q, v));
        }
        if let Some(ramp) = workspace.ramp.as_ref().filter(|ramp| ramp.belongs_to(&self.adjacency)) {
            for (point, factor) in workspace.scratch.points.iter_mut().zip(&ramp.factors) {
                point.set_direction(point.direction().map(|v| v * factor));
            }
        }
    }

    /// Solves Eq. (1): one cubic for each component.
    fn solve_cubics(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
        self.measure.evaluate(executor, &mut workspace.scratch);
        for component in 0..self.rest.len() {
            let c = workspace.scratch.coefficients[component];
            let root = smallest_root([c[0] - self.rest[component], c[1], c[2], c[3]], self.caps[component]);
            workspace.lambdas[component] = root.lambda;
            self.report(workspace, component, root.residual);
        }
    }

    /// Writes the report of a component. `excess`: corrected volume minus rest volume, in cubed cells.
    fn report(&self, workspace: &mut CorrectionWorkspace, component: usize, excess: f64) {
        let (unit, rest) = (self.cell_size.powi(3), self.rest[component]);
        let residual = excess / rest;
        workspace.reports[component] = ComponentReport {
            rest: rest * unit,
            before: workspace.reports[component].before,
            after: (rest + excess) * unit,
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
