//! The energy limiter: a body on which nothing acts never has more energy than it began with.
//!
//! The pull towards the goals has a potential, V = alpha/(2 dt²) Σ over regions Σ m/n |goal - x|². A step is a leapfrog
//! step: it keeps Σ m v₋·v₊ / 2 + V while a body vibrates (v₋ and v₊ are the velocities before and after the pull),
//! exactly where V is harmonic. But V has kinks where a region that is turned inside out has two best rotations, and
//! steps across them give energy: bodies let go from a point, or shuffled, reach 6 to 300 times their first energy in
//! 10,000 steps. Near a kink, and nowhere else, Newton's method leaves rotations to the robust path. So the energy is
//! summed in those steps, and above the limit the motion beside the rigid one is slowed down.

use super::momentum::MomentumTracker;
use crate::matching::{Matching, PotentialSums};
use crate::simd::lanes::{Block, LANES, Lanes};
use crate::state::{EnergyLimit, State};

/// The share of Σ m x² that rounding may make of the potential.
const NOISE: f64 = 1e-6;

/// The stage: sums the energy of a body, and owns the buffers of these sums.
#[derive(Debug)]
pub(crate) struct EnergyLimiter {
    /// Σ over regions Σ m/n |x⁰ - c⁰|².
    rest: f64,
    potential: PotentialSums,
    velocities_before: Lanes<3>,
}

impl EnergyLimiter {
    /// For the regions of a matching stage.
    pub(crate) fn new(matching: &Matching) -> Self {
        let blocks = matching.layout.blocks();
        Self {
            rest: matching.regions.rest_spread(&matching.layout),
            potential: PotentialSums::new(blocks),
            velocities_before: Lanes::zeros(blocks),
        }
    }

    /// Memory that it takes.
    pub(crate) fn bytes(&self) -> usize {
        self.potential.bytes() + self.velocities_before.bytes()
    }

    /// Receives the potential of the fit.
    pub(crate) fn potential(&self) -> &PotentialSums {
        &self.potential
    }

    /// Keeps the velocities before the pull.
    pub(crate) fn begin(&mut self, velocities: &Lanes<3>) {
        self.velocities_before.copy_from(velocities);
    }

    /// After the pull towards the goals, with `stiffness_rate` = alpha/dt in 1/s and `dt` in seconds: sets the limit if
    /// there is none, or slows the body down to it.
    pub(crate) fn apply(
        &self,
        (stiffness_rate, dt): (f64, f64),
        weights: &Lanes<2>,
        state: &mut State,
        tracker: &mut MomentumTracker,
    ) {
        let State { positions, velocities, energy_limit, .. } = state;
        let Sums { square, before_after, after } = self.sums(weights, positions, velocities);
        let potential = 0.5 * stiffness_rate / dt * (self.rest + square - self.potential.sum());
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
        // With the velocities beside the rigid ones times s the energy is potential + rigid + s² beside - s pulled.
        let rigid = tracker.rigid_energy();
        let (beside, work) = (0.5 * after - rigid, 0.5 * (after - before_after));
        let room = limit - potential - rigid;
        let scale = (work + (work * work + 4.0 * beside * room).max(0.0).sqrt()) / (2.0 * beside);
        if beside > 0.0 && scale.is_finite() {
            let scale = scale.clamp(0.0, 1.0);
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

/// Σ m x², Σ m v₋·v₊, Σ m v₊².
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    square: f64,
    before_after: f64,
    after: f64,
}

fn product(a: &Block<3>, b: &Block<3>, lane: usize) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a[lane]) * f64::from(b[lane])).sum()
}
