//! Measures the points of a study.

use std::path::Path;

use supple_io::run::Prepared;

use super::display::{self, Surfaces};
use super::matrix::Matrix;
use super::motion::visits;
use super::motion_errors::{Budget, ErrorEvaluator, Errors as Motion};
use super::physical::Physical;
use super::point::{Errors, Point};
use super::report::Report;
use super::setting::{Axis, Dynamics, Method, Setting, Sums};
use crate::elasticity::alpha;
use crate::error::Halt;
use crate::observer::{Meter, Observer};
use crate::timing::Timing;

/// Limits of a study: the number of timed runs of a point, and the budget of the naive sums.
struct Limits {
    repeats: u32,
    budget: Budget,
}

impl Limits {
    fn new(quick: bool) -> Self {
        match quick {
            false => Self { repeats: 5, budget: Budget { path: 8e8, goals: 3e7 } },
            true => Self { repeats: 3, budget: Budget { path: 6e7, goals: 2e6 } },
        }
    }
}

/// Approximate seconds per visit of the naive sums, for the estimate of the remaining time.
const VISIT: f64 = 2e-8;
/// Approximate seconds per step and lattice vertex.
const STEP: f64 = 5e-8;
/// Approximate seconds per evaluated frame and lattice vertex.
const EVALUATION: f64 = 1e-7;

/// Measures the points of a study.
pub(super) struct Points {
    physical: Physical,
    matrix: Matrix,
    limits: Limits,
    /// Surfaces of the finest lattice; `None` until they are computed.
    finest: Option<Surfaces>,
}

impl Points {
    /// Creates the measurement of all points of a matrix.
    pub(super) fn new(physical: Physical, matrix: Matrix, quick: bool) -> Self {
        Self { physical, matrix, limits: Limits::new(quick), finest: None }
    }

    /// Measures the points that the report does not contain yet.
    pub(super) fn run(
        &mut self,
        report: &mut Report,
        directory: &Path,
        observer: &mut dyn Observer,
    ) -> Result<(), Halt> {
        let mut unmeasured: Vec<(Axis, Setting)> = self.matrix.points.clone();
        unmeasured.retain(|(_, setting)| !report.has(&self.physical.name(setting)));
        let mut computed: Vec<(Dynamics, Motion)> = Vec::new();
        let weights: f64 = unmeasured.iter().map(|(_, setting)| self.weight(setting)).sum();
        let mut meter = Meter::new(observer, weights + self.weight(&self.matrix.finest));
        let mut evaluator = ErrorEvaluator::new(self.limits.budget);
        for (axis, setting) in unmeasured {
            if self.finest.is_none() {
                self.finest = Some(self.reference(&mut meter)?);
            }
            let runs = f64::from(self.limits.repeats + 3);
            meter.begin(
                self.physical.name(&setting),
                self.weight(&setting),
                runs * f64::from(report.frames),
            )?;
            let motion = match computed.iter().find(|(dynamics, _)| *dynamics == setting.dynamics) {
                Some((_, motion)) => motion.clone(),
                None => {
                    let motion = evaluator.errors(&self.physical, setting.dynamics, &mut meter)?;
                    computed.push((setting.dynamics, motion.clone()));
                    motion
                }
            };
            let point = self.measure(axis, &setting, motion, &evaluator, &mut meter)?;
            report.add(point, directory)?;
        }
        Ok(())
    }

    /// Computes the surfaces of the finest lattice.
    fn reference(&self, meter: &mut Meter<'_>) -> Result<Surfaces, Halt> {
        let (finest, frames) = (self.matrix.finest, self.physical.scene().simulation.frames);
        meter.begin(
            format!("{}, reference surface", self.physical.name(&finest)),
            self.weight(&finest),
            f64::from(frames),
        )?;
        let model = self.model(&finest)?;
        Ok(display::run(&self.physical, &finest, &model, frames, meter)?.surfaces)
    }

    /// Builds a point without a volume correction.
    fn model(&self, setting: &Setting) -> Result<Prepared, Halt> {
        Ok(self.physical.prepare(&Setting { method: Method::off(), ..*setting })?)
    }

    /// Estimates the run time of a point, in seconds.
    fn weight(&self, setting: &Setting) -> f64 {
        let Setting { dynamics, .. } = *setting;
        let frames = f64::from(self.physical.scene().simulation.frames);
        let (vertices, visits) = self.physical.estimate(dynamics);
        let runs = f64::from(self.limits.repeats + 3);
        let fast = vertices * frames * runs * (STEP * f64::from(dynamics.substeps) + EVALUATION);
        let naive = (visits * f64::from(dynamics.substeps) * frames).min(self.limits.budget.path);
        // The errors of the motion are computed once for all methods; their cost is assigned to the method of
        // the scene.
        let is_computed_elsewhere = setting.method != self.matrix.finest.method;
        fast + if is_computed_elsewhere { 0.0 } else { VISIT * naive }
    }

