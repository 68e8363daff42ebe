//! Computes the errors of a motion. They do not depend on the volume correction.

use nalgebra::Vector3;
use supple::reference::{Naive, Regions};

use super::flight::{self, Free};
use super::motion::{Motion, is_sampled, visits};
use super::physical::Physical;
use super::point::{Distances, Path};
use super::setting::{Dynamics, Method, Setting, Sums};
use crate::error::Halt;
use crate::observer::Meter;

/// Limits of the work of the naive sums, in visits. A visit is a pair of a region and a vertex in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    /// Limit for the motion of all bodies.
    pub(super) path: f64,
    /// Limit for the goal positions in one frame.
    pub(super) goals: f64,
}

/// Minimum fraction of the frames that the budget must allow; otherwise no path is compared.
const MIN_FRACTION: f64 = 0.25;
/// Number of frames at which goal positions are compared.
const GOAL_SAMPLES: u32 = 4;

/// Errors of a motion.
#[derive(Clone, Debug, Default)]
pub(super) struct Errors {
    pub(super) goals: Option<Distances>,
    pub(super) path: Option<Path>,
    pub(super) free: Option<Free>,
}

/// Vertex positions of each body.
type Positions = Vec<Vec<Vector3<f64>>>;
/// Positions in each frame from frame 1 on, computed by naive sums over staircase regions.
type NaivePath = Vec<Positions>;

/// Computes the errors of motions. Caches the motions that are computed by naive sums.
#[derive(Debug)]
pub(super) struct ErrorEvaluator {
    budget: Budget,
    paths: Vec<(Dynamics, NaivePath)>,
}

impl ErrorEvaluator {
    pub(super) fn new(budget: Budget) -> Self {
        Self { budget, paths: Vec::new() }
    }

    /// Returns the number of frames for which the budget allows naive sums, or 0 if they are less than
    /// [`MIN_FRACTION`] of all frames. `visits` is the number of visits per step.
    pub(super) fn frames(&self, physical: &Physical, visits: f64, substeps: u32) -> u32 {
        let frames = physical.scene().simulation.frames;
        let affordable = self.budget.path / (visits * f64::from(substeps));
        let compared = affordable.min(f64::from(frames)).floor();
        if compared < MIN_FRACTION * f64::from(frames) { 0 } else { compared as u32 }
    }

    /// Computes the errors of a motion.
    pub(super) fn errors(
        &mut self,
        physical: &Physical,
        dynamics: Dynamics,
        meter: &mut Meter<'_>,
    ) -> Result<Errors, Halt> {
        let setting = Setting { dynamics, method: Method::off() };
        let model = physical.prepare(&setting)?;
        let visits = visits(&model.simulation);
        let compared = self.frames(physical, visits, dynamics.substeps);
        let frames = physical.scene().simulation.frames;
        // A naive motion stops at the last compared frame.
        let last = if dynamics.sums == Sums::Fast { frames } else { compared };
        if last == 0 {
            return Ok(Errors::default());
        }
        let budget = self.budget;
        let path = self.path(physical, dynamics, compared, meter)?;
        let mut motion = Motion::new(physical.prepare(&setting)?, &model, physical.scene(), dynamics.sums)?;
        let (mut goals, mut path_sums) = (DistanceSums::default(), DistanceSums::default());
        for frame in 1..=last {
            motion.frame()?;
            meter.tick()?;
            let positions = |body| motion.positions(body);
            for (body, model) in model.simulation.bodies().iter().enumerate() {
                let cell_size = model.lattice().cell_size();
                if let Some(at) = path.get(frame as usize - 1) {
                    path_sums.add(&positions(body), &at[body], cell_size);
                }
                if is_sampled(frame, frames, GOAL_SAMPLES) && visits <= budget.goals {
                    let naive = Naive::new(model.lattice(), model.half_width(), Regions::Staircase)
                        .with_material_of(model)
                        .with_masses(motion.fit_masses(body));
                    let motions = naive.motions(&positions(body));
                    goals.add(&motion.goals(body), &naive.goals(&motions), cell_size);
                }
            }
        }
        let path = path_sums.distances().map(|distances| Path { frames: compared, distances });
        let free = match dynamics.sums {
            Sums::Fast => Some(flight::measure(physical, dynamics, budget.goals, meter)?),
            Sums::Naive(_) => None,
        };
        Ok(Errors { goals: goals.distances(), path, free })
    }

