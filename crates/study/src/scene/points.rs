//! The points of a study under way.

use std::path::Path;

use supple_io::run::Prepared;

use super::display::{self, Surfaces};
use super::matrix::Matrix;
use super::motion::visits;
use super::motion_errors::{Budget, Errors as Motion, Judge};
use super::physical::Physical;
use super::point::{Errors, Point};
use super::report::Report;
use super::setting::{Axis, Dynamics, Method, Setting, Sums};
use crate::error::Halt;
use crate::observer::{Meter, Observer};
use crate::timing::Timing;

/// How often things are done, and how much the naive sums may take.
struct Suite {
    repeats: u32,
    budget: Budget,
}

impl Suite {
    fn new(quick: bool) -> Self {
        match quick {
            false => Self { repeats: 5, budget: Budget { path: 8e8, goals: 3e7 } },
            true => Self { repeats: 3, budget: Budget { path: 6e7, goals: 2e6 } },
        }
    }
}

/// A visit of a vertex by a region, and a step and a look at a vertex, in seconds: for the time left, no more.
const VISIT: f64 = 2e-8;
const STEP: f64 = 5e-8;
const LOOK: f64 = 1e-7;

/// The points of a study under way.
pub(super) struct Points {
    physical: Physical,
    matrix: Matrix,
    suite: Suite,
    /// The surfaces of the finest lattice.
    finest: Option<Surfaces>,
}

impl Points {
    /// None of them measured.
    pub(super) fn new(physical: Physical, matrix: Matrix, quick: bool) -> Self {
        Self { physical, matrix, suite: Suite::new(quick), finest: None }
    }

    /// Measures what is not there yet.
    pub(super) fn run(
        &mut self,
        report: &mut Report,
        directory: &Path,
        observer: &mut dyn Observer,
    ) -> Result<(), Halt> {
        let left: Vec<(Axis, Setting)> = self.matrix.points.clone();
        let left: Vec<_> =
            left.into_iter().filter(|(_, setting)| !report.has(&self.physical.name(setting))).collect();
        let mut known: Vec<(Dynamics, Motion)> = Vec::new();
        let weights: f64 = left.iter().map(|(_, setting)| self.weight(setting)).sum();
        let mut meter = Meter::new(observer, weights + self.weight(&self.matrix.finest));
        let mut judge = Judge::new(self.suite.budget);
        for (axis, setting) in left {
            if self.finest.is_none() {
                self.finest = Some(self.reference(&mut meter)?);
            }
            let runs = f64::from(self.suite.repeats + 3);
            meter.begin(
                self.physical.name(&setting),
                self.weight(&setting),
                runs * f64::from(report.frames),
            )?;
            let motion = match known.iter().find(|(dynamics, _)| *dynamics == setting.dynamics) {
                Some((_, motion)) => motion.clone(),
                None => {
                    let motion = judge.errors(&self.physical, setting.dynamics, &mut meter)?;
                    known.push((setting.dynamics, motion.clone()));
                    motion
                }
            };
            let point = self.measure(axis, &setting, motion, &judge, &mut meter)?;
            report.add(point, directory)?;
        }
        Ok(())
    }

    /// The surfaces of the finest lattice.
    fn reference(&self, meter: &mut Meter<'_>) -> Result<Surfaces, Halt> {
        let (finest, frames) = (self.matrix.finest, self.physical.scene().simulation.frames);
        meter.begin(
            format!("{}, to compare with", self.physical.name(&finest)),
            self.weight(&finest),
            f64::from(frames),
        )?;
        let model = self.model(&finest)?;
        Ok(display::run(&self.physical, &finest, &model, frames, meter)?.surfaces)
    }

    /// A point without a correction: its lattices, where they are at the start.
    fn model(&self, setting: &Setting) -> Result<Prepared, Halt> {
        Ok(self.physical.prepare(&Setting { method: Method::off(), ..*setting })?)
    }

    /// About how long a point takes.
    fn weight(&self, setting: &Setting) -> f64 {
        let Setting { dynamics, .. } = *setting;
        let frames = f64::from(self.physical.scene().simulation.frames);
        let (vertices, visits) = self.physical.estimate(dynamics);
        let runs = f64::from(self.suite.repeats + 3);
        let fast = vertices * frames * runs * (STEP * f64::from(dynamics.substeps) + LOOK);
        let naive = (visits * f64::from(dynamics.substeps) * frames).min(self.suite.budget.path);
        let shared = setting.method != self.matrix.finest.method;
        fast + if shared { 0.0 } else { VISIT * naive }
    }

    fn measure(
        &self,
        axis: Axis,
        setting: &Setting,
        motion: Motion,
        judge: &Judge,
        meter: &mut Meter<'_>,
    ) -> Result<Point, Halt> {
        let prepared = self.model(setting)?;
        let (dt, frames) = (prepared.simulation.dt(), self.physical.scene().simulation.frames);
        let followed = judge.frames(&self.physical, visits(&prepared.simulation), setting.dynamics.substeps);
        let first = prepared.simulation.body(0);
        // The naive sums make one run, as far as they are followed.
        let naive = setting.dynamics.sums != Sums::Fast;
        let frames = if naive { followed.max(1) } else { frames };
        let shown = display::run(&self.physical, setting, &prepared, frames, meter)?;
        let timing = match naive {
            true => Timing::new(None, vec![shown.sample]),
            false => Timing::new(
                Some(shown.sample),
                display::time(&self.physical, setting, self.suite.repeats, meter)?,
            ),
        };
        let whole = frames == self.physical.scene().simulation.frames;
        let finest = self.finest.as_ref().filter(|_| whole);
        let bodies = prepared.simulation.bodies();
        let beside = finest.map(|finest| display::beside(bodies, &shown.surfaces, finest));
        let volumes = match whole {
            true => shown.errors,
            false => Errors { capped: shown.errors.capped, ..Errors::default() },
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
            alpha: first.material().alpha(dt),
            softened: self.physical.softened(dt),
            finest: *setting == self.matrix.finest,
            timing,
            errors: Errors {
                goals: motion.goals,
                path: motion.path,
                surface_rms: beside.and_then(|(rms, _)| finite(rms)),
                surface_hausdorff: beside.and_then(|(_, hausdorff)| finite(hausdorff)),
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
    fn part_of_a_motion_is_on_no_front_of_the_whole() {
        let (_folder, physical) = block::physical(4, &[1]);
        let finest = Setting { dynamics: block::FAST, method: Method::off() };
        let setting = Setting { dynamics: block::NAIVE, method: Method::off() };
        let frame = visits(&physical.prepare(&finest).unwrap().simulation) * f64::from(block::NAIVE.substeps);
        let measured = |frames: f64| {
            let matrix = Matrix { points: Vec::new(), finest };
            let mut points = Points::new(physical.clone(), matrix, true);
            points.suite.budget = Budget { path: frames * frame, goals: 0.0 };
            let mut nobody = ();
            let mut meter = Meter::new(&mut nobody, 1.0);
            points.finest = Some(points.reference(&mut meter).unwrap());
            let mut judge = Judge::new(points.suite.budget);
            let motion = judge.errors(&physical, block::NAIVE, &mut meter).unwrap();
            points.measure(Axis::Sums, &setting, motion, &judge, &mut meter).unwrap()
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
