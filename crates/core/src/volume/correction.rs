//! The volume-preserving correction of a deformed lattice.

use std::sync::{Arc, Weak};

use super::adjacency::Adjacency;
use super::clearance::{Clearance, Obstacles};
use super::cubic::smallest_root;
use super::external_forces::{self, ExternalForce};
use super::field::{Field, turned};
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

/// A volume off by less than this part of itself counts as kept: what positions in `f32` let one ask for.
const KEPT: f64 = 1e-6;

/// Most passes of the active set of limited vertices. Three to five are common; the residual reports what the last one
/// leaves.
const LIMITED_PASSES: usize = 8;

/// Most rounds of [`Correction::keep_out`]: the first, those in which vertices go farther than was searched, and those in
/// which the corrected surface enters a curved collider all the same. One or two are common.
const ROUNDS: usize = 16;

/// Limits are searched this many times as far as vertices go, so that a later round that goes farther need not search
/// again.
const MARGIN: f64 = 1.25;

/// Moves the vertices of a deformed lattice along a field until the volume is that at rest: equation (1) of
/// Takamatsu & Kanai (2009), `vol(P^ + lambda V) = vol(P)`. With the scope `regional` they first move by a scale of
/// their own each.
///
/// Holds what is fixed once it is built. What an evaluation needs besides is a [`CorrectionWorkspace`], so that one
/// correction serves several threads.
#[derive(Clone, Debug)]
pub struct Correction {
    measure: Measure,
    field: Field,
    /// Shared with the workspaces whose ramps were made for it.
    adjacency: Arc<Adjacency>,
    cell_size: f64,
    ramp_links: u32,
    /// Of each component: volume at rest in cells, and the cap on `lambda` in cells.
    rest: Vec<f64>,
    caps: Vec<f64>,
    regional: Option<Regional>,
}

/// The buffers of a [`Correction`], and its results. May serve several corrections one after the other; allocates
/// nothing once it has the size that the largest needs.
#[derive(Clone, Debug, Default)]
pub struct CorrectionWorkspace {
    ramp: Option<Ramp>,
    scratch: Scratch,
    regional: RegionalScratch,
    /// Forces by vertex.
    order: Vec<(u32, u32)>,
    limits: Limits,
    clearance: Clearance,
    lambdas: Vec<f64>,
    reports: Vec<ComponentReport>,
}

/// What held vertices leave of the field.
#[derive(Clone, Debug)]
struct Ramp {
    adjacency: Weak<Adjacency>,
    held: Vec<u32>,
    shares: Vec<f32>,
}

impl Ramp {
    fn is_of(&self, adjacency: &Arc<Adjacency>) -> bool {
        self.adjacency.as_ptr() == Arc::as_ptr(adjacency)
    }
}

