//! The elastic law of shape matching: Young's modulus from the parameters of the regions, and back.
//!
//! A body of the density ρ, with cells of the edge h, regions of the half-width w in cells and the stiffness alpha
//! per step of dt seconds, has Young's modulus
//!
//! ```text
//! E = ρ (alpha/dt²) h² w (w + 1)/3
//! ```
//!
//! and Poisson's ratio 0: w (w + 1)/3 is the second moment of a window of 2 w + 1 vertices, in squared cells, and a
//! deformation that varies slowly moves a goal position away from its vertex by half of this moment times the second
//! derivative of the deformation. The length R = h √(w (w + 1)) is the radius of the regions. E is the product of
//! ρ/(3 dt²), alpha and R², so that alpha <= 1 is possible only if R >= dt √(3 E/ρ), for cells of any size.

/// The parameters of the elastic law that do not depend on the regions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ElasticLaw {
    /// Density ρ.
    pub(crate) density: f64,
    /// Edge of a cell, h.
    pub(crate) cell_size: f64,
    /// Length of a step in seconds.
    pub(crate) dt: f64,
}

impl ElasticLaw {
    /// Computes Young's modulus of regions of half-width `half_width` with the stiffness `alpha` per step.
    pub(crate) fn modulus(&self, half_width: usize, alpha: f64) -> f64 {
        alpha * self.greatest_modulus(half_width)
    }

    /// Computes alpha for Young's modulus `modulus` and regions of half-width `half_width`. It exceeds 1 if the
    /// regions are too small.
    pub(crate) fn alpha(&self, half_width: usize, modulus: f64) -> f64 {
        modulus / self.greatest_modulus(half_width)
    }

    /// Returns Young's modulus at alpha = 1.
    fn greatest_modulus(&self, half_width: usize) -> f64 {
        self.density * (self.cell_size / self.dt).powi(2) * moment(half_width)
    }

    /// Returns the least half-width, from 1 to `limit`, for which alpha <= 1. Returns `limit` if alpha exceeds 1 for
    /// all of them.
    pub(crate) fn least_half_width(&self, modulus: f64, limit: usize) -> usize {
        // w (w + 1)/3 >= `moment` for w >= `root`. The largest half-width is far below 2^53.
        let moment = modulus / (self.density * (self.cell_size / self.dt).powi(2));
        let root = (3.0 * moment + 0.25).sqrt() - 0.5;
        // A rounding error of a whole number of cells must not give another cell.
        let least = (root * (1.0 - 1e-12)).ceil();
        if least < limit as f64 { (least as usize).max(1) } else { limit }
    }

    /// Returns the length of the longest step for which alpha <= 1 with regions of half-width `half_width`.
    pub(crate) fn longest_step(density: f64, cell_size: f64, half_width: usize, modulus: f64) -> f64 {
        cell_size * (density * moment(half_width) / modulus).sqrt()
    }
}

/// Returns the second moment of a window of 2 w + 1 vertices, w (w + 1)/3.
fn moment(half_width: usize) -> f64 {
    let w = half_width as f64;
    w * (w + 1.0) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_half_width_is_the_first_whose_alpha_is_at_most_one() {
        let law = ElasticLaw { density: 700.0, cell_size: 0.1, dt: 1.0 / 240.0 };
        for half_width in [1, 2, 3, 7, 30, 1000] {
            let modulus = law.modulus(half_width, 1.0);
            assert_eq!(law.least_half_width(modulus, 2000), half_width);
            assert_eq!(law.least_half_width(1.0001 * modulus, 2000), half_width + 1);
            assert_eq!(law.least_half_width(0.9999 * modulus, 2000), half_width);
            assert!((law.alpha(half_width, 0.3 * modulus) - 0.3).abs() < 1e-12);
            let longest = ElasticLaw::longest_step(law.density, law.cell_size, half_width, modulus);
            assert!((longest - law.dt).abs() < 1e-12 * law.dt);
        }
        assert_eq!(law.least_half_width(1e300, 12), 12);
        assert_eq!(law.least_half_width(1e-300, 12), 1);
    }
}
