//! The energy of a body, in f64 and by the naive method: [`Naive::energy`] in cells.

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
        let scaled =
            |cells: &[Vector3<f64>]| -> Vec<_> { cells.iter().map(|x| x * self.cell_size).collect() };
        self.naive.energy(&scaled(x), &scaled(v), self.alpha) / self.cell_size.powi(2)
    }
}
