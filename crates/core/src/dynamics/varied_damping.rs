//! Elastic damping with a rate that varies over a body, by zones.
//!
//! A step takes the fraction φᵢ = 1 - exp(-2 cᵢ h) of the difference to the reference motion from the velocity of
//! vertex i: see [`elastic_damping`](super::elastic_damping). With masses m, the momenta stay if the reference motion
//! is the rigid motion with the momenta of the masses m φᵢ: then Σ m φᵢ (r - v) is zero, and so are its moments. So
//! damping computes with the masses m sᵢ, and changes the velocity of vertex i by sᵢ times the change of a body whose
//! fraction is φ everywhere; φ is the greatest fraction, and sᵢ = φᵢ/φ the share of the vertex. Impulses of supports
//! and other bodies change the momenta of the masses m sᵢ too, and so those of the body.

use super::momentum::MomentumTracker;
use crate::lattice::{Lattice, Masses};
use crate::matching::Matching;
use crate::parallel::Executor;
use crate::simd::lanes::Lanes;
use crate::state::State;

/// The rates of the elastic damping in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DampingRates {
    /// c where the factor is 1, in 1/s.
    pub(crate) rate: f64,
    /// Greatest c.
    pub(crate) most: f64,
    /// h, the length of the step in seconds.
    pub(crate) dt: f64,
}

impl DampingRates {
    /// Returns exp(-2 c h), the fraction of the difference that remains where the rate has a factor.
    pub(crate) fn kept(&self, factor: f64) -> f64 {
        libm::exp(self.exponent(factor))
    }

    /// Returns the share of a vertex with this factor, in [0, 1]; 1 without damping.
    fn share(&self, factor: f64, greatest: f64) -> f64 {
        let share = libm::expm1(self.exponent(factor)) / libm::expm1(self.exponent(greatest));
        if share.is_finite() { share } else { 1.0 }
    }

    fn exponent(&self, factor: f64) -> f64 {
        -2.0 * (self.rate * factor).min(self.most) * self.dt
    }
}

/// The shares of the vertices, and the motion of the masses that they leave.
#[derive(Clone, Debug)]
pub(crate) struct VariedDamping {
    /// Factor of the rate of each lattice vertex.
    factors: Vec<f64>,
    pub(super) greatest: f64,
    pub(super) least: f64,
    /// The rates that the shares are computed for.
    rates: Option<DampingRates>,
    /// sᵢ of each vertex. Zero in lanes without a vertex.
    pub(super) shares: Lanes<1>,
    /// m sᵢ of each vertex in the first row.
    weights: Lanes<2>,
    /// Measures the motion of the masses m sᵢ.
    pub(super) tracker: MomentumTracker,
}

impl VariedDamping {
    /// Creates the data for one factor per lattice vertex.
    pub(crate) fn new(factors: Vec<f64>, lattice: &Lattice, masses: &Masses, matching: &Matching) -> Self {
        let Matching { layout, cascade, .. } = matching;
        Self {
            greatest: factors.iter().copied().fold(0.0, f64::max),
            least: factors.iter().copied().fold(f64::INFINITY, f64::min),
            factors,
            rates: None,
            shares: Lanes::zeros(layout.blocks()),
            weights: Lanes::zeros(layout.blocks()),
            tracker: MomentumTracker::new(lattice, masses, layout, cascade.tasks()),
        }
    }

    /// Measures the motion of the masses m sᵢ for the rates of a step.
    pub(super) fn measure(
        &mut self,
        rates: DampingRates,
        (matching, state): (&Matching, &State),
        executor: &Executor,
    ) {
        let Self { factors, greatest, shares, weights, tracker, .. } = self;
        let slots = matching.layout.slots();
        if self.rates.replace(rates) != Some(rates) {
            for (&slot, &factor) in slots.iter().zip(&*factors) {
                shares.set(slot, [rates.share(factor, *greatest) as f32]);
            }
        }
        // Pins and handles change the masses in the fits.
        for &slot in slots {
            weights.set(slot, [matching.regions.weights.get(slot)[0] * shares.get(slot)[0], 0.0]);
        }
        tracker.set_masses(slots, slots.iter().map(|&slot| weights.get(slot)[0]));
        let task_blocks = matching.cascade.task_blocks();
        tracker.measure_fields(executor, task_blocks, weights, &state.positions, &state.velocities);
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let lanes = self.shares.bytes() + self.weights.bytes();
        size_of_val(self.factors.as_slice()) + lanes + self.tracker.bytes()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::dynamics::ElasticDamper;

    /// The changes of the velocities have no sum and no moment, whatever the factors and the masses.
    #[test]
    fn varied_damping_keeps_the_momenta() {
        let cells: Vec<[i32; 3]> = (0..7 * 3 * 2).map(|k| [k % 7, k / 7 % 3, k / 21]).collect();
        let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
        let noise = |seed: usize| ((seed * 7919 + 13) % 1009) as f64 / 1009.0 - 0.5;
        let masses: Masses =
            (0..lattice.len()).map(|vertex| (1.0 + noise(vertex)) as f32).collect::<Vec<_>>().into();
        let matching = Matching::new(&lattice, &masses, 1.into());
        let layout = &matching.layout;
        let mut state = State::at_rest(&lattice, layout, &crate::state::Placement::default());
        for (vertex, &slot) in layout.slots().iter().enumerate() {
            state.velocities.set(slot, [1, 2, 3].map(|axis| noise(axis * 500 + vertex) as f32));
        }
        let factors = (0..lattice.len()).map(|vertex| libm::pow(100_f64, 2.0 * noise(vertex + 77))).collect();
        let varied = VariedDamping::new(factors, &lattice, &masses, &matching);
        let mut damper = ElasticDamper::new(Some(varied));
        let momentum = MomentumTracker::new(&lattice, &masses, layout, matching.cascade.tasks());
        for rate in [0.1, 20.0] {
            let rates = DampingRates { rate, most: 100.0, dt: 0.01 };
            damper.begin(None, (&matching, &state), &momentum, (rates, &Executor::sequential()));
            let (mut linear, mut angular, mut size) = (Vector3::zeros(), Vector3::zeros(), 0.0);
            for (&mass, &slot) in masses.iter().zip(layout.slots()) {
                let velocity = Vector3::from(state.velocities.get(slot).map(f64::from));
                let change = damper.change((0, slot), state.local(slot), velocity) * f64::from(mass);
                linear += change;
                angular += state.local(slot).cross(&change);
                size += change.norm();
            }
            // Rounding of single-precision velocities of the rigid motion; arms are at most 8 cells.
            assert!(size > 0.0 && linear.norm() < 1e-6 * size, "{linear} of {size}");
            assert!(angular.norm() < 8e-6 * size, "{angular} of {size}");
        }
    }
}