impl CorrectionWorkspace {
    /// Memory that it takes.
    pub fn bytes(&self) -> usize {
        let ramp = self.ramp.as_ref().map_or(0, |ramp| size_of_val(&*ramp.held) + size_of_val(&*ramp.shares));
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
    /// The correction that `options` ask for; `None` if that is none at all.
    ///
    /// Beside held vertices the field rises over half of the body's thickness, at least two links: over a longer way
    /// too little of the body would be left to give way, over a shorter one a crease shows.
    ///
    /// # Errors
    /// [`VolumeError`]: a surface that cannot be the measure asked for, or a cap out of range.
    pub fn new(
        lattice: &Lattice,
        surface: Option<Surface<'_>>,
        options: &VolumeOptions,
    ) -> Result<Option<Self>, VolumeError> {
        let most = options.max_correction;
        if !(most.is_finite() && most >= 0.0) {
            return Err(VolumeError::MaxCorrection(most));
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
            caps: field.thickness.iter().map(|thickness| thickness * most).collect(),
            field,
            adjacency: Arc::new(adjacency),
        }))
    }

    /// The measure whose value is kept.
    pub fn measure(&self) -> VolumeMeasure {
        self.measure.kind()
    }

    /// Memory that it takes: the field, the measure, the links.
    pub fn bytes(&self) -> usize {
        let regional = self.regional.as_ref().map_or(0, Regional::bytes);
        size_of_val(&*self.field.directions) + self.measure.bytes() + regional + self.adjacency.bytes()
    }

    /// Sets which lattice vertices pins and handles hold: the correction leaves them in place, and fades in beside them.
    /// Kept by the workspace until it serves the correction of another lattice. Allocates where the vertices change.
    pub fn hold(&self, workspace: &mut CorrectionWorkspace, held: impl Iterator<Item = u32> + Clone) {
        let ramp = workspace.ramp.as_ref().filter(|ramp| ramp.is_of(&self.adjacency));
        if !ramp.map_or(&[][..], |ramp| &ramp.held).iter().copied().eq(held.clone()) {
            let held: Vec<u32> = held.collect();
            workspace.ramp = (!held.is_empty()).then(|| Ramp {
                adjacency: Arc::downgrade(&self.adjacency),
                shares: external_forces::ramp(&self.adjacency, &held, self.ramp_links),
                held,
            });
        }
    }

    /// Corrects a deformed lattice: `corrected = deformed + lambda V`.
    ///
    /// * `deformed`, `corrected`: (n, 3), lattice vertices in cells, body-local; any distance from the origin.
    /// * `rotations`: (n, 4), quaternions (x, y, z, w) that turn the model's frame to that of `deformed`; for the
    ///   field to fit, those of `deformed` itself.
    /// * `forces`: external forces of contacts and grabs, in any order; see [`ExternalForce`].
    ///
    /// Returns one report a component of the lattice, in units of length. Finite positions never give NaN.
    ///
    /// # Panics
    /// If the lengths differ from the lattice's, or a force names a vertex that it does not have.
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

    /// Finds how far each vertex is to move; arguments as those of [`Correction::apply`].
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
        self.turn_field(workspace, rotations);
        let CorrectionWorkspace { scratch, order, regional: scales, .. } = workspace;
        external_forces::remove_force_directions(forces, order, &mut scratch.points);
        if let Some(regional) = &self.regional {
            regional.give_back(scales, executor, &self.adjacency, &self.caps, &mut scratch.points);
        }
        self.solve_cubics(workspace, executor);
        let unit = self.cell_size.powi(3);
        for (report, c) in workspace.reports.iter_mut().zip(&workspace.scratch.coefficients) {
            report.before = c[0] * unit;
        }
    }

    /// The farthest that a vertex is to move, in cells.
    fn reach(&self, workspace: &CorrectionWorkspace) -> f64 {
        let lambda = of_vertex(&workspace.lambdas, &self.adjacency);
        let scales = self.scales(&workspace.regional);
        let way = |(i, point): (usize, &Moving)| {
            let scale = lambda(i as u32) + scales.map_or(0.0, |s| f64::from(s[i]));
            let square: f64 = point.direction().iter().map(|&v| f64::from(v).powi(2)).sum();
            scale.abs() * square.sqrt()
        };
        workspace.scratch.points.iter().enumerate().map(way).fold(0.0, f64::max)
    }

    /// Solves again, so that the correction moves no sample of the surface into a collider. To be called after
    /// [`Correction::solve`]; `corrected` is scratch.
    pub(crate) fn keep_out(
        &self,
        workspace: &mut CorrectionWorkspace,
        executor: &Executor,
        samples: &SampleCells,
        obstacles: &Obstacles<'_>,
        deformed: &[[f32; 3]],
        corrected: &mut [[f32; 3]],
    ) {
        // Out of the workspace while its limits are applied to the rest of it.
        let mut clearance = std::mem::take(&mut workspace.clearance);
        let mut searched = 0.0;
        let curved = obstacles.are_curved();
        for _ in 0..ROUNDS {
            let reach = self.reach(workspace);
            let limited = if reach > searched {
                searched = MARGIN * reach;
                clearance.find(samples, deformed, obstacles, searched);
                !clearance.limits.is_empty()
            } else if searched > 0.0 && curved {
                self.write(workspace, deformed, corrected);
                clearance.cut(samples, corrected, obstacles)
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

    /// Solves again with these limits: a vertex at its limit slides along the obstacle, and the others take up the
    /// volume. An active set, in which the volume stays an exact cubic.
    fn limit(&self, workspace: &mut CorrectionWorkspace, executor: &Executor, limits: &[Limit]) {
        let scales = self.scales(&workspace.regional);
        workspace.limits.begin(limits, &mut workspace.scratch.points, scales);
        for _ in 0..LIMITED_PASSES {
            if !self.divert(workspace) {
                return;
            }
            self.solve_cubics(workspace, executor);
        }
        self.divert(workspace);
        self.settle(workspace, executor);
    }

    /// Gives limited vertices their ways near `lambda`. Returns whether any has changed.
    fn divert(&self, workspace: &mut CorrectionWorkspace) -> bool {
        let CorrectionWorkspace { limits, lambdas, scratch, .. } = workspace;
        limits.divert(of_vertex(lambdas, &self.adjacency), &mut scratch.points)
    }

    /// Leaves `lambda` as it is and measures what it gives.
    fn settle(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
        self.measure.evaluate(executor, &mut workspace.scratch);
        for component in 0..self.rest.len() {
            let [c0, c1, c2, c3] = workspace.scratch.coefficients[component];
            let lambda = workspace.lambdas[component];
            let volume = c0 + lambda * (c1 + lambda * (c2 + lambda * c3));
            self.report(workspace, component, volume - self.rest[component]);
        }
    }

    /// Moves the vertices as far as was found: `corrected = deformed + lambda V`. Returns one report a component.
    ///
    /// # Panics
    /// If the lengths differ from the lattice's.
    pub(crate) fn write<'w>(
        &self,
        workspace: &'w CorrectionWorkspace,
        deformed: &[[f32; 3]],
        corrected: &mut [[f32; 3]],
    ) -> &'w [ComponentReport] {
        let n = self.adjacency.len();
        assert!(
            deformed.len() == n && corrected.len() == n,
            "{n} lattice vertices, but {} positions and room for {}",
            deformed.len(),
            corrected.len()
        );
        let scales = self.scales(&workspace.regional);
        let lambda = of_vertex(&workspace.lambdas, &self.adjacency);
        let points = deformed.iter().zip(&workspace.scratch.points);
        for (i, (corrected, (deformed, point))) in corrected.iter_mut().zip(points).enumerate() {
            let scale = lambda(i as u32) as f32 + scales.map_or(0.0, |scales| scales[i]);
            let v = point.direction();
            *corrected = std::array::from_fn(|k| deformed[k] + scale * v[k]);
        }
        workspace.limits.write(&lambda, deformed, corrected);
        &workspace.reports
    }

    /// The scale of each vertex, with the scope `regional`.
    fn scales<'w>(&self, regional: &'w RegionalScratch) -> Option<&'w [f32]> {
        self.regional.as_ref().map(|_| &*regional.scales)
    }

    fn turn_field(&self, workspace: &mut CorrectionWorkspace, rotations: &[[f32; 4]]) {
        for (point, (q, v)) in
            workspace.scratch.points.iter_mut().zip(rotations.iter().zip(&self.field.directions))
        {
            point.set_direction(turned(q, v));
        }
        if let Some(ramp) = workspace.ramp.as_ref().filter(|ramp| ramp.is_of(&self.adjacency)) {
            for (point, share) in workspace.scratch.points.iter_mut().zip(&ramp.shares) {
                point.set_direction(point.direction().map(|v| v * share));
            }
        }
    }

    /// One cubic for each component.
    fn solve_cubics(&self, workspace: &mut CorrectionWorkspace, executor: &Executor) {
        self.measure.evaluate(executor, &mut workspace.scratch);
        for component in 0..self.rest.len() {
            let c = workspace.scratch.coefficients[component];
            let root = smallest_root([c[0] - self.rest[component], c[1], c[2], c[3]], self.caps[component]);
            workspace.lambdas[component] = root.lambda;
            self.report(workspace, component, root.residual);
        }
    }

    /// Reports by how much, in cubed cells, the volume of a component is then off.
    fn report(&self, workspace: &mut CorrectionWorkspace, component: usize, left: f64) {
        let (unit, rest) = (self.cell_size.powi(3), self.rest[component]);
        let residual = left / rest;
        workspace.reports[component] = ComponentReport {
            rest: rest * unit,
            before: workspace.reports[component].before,
            after: (rest + left) * unit,
            lambda: workspace.lambdas[component] * self.cell_size,
            residual,
            capped: residual.abs() > KEPT,
        };
    }
}

/// The `lambda` of each vertex: that of its component.
fn of_vertex(lambdas: &[f64], adjacency: &Adjacency) -> impl Fn(u32) -> f64 {
    |vertex| lambdas[adjacency.component(vertex as usize)]
}
