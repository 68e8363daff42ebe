//! Studies the summation alone: local and global moments, direct and running sums, in f32 and f64.
//!
//! The moments of a region are the sums Σ (m/n) x and Σ (m/n) x x0ᵀ over its vertices, with the region
//! weights m/n (mass of a vertex divided by the number of regions that contain it), the positions x and the
//! rest positions x0. *Local* moments use rest positions relative to the center vertex of the region,
//! *global* moments use rest positions relative to the origin.
//!
//! All variants use the same scalar code on one thread, so that they are comparable with each other. The
//! library is measured as well. The reference is the variant with direct sums of local moments in f64; a test
//! compares it with the naive sums.

mod block;
mod moments;
mod report;
mod windows;

use std::path::PathBuf;
use std::time::Instant;

use nalgebra::{Point3, Vector3};
use supple::{Body, Lattice, Material, Simulation};

use crate::error::{Halt, StudyError};
use crate::machine::Machine;
use crate::observer::{Meter, Observer, Outcome};
use block::{Block, DISTANCES};
use moments::{Moments, Summation};
pub use report::{SumsError, SumsReport, SumsRow};
use windows::{Number, Summing};

/// The study of the summation.
#[derive(Clone, Debug)]
pub struct SumsStudy {
    /// Output directory of `sums.csv` and `sums.json`; created if it does not exist.
    pub directory: PathBuf,
    /// Whether to use fewer and smaller blocks.
    pub quick: bool,
}

/// Vertices along each edge of a block, and half-width. First the half-width varies, then the size of the
/// block.
const FULL: [(usize, usize); 5] = [(22, 1), (22, 3), (22, 8), (10, 3), (47, 3)];
/// Vertices along each edge and half-widths of a quick study.
const QUICK: [(usize, usize); 3] = [(10, 1), (10, 3), (22, 3)];
/// Number of timed repetitions; the median is reported.
const REPEATS: usize = 7;
/// Steps of the library in one timed repetition.
const STEPS: u64 = 20;

impl SumsStudy {
    /// Runs the study. If the observer requests a stop, the completed blocks are reported and written.
    ///
    /// # Errors
    ///
    /// Returns an error if the directory cannot be written or a block cannot be built.
    pub fn run(&self, observer: &mut dyn Observer) -> Result<(SumsReport, Outcome), StudyError> {
        let cases: &[(usize, usize)] = if self.quick { &QUICK } else { &FULL };
        let mut report = SumsReport { complete: false, machine: Machine::here(1), rows: Vec::new() };
        report.write(&self.directory)?;
        let weight = |side: usize| side.pow(3) as f64;
        let mut meter = Meter::new(observer, cases.iter().map(|(side, _)| weight(*side)).sum());
        let mut outcome = Outcome::Finished;
        for &(side, half_width) in cases {
            let ticks = 9.0 * DISTANCES.len() as f64;
            let name = format!("{} vertices, half-width {half_width}", side.pow(3));
            let rows =
                meter.begin(name, weight(side), ticks).and_then(|()| case(side, half_width, &mut meter));
            match rows {
                Ok(rows) => report.rows.extend(rows),
                Err(Halt::Stopped) => {
                    outcome = Outcome::Stopped;
                    break;
                }
                Err(Halt::Failed(error)) => return Err(error),
            }
        }
        report.complete = outcome == Outcome::Finished;
        report.write(&self.directory)?;
        Ok((report, outcome))
    }
}

/// Measures all variants on one block.
fn case(side: usize, half_width: usize, meter: &mut Meter<'_>) -> Result<Vec<SumsRow>, Halt> {
    let block = Block::new(side, half_width);
    let mut rows = Vec::new();
    for moments in [Moments::Local, Moments::Global] {
        for summing in [Summing::Direct, Summing::Running] {
            rows.push(measure_variant::<f32>(&block, moments, summing, meter)?);
            rows.push(measure_variant::<f64>(&block, moments, summing, meter)?);
        }
    }
    rows.push(measure_library(&block, meter)?);
    Ok(rows)
}

/// Computes the goal positions by the reference variant. Positions and goal positions are relative to the
/// corner of the block.
fn reference_goals(block: &Block, positions: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    Summation::new(block, Moments::Local, Summing::Direct, 0.0).goals(positions).0
}

