//! The energy of a body, by plain sums in f64.
//!
//! The pull towards the goals has a potential: with the weights m/n of a vertex in a region, V = α/2dt² Σ over regions Σ m/n
//! |goal - x|², whose gradient is what the step applies, since the best rotation makes V stationary. A step is one of the
//! leapfrog method, which does not keep T + V itself; of a harmonic motion it keeps T + V - dt²/8 Σ m a² to rounding, with
//! the velocities at the time of the positions. That is what is summed here, so all that it gains is of the method.

use nalgebra::{Matrix3, Vector3};
use supple::Lattice;
use supple::reference::{self, Regions, Weights};

/// Sums the energy of a bare lattice's body. Lengths are in cells, times in steps, masses in full cells.
pub(crate) struct Energy {
    rest: Vec<Vector3<f64>>,
    regions: Vec<Vec<u32>>,
    weights: Weights,
    alpha: f64,
}

impl Energy {
    pub(crate) fn new(lattice: &Lattice, half_width: usize, alpha: f64) -> Self {
        let kind = Regions::Staircase;
        let region = |vertex| reference::region(lattice, vertex, half_width, kind);
        Self {
            rest: lattice.indices().iter().map(|index| Vector3::from(index.map(f64::from))).collect(),
            regions: (0..lattice.len() as u32).map(region).collect(),
            weights: reference::weights(lattice, half_width, kind),
            alpha,
        }
    }

    /// The energy at these positions, reached with these velocities.
    pub(crate) fn of(&self, x: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut pulls = vec![Vector3::zeros(); x.len()];
        let mut potential = 0.0;
        for members in &self.regions {
            let mean = |of: &[Vector3<f64>]| {
                let weighed = members.iter().map(|&i| (of[i as usize], self.weights.of(i)));
                let (sum, mass) = weighed.fold((Vector3::zeros(), 0.0), |(s, m), (x, w)| (s + x * w, m + w));
                sum / mass
            };
            let (c0, c) = (mean(&self.rest), mean(x));
            let arms = |i: u32| (self.rest[i as usize] - c0, x[i as usize] - c);
            let moments: Matrix3<f64> =
                members.iter().map(|&i| arms(i).1 * arms(i).0.transpose() * self.weights.of(i)).sum();
            let rotation = reference::rotation(&moments);
            for &i in members {
                let (rest, now) = arms(i);
                let pull = rotation * rest - now;
                potential += 0.5 * self.alpha * self.weights.of(i) * pull.norm_squared();
                pulls[i as usize] += pull * (self.alpha / self.weights.counts[i as usize] as f64);
            }
        }
        let vertices = self.weights.masses.iter().zip(v).zip(&pulls);
        let moving = vertices.map(|((m, v), a)| m * (0.5 * (v + a / 2.0).norm_squared() - a.norm_squared() / 8.0));
        potential + moving.sum::<f64>()
    }
}
