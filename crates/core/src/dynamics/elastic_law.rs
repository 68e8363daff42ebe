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

/// The elastic law of shape matching: E = ρ (alpha/dt²) h² w (w + 1)/3.
///
/// It relates Young's modulus E of a body to the half-width w of its regions in cells and to alpha, the fraction of the
/// distance to its goal position that a vertex covers in a step ([`Stiffness::PerStep`](crate::Stiffness::PerStep)).
/// The fields are the parameters that do not depend on the regions. All of them must be > 0.
///
/// ```
/// use supple::ElasticLaw;
///
/// let law = ElasticLaw { density: 1000.0, cell_size: 0.1, dt: 0.01 };
/// // 1000 (1/0.01²) 0.1² 2 (2 + 1)/3 = 200,000.
/// assert!((law.modulus(2, 1.0) - 2e5).abs() < 1e-6);
/// assert!((law.alpha(2, 1e5) - 0.5).abs() < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticLaw {
    /// Density ρ: mass per volume in scene units.
    pub density: f64,
    /// Edge of a cell, h, in scene units.
    pub cell_size: f64,
    /// Length of a step in seconds.
    pub dt: f64,
}

impl ElasticLaw {
    /// Computes Young's modulus, in scene units of force per area, of regions of half-width `half_width` >= 1 in cells
    /// with the stiffness `alpha` per step, in (0, 1].
    pub fn modulus(&self, half_width: usize, alpha: f64) -> f64 {
        alpha * self.greatest_modulus(half_width)
    }

    /// Computes alpha for Young's modulus `modulus` > 0, in scene units of force per area, and regions of half-width
    /// `half_width` >= 1 in cells. It exceeds 1, which no body can have, if the regions are too small or the step is
    /// too long.
    pub fn alpha(&self, half_width: usize, modulus: f64) -> f64 {
        modulus / self.greatest_modulus(half_width)
    }

    /// Returns Young's modulus at alpha = 1.
    fn greatest_modulus(&self, half_width: usize) -> f64 {
        self.density * (self.cell_size / self.dt).powi(2) * moment(half_width)
    }

    /// Returns the least half-width, from 1 to `limit`, for which alpha <= 1. Returns `limit` if alpha exceeds 1 for
    /// all of them.
    pub(crate) fn least_half_width(&self, modulus: f64, limit: usize) -> usize {
        // The largest half-width is far below 2^53.
        let moment = modulus / (self.density * (self.cell_size / self.dt).powi(2));
        let root = half_width_of(3.0 * moment);
        // A rounding error of a whole number of cells must not give another cell.
        let least = (root * (1.0 - 1e-12)).ceil();
        if least < limit as f64 { (least as usize).max(1) } else { limit }
    }

    /// Returns the length of the longest step for which alpha <= 1 with regions of half-width `half_width`.
    pub(crate) fn longest_step(density: f64, cell_size: f64, half_width: usize, modulus: f64) -> f64 {
        cell_size * (density * moment(half_width) / modulus).sqrt()
    }
}

/// Returns the number w > 0 with w (w + 1) = `product`.
pub(crate) fn half_width_of(product: f64) -> f64 {
    (product + 0.25).sqrt() - 0.5
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