/// Measures one variant at all distances.
fn measure_variant<T: Number>(
    block: &Block,
    moments: Moments,
    summing: Summing,
    meter: &mut Meter<'_>,
) -> Result<SumsRow, Halt> {
    let mut row = SumsRow::new(block, format!("{} {} {}", moments.name(), summing.name(), T::NAME));
    for distance in DISTANCES {
        let shift = Vector3::repeat(distance);
        let positions: Vec<Vector3<T>> = block.deformed().iter().map(|x| (x + shift).map(T::of)).collect();
        // The reference gets the rounded positions, because rounding the input is not an error of the sums.
        let from_corner: Vec<_> = positions.iter().map(|x| x.map(Into::<f64>::into) - shift).collect();
        let mut variant = Summation::<T>::new(block, moments, summing, distance);
        let (mut goals, _) = variant.goals(&positions);
        if distance == 0.0 {
            let timed = (0..REPEATS).map(|_| variant.goals(&positions).1.as_secs_f64());
            row.time(&timed.collect::<Vec<_>>(), block.len());
        }
        goals.iter_mut().for_each(|goal| *goal -= shift);
        row.error(distance, &goals, &reference_goals(block, &from_corner));
        meter.tick()?;
    }
    Ok(row)
}

/// Measures the library: the error of its goal positions, and the time of a whole step on one thread.
fn measure_library(block: &Block, meter: &mut Meter<'_>) -> Result<SumsRow, Halt> {
    let lattice = lattice(block)?;
    let mut row = SumsRow::new(block, "supple, f32".to_owned());
    for distance in DISTANCES {
        let shift = Vector3::repeat(distance);
        let mut body = Body::from_lattice(lattice.clone())
            .material(Material::fast_lsm())
            .half_width(block.half_width)
            .build()?;
        let placed: Vec<Point3<f64>> = block.deformed().iter().map(|x| (x + shift).into()).collect();
        body.set_positions(&placed).map_err(supple::Error::from)?;
        let from_corner: Vec<_> = body.positions().iter().map(|x| x.coords - shift).collect();
        let goals: Vec<_> = body.goals().iter().map(|goal| goal.coords - shift).collect();
        row.error(distance, &goals, &reference_goals(block, &from_corner));
        if distance == 0.0 {
            let mut simulation = Simulation::builder().gravity([0.0; 3]).threads(1).body(body).build()?;
            simulation.steps(STEPS);
            let timed = (0..REPEATS).map(|_| {
                let start = Instant::now();
                simulation.steps(STEPS);
                start.elapsed().as_secs_f64() / STEPS as f64
            });
            row.time(&timed.collect::<Vec<_>>(), block.len());
        }
        meter.tick()?;
    }
    Ok(row)
}

/// Builds the block as a lattice.
fn lattice(block: &Block) -> Result<Lattice, supple::Error> {
    let edge = block.side as i32 - 1;
    let cells: Vec<_> = (0..edge.pow(3)).map(|i| [i % edge, i / edge % edge, i / (edge * edge)]).collect();
    Ok(Lattice::from_cells(&cells, 1.0, Point3::origin(), false)?)
}

#[cfg(test)]
mod tests {
    use supple::reference::{Regions, goals};

    use super::*;

    #[test]
    fn all_variants_agree_with_the_naive_goals() {
        for (side, half_width) in [(2, 1), (5, 2), (6, 1), (4, 9)] {
            let block = Block::new(side, half_width);
            let lattice = lattice(&block).unwrap();
            let naive = goals(&lattice, &block.deformed(), half_width, Regions::Staircase);
            for moments in [Moments::Local, Moments::Global] {
                for summing in [Summing::Direct, Summing::Running] {
                    let mut variant = Summation::<f64>::new(&block, moments, summing, 0.0);
                    let (fast, _) = variant.goals(&block.deformed());
                    let worst = fast.iter().zip(&naive).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
                    assert!(worst < 1e-12, "{side}, {half_width}, {moments:?}, {summing:?}: {worst:e}");
                }
            }
        }
    }
}
