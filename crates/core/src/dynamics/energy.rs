//! Limits the energy of a free body: a body without constraints and contacts.
//!
//! The acceleration towards the goal positions has the potential V = alpha/(2 dt²) Σ s Σ m/n |goal - x|². The outer
//! sum is over the regions, with the stiffness factor s of a region, and the inner sum over the vertices of a region;
//! m/n and x are the region weight and the position of a vertex, and `goal` is the position to which the rigid motion
//! of this region moves the vertex. The time integration is a leapfrog scheme. If V is harmonic, it conserves the
//! energy Σ m v₋·v₊ / 2 + V exactly, with the velocities v₋ before and v₊ after the acceleration. But V has kinks
//! where an inverted region has two optimal rotations, and steps across a kink add energy. Bodies that start
//! collapsed to a point, or with permuted vertices, reach 6 to 300 times their initial energy in 10,000 steps.
//!
//! Newton's method for the rotations fails to converge only near a kink. So the energy is computed in the
//! steps in which it fails to converge for a region. The first such energy becomes the limit. If a later
//! energy is above the limit, the non-rigid part of the velocities is scaled down.

use super::momentum::MomentumTracker;
use crate::matching::{Matching, PotentialSums, Regions};
use crate::simd::lanes::{Block, LANES, Lanes};
use crate::state::{EnergyLimit, State};

/// Rounding error of the potential, as a fraction of alpha/(2 dt²) Σ m |x|².
const NOISE: f64 = 1e-6;

/// The energy-limiting stage.
#[derive(Debug)]
pub(crate) struct EnergyLimiter {
    /// Σ s m/n |x⁰ - c⁰|² over all regions and the vertices of each region, with the rest position x⁰ of a
    /// vertex and the rest centroid c⁰ of a region.
    rest_moment: f64,
    /// Sums of the potential, which the fit of the rigid motions writes.
    potential: PotentialSums,
    /// Velocities before the acceleration towards the goal positions.
    velocities_before: Lanes<3>,
}

impl EnergyLimiter {
    /// Creates the stage for the regions of `matching`.
    pub(crate) fn new(matching: &Matching) -> Self {
        let blocks = matching.layout.blocks();
        Self {
            rest_moment: matching.regions.rest_moment(&matching.layout),
            potential: PotentialSums::new(blocks),
            velocities_before: Lanes::zeros(blocks),
        }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.potential.bytes() + self.velocities_before.bytes()
    }

    /// Returns the sums of the potential, which the fit of the rigid motions writes.
    pub(crate) fn potential(&self) -> &PotentialSums {
        &self.potential
    }

    /// Stores the velocities before the acceleration towards the goal positions.
    pub(crate) fn begin(&mut self, velocities: &Lanes<3>) {
        self.velocities_before.copy_from(velocities);
    }

    /// Limits the energy after the acceleration towards the goal positions. If there is no limit yet, or if
    /// the limit is for another `stiffness_rate` or `dt`, the current energy becomes the limit.
    ///
    /// `stiffness_rate` is alpha/dt in 1/s, and `dt` is in seconds.
    pub(crate) fn apply(
        &self,
        (stiffness_rate, dt): (f64, f64),
        regions: &Regions,
        state: &mut State,
        tracker: &mut MomentumTracker,
    ) {
        let State { positions, velocities, energy_limit, .. } = state;
        let Sums { position_squared, before_after, after } = self.sums(regions, positions, velocities);
        let potential =
            0.5 * stiffness_rate / dt * (self.rest_moment + position_squared - self.potential.sum());
        let noise = 0.5 * stiffness_rate / dt * NOISE * position_squared;
        let energy = 0.5 * before_after + potential;
        let limit = match *energy_limit {
            Some(limit) if limit.stiffness_rate == stiffness_rate && limit.dt == dt => limit.energy,
            _ => {
                *energy_limit = energy.is_finite().then_some(EnergyLimit { energy, stiffness_rate, dt });
                return;
            }
        };
        if energy <= limit + noise || !energy.is_finite() {
            return;
        }
        // If the non-rigid velocities are scaled by s, the energy is potential + rigid + s² non_rigid - s
        // work. `scale` is the s for which this energy equals the limit.
        let rigid = tracker.rigid_energy();
        let (non_rigid, work) = (0.5 * after - rigid, 0.5 * (after - before_after));
        let budget = limit - potential - rigid;
        let scale = (work + (work * work + 4.0 * non_rigid * budget).max(0.0).sqrt()) / (2.0 * non_rigid);
        if non_rigid > 0.0 && scale.is_finite() {
            let scale = scale.clamp(0.0, 1.0);
            // All velocities are scaled. The momentum correction of the step then restores their rigid part.
            velocities.blocks_mut().iter_mut().flatten().for_each(|row| {
                row.iter_mut().for_each(|v| *v *= scale as f32);
            });
            tracker.scale(f64::from(scale as f32));
        }
    }

    /// Sums over all vertices in f64, in storage order.
    fn sums(&self, regions: &Regions, positions: &Lanes<3>, velocities: &Lanes<3>) -> Sums {
        let (weights, factors) = (&regions.weights, regions.factors());
        let mut sums = Sums::default();
        let blocks = weights.blocks().iter().zip(positions.blocks()).zip(self.velocities_before.blocks());
        for (block, (((weights, x), before), v)) in blocks.zip(velocities.blocks()).enumerate() {
            let factors = factors.map(|factors| &factors.vertices.blocks()[block][0]);
            for lane in 0..LANES {
                let m = f64::from(weights[0][lane]);
                let factor = factors.map_or(1.0, |factors| f64::from(factors[lane]));
                sums.position_squared += m * factor * product(x, x, lane);
                sums.before_after += m * product(before, v, lane);
                sums.after += m * product(v, v, lane);
            }
        }
        sums
    }
}

/// The sums Σ s m |x|², Σ m v₋·v₊ and Σ m |v₊|² over all vertices, with the stiffness factor s of a vertex.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    position_squared: f64,
    before_after: f64,
    after: f64,
}

/// Computes the scalar product of the vectors in one lane of two blocks.
fn product(a: &Block<3>, b: &Block<3>, lane: usize) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a[lane]) * f64::from(b[lane])).sum()
}
