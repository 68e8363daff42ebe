//! Distances of points from where they should be.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Distances of lattice vertices from where they should be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Distances {
    /// Root mean square, in cells.
    pub rms_cells: f64,
    /// Greatest, in cells.
    pub max_cells: f64,
    /// Root mean square, in scene units.
    pub rms: f64,
    /// Greatest, in scene units.
    pub max: f64,
}

/// Distances being gathered.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Gathered {
    squares: f64,
    squares_cells: f64,
    count: usize,
    max: f64,
    max_cells: f64,
}

impl Gathered {
    /// Adds those of a body with cells of this edge.
    pub(crate) fn add(&mut self, a: &[Vector3<f64>], b: &[Vector3<f64>], cell_size: f64) {
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
    pub(crate) fn distances(&self) -> Option<Distances> {
        let mean = |squares: f64| (squares / self.count as f64).sqrt();
        (self.count > 0).then(|| Distances {
            rms_cells: mean(self.squares_cells),
            max_cells: self.max_cells,
            rms: mean(self.squares),
            max: self.max,
        })
    }
}
