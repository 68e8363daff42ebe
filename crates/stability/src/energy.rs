//! The energy of a body, in f64 and by the naive method.
//!
//! The pull towards the goals has a potential, alpha times [`Naive::mismatch`]. A step is one of the leapfrog method,
//! which does not keep kinetic and elastic energy themselves; of a harmonic motion it keeps their sum less m a²/8, with
//! the velocities at the time of the positions. That is what is summed here, so what it gains is of the method.

use nalgebra::Vector3;
use supple::Lattice;
use supple::reference::{Naive, Regions};

/// Sums the energy of a body on which nothing acts. Lengths are in cells, times in steps, masses in full cells.
pub(crate) struct Energy<'a> {
    naive: Naive<'a>,
    cell_size: f64,
    alpha: f64,
}

impl<'a> Energy<'a> {
    /// Of a body with this half-width in cells and this alpha.
    pub(crate) fn new(lattice: &'a Lattice, half_width: usize, alpha: f64) -> Self {
        let naive = Naive::new(lattice, half_width, Regions::Staircase).listed();
        Self { naive, cell_size: lattice.cell_size(), alpha }
    }

    /// The energy at these positions, reached with these velocities.
    pub(crate) fn of(&self, x: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let positions: Vec<_> = x.iter().map(|x| x * self.cell_size).collect();
        let motions = self.naive.motions(&positions);
        let goals = self.naive.goals(&motions);
        let elastic = self.alpha * self.naive.mismatch(&motions, &positions) / self.cell_size.powi(2);
        let vertices = goals.iter().zip(x).zip(v).zip(&self.naive.weights().masses);
        let kinetic = vertices.map(|(((goal, x), v), m)| {
            let a = (goal / self.cell_size - x) * self.alpha;
            m * (0.5 * (v + a / 2.0).norm_squared() - a.norm_squared() / 8.0)
        });
        elastic + kinetic.sum::<f64>()
    }
}
