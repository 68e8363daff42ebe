//! The errors of the motion, which points that differ in the correction alone share.

use nalgebra::Vector3;
use supple::reference::{Naive, Regions};

use super::flight::{self, Free};
use super::motion::{Motion, is_moment, visits};
use super::physical::Physical;
use super::point::{Distances, Path};
use super::setting::{Dynamics, Method, Setting, Sums};
use crate::error::Halt;
use crate::observer::Meter;

/// How much work the naive sums may take, in visits of a vertex by a region.
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget {
    /// For the path of a body through a motion.
    pub(super) path: f64,
    /// For the goal positions at one moment.
    pub(super) goals: f64,
}

/// A path is not worth comparing with over less than this share of the frames.
const LEAST_SHARE: f64 = 0.25;
/// Moments at which goal positions are compared.
const GOALS: u32 = 4;

/// The errors of the motion.
#[derive(Clone, Debug, Default)]
pub(super) struct Errors {
    pub(super) goals: Option<Distances>,
    pub(super) path: Option<Path>,
    pub(super) free: Option<Free>,
}

/// For each body, its vertices.
type Moment = Vec<Vec<Vector3<f64>>>;
/// Where the naive sums, over staircase regions, take the bodies: for each frame from 1 on.
type NaivePath = Vec<Moment>;

/// Works out the errors of motions; keeps the paths of the naive sums.
#[derive(Debug)]
pub(super) struct Judge {
    budget: Budget,
    paths: Vec<(Dynamics, NaivePath)>,
}

impl Judge {
    pub(super) fn new(budget: Budget) -> Self {
        Self { budget, paths: Vec::new() }
    }

    /// The frames through which the naive sums can be followed; 0 if these are too few.
    pub(super) fn frames(&self, physical: &Physical, visits: f64, substeps: u32) -> u32 {
        let frames = physical.scene().simulation.frames;
        let affordable = self.budget.path / (visits * f64::from(substeps));
        let followed = affordable.min(f64::from(frames)).floor();
        if followed < LEAST_SHARE * f64::from(frames) { 0 } else { followed as u32 }
    }

    /// The errors of a motion.
    pub(super) fn errors(
        &mut self,
        physical: &Physical,
        dynamics: Dynamics,
        meter: &mut Meter<'_>,
    ) -> Result<Errors, Halt> {
        let setting = Setting { dynamics, method: Method::off() };
        let model = physical.prepare(&setting)?;
        let visits = visits(&model.simulation);
        let followed = self.frames(physical, visits, dynamics.substeps);
        let frames = physical.scene().simulation.frames;
        // The naive sums are followed no farther than they are compared.
        let last = if dynamics.sums == Sums::Fast { frames } else { followed };
        if last == 0 {
            return Ok(Errors::default());
        }
        let budget = self.budget;
        let path = self.path(physical, dynamics, followed, meter)?;
        let mut motion = Motion::new(physical.prepare(&setting)?, &model, physical.scene(), dynamics.sums)?;
        let (mut goals, mut beside) = (DistanceSums::default(), DistanceSums::default());
        for frame in 1..=last {
            motion.frame()?;
            meter.tick()?;
            let positions = |body| motion.positions(body);
            for (body, model) in model.simulation.bodies().iter().enumerate() {
                let cell_size = model.lattice().cell_size();
                if let Some(at) = path.get(frame as usize - 1) {
                    beside.add(&positions(body), &at[body], cell_size);
                }
                if is_moment(frame, frames, GOALS) && visits <= budget.goals {
                    let naive = Naive::new(model.lattice(), model.half_width(), Regions::Staircase);
                    let motions = naive.motions(&positions(body));
                    goals.add(&motion.goals(body), &naive.goals(&motions), cell_size);
                }
            }
        }
        let path = beside.distances().map(|distances| Path { frames: followed, distances });
        let free = match dynamics.sums {
            Sums::Fast => Some(flight::fly(physical, dynamics, budget.goals, meter)?),
            Sums::Naive(_) => None,
        };
        Ok(Errors { goals: goals.distances(), path, free })
    }

    /// The path of the naive sums beside a motion, through `frames` frames. Without any nothing is built: the lists of the
    /// regions alone can be larger than the memory.
    fn path(
        &mut self,
        physical: &Physical,
        dynamics: Dynamics,
        frames: u32,
        meter: &mut Meter<'_>,
    ) -> Result<&[Moment], Halt> {
        if frames == 0 {
            return Ok(&[]);
        }
        let dynamics = Dynamics { sums: Sums::Naive(Regions::Staircase), ..dynamics };
        let known =
            self.paths.iter().position(|(other, path)| *other == dynamics && path.len() == frames as usize);
        let at = match known {
            Some(at) => at,
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
        Ok(&self.paths[at].1)
    }
}

/// Distances being gathered.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DistanceSums {
    squares: f64,
    squares_cells: f64,
    count: usize,
    max: f64,
    max_cells: f64,
}

impl DistanceSums {
    /// Adds those of a body with cells of this edge.
    pub(super) fn add(&mut self, a: &[Vector3<f64>], b: &[Vector3<f64>], cell_size: f64) {
        for (a, b) in a.iter().zip(b) {
            let square = (a - b).norm_squared();
            self.squares += square;
            self.squares_cells += square / (cell_size * cell_size);
            self.max = self.max.max(square.sqrt());
            self.max_cells = self.max_cells.max(square.sqrt() / cell_size);
        }
        self.count += a.len();
    }

    /// What they come to; `None` of nothing.
    pub(super) fn distances(&self) -> Option<Distances> {
        let mean = |squares: f64| (squares / self.count as f64).sqrt();
        (self.count > 0).then(|| Distances {
            rms_cells: mean(self.squares_cells),
            max_cells: self.max_cells,
            rms: mean(self.squares),
            max: self.max,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::tests as block;

    #[test]
    fn naive_sums_that_take_too_long_are_not_even_built() {
        let (_folder, physical) = block::physical(4, &[1]);
        let errors = |path, dynamics| {
            let mut judge = Judge::new(Budget { path, goals: f64::INFINITY });
            let errors = judge.errors(&physical, dynamics, &mut Meter::new(&mut (), 1.0)).unwrap();
            (errors, judge.paths.len())
        };
        let (none, built) = errors(0.0, block::FAST);
        assert_eq!((none.path, built), (None, 0));
        assert!(none.goals.is_some() && none.free.is_some());
        let (none, built) = errors(0.0, block::NAIVE);
        assert!(none.goals.is_none() && none.path.is_none() && built == 0);
        let (all, built) = errors(f64::INFINITY, block::FAST);
        assert_eq!((all.path.map(|path| path.frames), built), (Some(4), 1));
    }
}
