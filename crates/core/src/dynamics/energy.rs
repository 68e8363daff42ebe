//! The energy limiter: keeps the energy of a free body, without constraints and contacts, from growing.
//!
//! The acceleration towards the goals has a potential, V = alpha/(2 dt²) Σ over regions Σ m/n |goal - x|²,
//! with the goal of that region. The time integration is a leapfrog scheme. It conserves Σ m v₋·v₊ / 2 + V,
//! with the velocities v₋ before and v₊ after the acceleration, exactly where V is harmonic. But V has kinks
//! where an inverted region has two best rotations, and steps across a kink add energy: bodies that start
//! collapsed to a point, or with their vertices permuted, reach 6 to 300 times their initial energy in 10,000
//! steps. Newton's method for the rotations fails to converge near a kink and nowhere else. So the energy is
//! summed in steps with such a rotation, and if it is above the limit, the non-rigid part of the velocities
//! is scaled down.

use super::momentum::MomentumTracker;
use crate::matching::{Matching, PotentialSums};
use crate::simd::lanes::{Block, LANES, Lanes};
use crate::state::{EnergyLimit, State};

/// Rounding error of the potential, as a fraction of alpha/(2 dt²) Σ m x².
const NOISE: f64 = 1e-6;

/// The energy-limiting stage, with the buffers of its sums.
#[derive(Debug)]
pub(crate) struct EnergyLimiter {
    /// Σ over regions Σ m/n |x⁰ - c⁰|².
    rest_spread: f64,
    potential: PotentialSums,
    velocities_before: Lanes<3>,
}

impl EnergyLimiter {
    /// Creates the stage for the regions of `matching`.
    pub(crate) fn new(matching: &Matching) -> Self {
        let blocks = matching.layout.blocks();
        Self {
            rest_spread: matching.regions.rest_spread(&matching.layout),
            potential: PotentialSums::new(blocks),
            velocities_before: Lanes::zeros(blocks),
        }
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.potential.bytes() + self.velocities_before.bytes()
    }

    /// The sums that the fit writes its potential to.
    pub(crate) fn potential(&self) -> &PotentialSums {
        &self.potential
    }

    /// Stores the velocities before the acceleration towards the goals.
    pub(crate) fn begin(&mut self, velocities: &Lanes<3>) {
        self.velocities_before.copy_from(velocities);
    }

    /// Limits the energy after the acceleration towards the goals. Where there is no limit for this
    /// `stiffness_rate` and `dt`, the current energy becomes the limit.
    ///
    /// `stiffness_rate` = alpha/dt in 1/s; `dt` in seconds.
    pub(crate) fn apply(
        &self,
        (stiffness_rate, dt): (f64, f64),
        weights: &Lanes<2>,
        state: &mut State,
        tracker: &mut MomentumTracker,
    ) {
        let State { positions, velocities, energy_limit, .. } = state;
        let Sums { square, before_after, after } = self.sums(weights, positions, velocities);
        let potential = 0.5 * stiffness_rate / dt * (self.rest_spread + square - self.potential.sum());
        let noise = 0.5 * stiffness_rate / dt * NOISE * square;
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
        // With the non-rigid velocities scaled by s, the energy is potential + rigid + s² non_rigid - s work.
        let rigid = tracker.rigid_energy();
        let (non_rigid, work) = (0.5 * after - rigid, 0.5 * (after - before_after));
        let budget = limit - potential - rigid;
        let scale = (work + (work * work + 4.0 * non_rigid * budget).max(0.0).sqrt()) / (2.0 * non_rigid);
        if non_rigid > 0.0 && scale.is_finite() {
            let scale = scale.clamp(0.0, 1.0);
            // All velocities are scaled; the momentum correction of the step restores their rigid part.
            velocities.blocks_mut().iter_mut().flatten().for_each(|row| {
                row.iter_mut().for_each(|v| *v *= scale as f32);
            });
            tracker.scale(f64::from(scale as f32));
        }
    }

    fn sums(&self, weights: &Lanes<2>, positions: &Lanes<3>, velocities: &Lanes<3>) -> Sums {
        let mut sums = Sums::default();
        let blocks = weights.blocks().iter().zip(positions.blocks()).zip(self.velocities_before.blocks());
        for (((weights, x), before), v) in blocks.zip(velocities.blocks()) {
            for lane in 0..LANES {
                let m = f64::from(weights[0][lane]);
                sums.square += m * product(x, x, lane);
                sums.before_after += m * product(before, v, lane);
                sums.after += m * product(v, v, lane);
            }
        }
        sums
    }
}

/// The sums Σ m x², Σ m v₋·v₊ and Σ m v₊².
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    square: f64,
    before_after: f64,
    after: f64,
}

/// The scalar product of the vectors in one lane.
fn product(a: &Block<3>, b: &Block<3>, lane: usize) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a[lane]) * f64::from(b[lane])).sum()
}