    /// Measures one point.
    fn measure(
        &self,
        axis: Axis,
        setting: &Setting,
        motion: Motion,
        evaluator: &ErrorEvaluator,
        meter: &mut Meter<'_>,
    ) -> Result<Point, Halt> {
        let prepared = self.model(setting)?;
        let (dt, frames) = (prepared.simulation.dt(), self.physical.scene().simulation.frames);
        let affordable =
            evaluator.frames(&self.physical, visits(&prepared.simulation), setting.dynamics.substeps);
        let first = prepared.simulation.body(0);
        // Naive sums make one run, which ends at the last frame that the budget allows.
        let naive = setting.dynamics.sums != Sums::Fast;
        let frames = if naive { affordable.max(1) } else { frames };
        let measured = display::run(&self.physical, setting, &prepared, frames, meter)?;
        let timing = match naive {
            true => Timing::new(None, vec![measured.sample]),
            false => Timing::new(
                Some(measured.sample),
                display::time(&self.physical, setting, self.limits.repeats, meter)?,
            ),
        };
        let whole = frames == self.physical.scene().simulation.frames;
        let finest = self.finest.as_ref().filter(|_| whole);
        let bodies = prepared.simulation.bodies();
        let distances = finest.map(|finest| display::surface_distance(bodies, &measured.surfaces, finest));
        let volumes = match whole {
            true => measured.errors,
            false => Errors { capped: measured.errors.capped, ..Errors::default() },
        };
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        Ok(Point {
            name: self.physical.name(setting),
            axis,
            method: setting.method.name(),
            sums: setting.dynamics.sums.name().to_owned(),
            lattice_vertices: bodies.iter().map(|body| body.lattice().len()).sum(),
            cell_size: first.lattice().cell_size(),
            half_width: first.half_width(),
            region_factor: setting.dynamics.region_factor,
            substeps: setting.dynamics.substeps,
            alpha: alpha(&first, dt),
            softened: self.physical.softened(setting.dynamics, dt),
            finest: *setting == self.matrix.finest,
            timing,
            errors: Errors {
                goals: motion.goals,
                path: motion.path,
                surface_rms: distances.and_then(|(rms, _)| finite(rms)),
                surface_hausdorff: distances.and_then(|(_, hausdorff)| finite(hausdorff)),
                ..volumes
            },
            free: motion.free,
            front: Vec::new(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::point::Front;
    use crate::scene::tests as block;

    #[test]
    fn naive_sums_over_part_of_the_motion_are_on_no_front() {
        let (_directory, physical) = block::physical(4, &[1]);
        let finest = Setting { dynamics: block::FAST, method: Method::off() };
        let setting = Setting { dynamics: block::NAIVE, method: Method::off() };
        let frame = visits(&physical.prepare(&finest).unwrap().simulation) * f64::from(block::NAIVE.substeps);
        let measured = |frames: f64| {
            let matrix = Matrix { points: Vec::new(), finest };
            let mut points = Points::new(physical.clone(), matrix, true);
            points.limits.budget = Budget { path: frames * frame, goals: 0.0 };
            let mut observer = ();
            let mut meter = Meter::new(&mut observer, 1.0);
            points.finest = Some(points.reference(&mut meter).unwrap());
            let mut evaluator = ErrorEvaluator::new(points.limits.budget);
            let motion = evaluator.errors(&physical, block::NAIVE, &mut meter).unwrap();
            points.measure(Axis::Sums, &setting, motion, &evaluator, &mut meter).unwrap()
        };
        let fronts = [Front::Surface, Front::Volume, Front::Cells];
        let whole = measured(4.5);
        assert_eq!(whole.errors.path.unwrap().frames, 4);
        assert!(fronts.iter().all(|front| front.error(&whole) > Some(0.0)), "{whole:?}");
        let part = measured(2.5);
        assert_eq!(part.errors.path.unwrap().frames, 2);
        assert!(fronts.iter().all(|front| front.error(&part).is_none()), "{part:?}");
        let none = measured(0.5);
        assert!(Front::ALL.iter().all(|front| front.error(&none).is_none()), "{none:?}");
        assert!(none.timing.total.median > 0.0);
    }
}