    /// Returns the positions in the first `frames` frames, computed by naive sums or taken from the cache.
    /// For 0 frames no naive bodies are built, because their lists of regions can exceed the memory.
    fn path(
        &mut self,
        physical: &Physical,
        dynamics: Dynamics,
        frames: u32,
        meter: &mut Meter<'_>,
    ) -> Result<&[Positions], Halt> {
        if frames == 0 {
            return Ok(&[]);
        }
        let dynamics = Dynamics { sums: Sums::Naive(Regions::Staircase), ..dynamics };
        let cached =
            self.paths.iter().position(|(other, path)| *other == dynamics && path.len() == frames as usize);
        let index = match cached {
            Some(index) => index,
            None => {
                let setting = Setting { dynamics, method: Method::off() };
                let model = physical.prepare(&setting)?;
                let mut motion =
                    Motion::new(physical.prepare(&setting)?, &model, physical.scene(), dynamics.sums)?;
                let mut path = NaivePath::new();
                for _ in 0..frames {
                    motion.frame()?;
                    meter.tick()?;
                    path.push(
                        (0..model.simulation.bodies().len()).map(|body| motion.positions(body)).collect(),
                    );
                }
                self.paths.push((dynamics, path));
                self.paths.len() - 1
            }
        };
        Ok(&self.paths[index].1)
    }
}

/// Accumulates the statistics of distances, in scene units and in cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DistanceSums {
    squares: f64,
    squares_cells: f64,
    count: usize,
    max: f64,
    max_cells: f64,
}

impl DistanceSums {
    /// Adds the distances of corresponding points of a body with cells of edge `cell_size`.
    pub(super) fn add(&mut self, a: &[Vector3<f64>], b: &[Vector3<f64>], cell_size: f64) {
        for (a, b) in a.iter().zip(b) {
            let distance_squared = (a - b).norm_squared();
            self.squares += distance_squared;
            self.squares_cells += distance_squared / (cell_size * cell_size);
            self.max = self.max.max(distance_squared.sqrt());
            self.max_cells = self.max_cells.max(distance_squared.sqrt() / cell_size);
        }
        self.count += a.len();
    }

    /// Returns the statistics, or `None` if no distances were added.
    pub(super) fn distances(&self) -> Option<Distances> {
        let rms = |squares: f64| (squares / self.count as f64).sqrt();
        (self.count > 0).then(|| Distances {
            rms_cells: rms(self.squares_cells),
            max_cells: self.max_cells,
            rms: rms(self.squares),
            max: self.max,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests as block;

    #[test]
    fn naive_sums_over_budget_are_not_built() {
        let (_directory, physical) = block::physical(4, &[1]);
        let errors = |path, dynamics| {
            let mut evaluator = ErrorEvaluator::new(Budget { path, goals: f64::INFINITY });
            let errors = evaluator.errors(&physical, dynamics, &mut Meter::new(&mut (), 1.0)).unwrap();
            (errors, evaluator.paths.len())
        };
        let (none, built) = errors(0.0, block::FAST);
        assert_eq!((none.path, built), (None, 0));
        assert!(none.goals.is_some() && none.free.is_some());
        let (none, built) = errors(0.0, block::NAIVE);
        assert!(none.goals.is_none() && none.path.is_none() && built == 0);
        let (all, built) = errors(f64::INFINITY, block::FAST);
        assert_eq!((all.path.map(|path| path.frames), built), (Some(4), 1));
    }

    /// Also with regions of one cell, of which those at the surface are partly filled.
    #[test]
    fn the_naive_sums_of_a_scene_compute_the_motion_of_the_library() {
        for keys in ["half_width = 2", "half_width = 0.5", "youngs_modulus = 3e7\naccuracy = \"exact\""] {
            let (_directory, physical) = block::physical_with("substeps = 2", 4, &[keys]);
            let mut evaluator = ErrorEvaluator::new(Budget { path: f64::INFINITY, goals: f64::INFINITY });
            let errors = evaluator.errors(&physical, block::FAST, &mut Meter::new(&mut (), 1.0)).unwrap();
            // Goal positions round by up to 1e-5 cells, in eight steps.
            for distances in [errors.goals.unwrap(), errors.path.unwrap().distances] {
                assert!(distances.max_cells < 1e-4, "{keys}: {distances:?}");
            }
        }
    }
}
