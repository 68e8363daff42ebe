//! The volume-preserving correction of a deformed lattice.

use super::adjacency::Adjacency;
use super::centre::Centres;
use super::constraints::{self, Push};
use super::cubic::smallest_root;
use super::field::{Field, turned};
use super::limits::{Limit, Limits};
use super::line::Moving;
use super::measure::{self, Measure};
use super::regional::Regional;
use super::surface::Surface;
use super::{ComponentReport, VolumeError, VolumeMeasure, VolumeOptions, VolumeScope};
use crate::lattice::Lattice;
use crate::parallel::Executor;

/// A volume off by less than this part of itself counts as kept: what positions in `f32` let one ask for.
const KEPT: f64 = 1e-6;

/// How often those beside an obstacle are told apart anew from those that are free. Three to five are common; what the
/// last leaves is in the residual.
const LIMITED_PASSES: usize = 8;

/// Moves the vertices of a deformed lattice along a field until the volume is that at rest: equation (1) of
/// Takamatsu & Kanai (2009), `vol(P^ + lambda V) = vol(P)`. With the scope `regional` they first move by a scale of
/// their own each.
///
/// It owns its parameters and its scratch, and is a function of what it is given: no call leaves a trace in the next.
#[derive(Clone, Debug)]
pub struct Correction {
    measure: Measure,
    field: Field,
    adjacency: Adjacency,
    cell_size: f64,
    ramp_links: u32,
    /// Of each component: volume at rest in cells, and the cap on `lambda` in cells.
    rest: Vec<f64>,
    caps: Vec<f64>,
    /// What held vertices leave of the field; none if nothing is held.
    ramp: Option<Vec<f32>>,
    regional: Option<Regional>,
    centres: Centres,
    points: Vec<Moving>,
    coefficients: Vec<[f64; 4]>,
    order: Vec<(u32, u32)>,
    limits: Limits,
    lambdas: Vec<f64>,
    reports: Vec<ComponentReport>,
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
        let adjacency = measure::adjacency(lattice);
        let Some(mut measure) = Measure::choose(options.measure, lattice, surface, &adjacency)? else {
            return Ok(None);
        };
        let field = Field::new(options.field, lattice, surface, &adjacency);
        let components = adjacency.components();
        let mut centres = Centres::new(components);
        let mut points = vec![Moving::default(); lattice.len()];
        let mut coefficients = vec![[0.0; 4]; components];
        centres.at_rest(lattice.indices(), adjacency.of_vertex(), &mut points);
        measure.coefficients(&Executor::sequential(), &points, &mut coefficients);
        let regional = (options.scope == VolumeScope::Regional).then(|| {
            for (point, direction) in points.iter_mut().zip(&field.directions) {
                point.set_direction(*direction);
            }
            Regional::new(&adjacency, &points)
        });
        Ok(Some(Self {
            measure,
            regional,
            cell_size: lattice.cell_size(),
            ramp_links: field.thickness.iter().fold(2.0, |links: f64, depth| links.max((depth / 2.0).ceil()))
                as u32,
            rest: coefficients.iter().map(|c| c[0]).collect(),
            caps: field.thickness.iter().map(|thickness| thickness * most).collect(),
            ramp: None,
            centres,
            points,
            coefficients,
            order: Vec::new(),
            limits: Limits::default(),
            lambdas: vec![0.0; components],
            reports: vec![ComponentReport::default(); components],
            field,
            adjacency,
        }))
    }

    /// The measure whose value is kept.
    pub fn measure(&self) -> VolumeMeasure {
        self.measure.kind()
    }

    /// Memory that it takes: the field, the measure, the links, and its scratch.
    pub fn bytes(&self) -> usize {
        let ramp = self.ramp.as_deref().map_or(0, size_of_val);
        let field = size_of_val(&*self.field.directions) + ramp;
        let regional = self.regional.as_ref().map_or(0, Regional::bytes);
        let scratch = size_of_val(&*self.points) + self.limits.bytes();
        scratch + field + self.measure.bytes() + regional + self.adjacency.bytes()
    }

    /// Says which lattice vertices are held by pins and handles from now on: the correction leaves them in place, and
    /// fades in beside them. To be called when they change; allocates.
    pub fn hold(&mut self, held: &[u32]) {
        self.ramp = (!held.is_empty()).then(|| constraints::ramp(&self.adjacency, held, self.ramp_links));
    }

    /// Corrects a deformed lattice: `corrected = deformed + lambda V`. Allocates nothing, once the room for as many
    /// pushes has been made.
    ///
    /// * `deformed`, `corrected`: (n, 3), lattice vertices in cells, body-local; any distance from the origin.
    /// * `rotations`: (n, 4), quaternions (x, y, z, w) that turn the model's frame to that of `deformed`; for the
    ///   field to fit, those of `deformed` itself.
    /// * `pushes`: external forces of contacts and grabs, in any order; see [`Push`].
    ///
    /// Returns one report a component of the lattice, in units of length. Finite positions never give NaN.
    ///
    /// # Panics
    /// If the lengths differ from the lattice's, or a push names a vertex that it does not have.
    pub fn apply(
        &mut self,
        deformed: &[[f32; 3]],
        rotations: &[[f32; 4]],
        pushes: &[Push],
        corrected: &mut [[f32; 3]],
    ) -> &[ComponentReport] {
        self.solve(&Executor::sequential(), deformed, rotations, pushes);
        self.write(deformed, corrected)
    }

    /// Finds how far each vertex is to move; arguments as those of [`Correction::apply`].
    pub(crate) fn solve(
        &mut self,
        executor: &Executor,
        deformed: &[[f32; 3]],
        rotations: &[[f32; 4]],
        pushes: &[Push],
    ) {
        let n = self.points.len();
        assert!(
            deformed.len() == n && rotations.len() == n,
            "{n} lattice vertices, but {} positions and {} rotations",
            deformed.len(),
            rotations.len(),
        );
        self.limits.clear();
        self.centres.centred(deformed, self.adjacency.of_vertex(), &mut self.points);
        self.turn_field(rotations);
        constraints::take_out_pushes(pushes, &mut self.order, &mut self.points);
        if let Some(regional) = &mut self.regional {
            regional.give_back(executor, &self.adjacency, &self.caps, &mut self.points);
        }
        self.solve_cubics(executor);
        let unit = self.cell_size.powi(3);
        for (report, c) in self.reports.iter_mut().zip(&self.coefficients) {
            report.before = c[0] * unit;
        }
    }

    /// The farthest that a vertex is to move, in cells.
    pub(crate) fn reach(&self) -> f64 {
        let lambda = of_vertex(&self.lambdas, &self.adjacency);
        let scales = self.regional.as_ref().map(Regional::scales);
        let way = |(i, point): (usize, &Moving)| {
            let scale = lambda(i as u32) + scales.map_or(0.0, |s| f64::from(s[i]));
            let square: f64 = point.direction().iter().map(|&v| f64::from(v).powi(2)).sum();
            scale.abs() * square.sqrt()
        };
        self.points.iter().enumerate().map(way).fold(0.0, f64::max)
    }

    /// Solves again with these limits: who would pass one goes along it at the end of its room, and the others make
    /// good for that. An active set, in which the volume stays an exact cubic.
    pub(crate) fn limit(&mut self, executor: &Executor, limits: &[Limit]) {
        self.limits.begin(limits, &mut self.points, self.regional.as_ref().map(Regional::scales));
        for _ in 0..LIMITED_PASSES {
            if !self.limits.divert(of_vertex(&self.lambdas, &self.adjacency), &mut self.points) {
                return;
            }
            self.solve_cubics(executor);
        }
        self.settle(executor);
    }

    /// Leaves `lambda` as it is and measures what it gives.
    fn settle(&mut self, executor: &Executor) {
        self.limits.divert(of_vertex(&self.lambdas, &self.adjacency), &mut self.points);
        self.measure.coefficients(executor, &self.points, &mut self.coefficients);
        for component in 0..self.rest.len() {
            let [c0, c1, c2, c3] = self.coefficients[component];
            let lambda = self.lambdas[component];
            let volume = c0 + lambda * (c1 + lambda * (c2 + lambda * c3));
            self.report(component, volume - self.rest[component]);
        }
    }

    /// Moves the vertices as far as was found: `corrected = deformed + lambda V`. Returns one report a component.
    ///
    /// # Panics
    /// If the lengths differ from the lattice's.
    pub(crate) fn write(&mut self, deformed: &[[f32; 3]], corrected: &mut [[f32; 3]]) -> &[ComponentReport] {
        let n = self.points.len();
        assert!(
            deformed.len() == n && corrected.len() == n,
            "{n} lattice vertices, but {} positions and room for {}",
            deformed.len(),
            corrected.len()
        );
        let scales = self.regional.as_ref().map(Regional::scales);
        let lambda = of_vertex(&self.lambdas, &self.adjacency);
        for (i, (corrected, deformed)) in corrected.iter_mut().zip(deformed).enumerate() {
            let scale = lambda(i as u32) as f32 + scales.map_or(0.0, |scales| scales[i]);
            let v = self.points[i].direction();
            *corrected = std::array::from_fn(|k| deformed[k] + scale * v[k]);
        }
        self.limits.write(&lambda, deformed, corrected);
        &self.reports
    }

    fn turn_field(&mut self, rotations: &[[f32; 4]]) {
        let turned = rotations.iter().zip(&self.field.directions).map(|(q, v)| turned(q, v));
        for (point, direction) in self.points.iter_mut().zip(turned) {
            point.set_direction(direction);
        }
        for (point, share) in self.points.iter_mut().zip(self.ramp.iter().flatten()) {
            point.set_direction(point.direction().map(|v| v * share));
        }
    }

    /// One cubic for each component.
    fn solve_cubics(&mut self, executor: &Executor) {
        self.measure.coefficients(executor, &self.points, &mut self.coefficients);
        for component in 0..self.rest.len() {
            let c = self.coefficients[component];
            let root = smallest_root([c[0] - self.rest[component], c[1], c[2], c[3]], self.caps[component]);
            self.lambdas[component] = root.lambda;
            self.report(component, root.residual);
        }
    }

    /// Says by how much, in cubed cells, the volume of a component is then off.
    fn report(&mut self, component: usize, left: f64) {
        let (unit, rest) = (self.cell_size.powi(3), self.rest[component]);
        let residual = left / rest;
        self.reports[component] = ComponentReport {
            rest: rest * unit,
            before: self.reports[component].before,
            after: (rest + left) * unit,
            lambda: self.lambdas[component] * self.cell_size,
            residual,
            capped: residual.abs() > KEPT,
        };
    }
}

/// The `lambda` of each vertex: that of its component.
fn of_vertex(lambdas: &[f64], adjacency: &Adjacency) -> impl Fn(u32) -> f64 {
    |vertex| lambdas[adjacency.component(vertex as usize)]
}
