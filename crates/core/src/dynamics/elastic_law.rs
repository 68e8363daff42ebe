//! The elastic law of shape matching: Young's modulus from the parameters of the regions, and back.
//!
//! A body of the density ρ, with cells of the edge h, regions of the half-width w in cells and the stiffness alpha
//! per step of dt seconds, has Young's modulus
//!
//! ```text
//! E = ρ (alpha/dt²) h² w (w + 1)/3
//! ```
//!
//! with Poisson's ratio 0: w (w + 1)/3 is the second moment of a window of 2 w + 1 vertices, in squared cells, and a
//! deformation that varies slowly moves a goal position away from its vertex by half of this moment times the second
//! derivative of the deformation. The length R = h √(w (w + 1)) is the radius of the regions. E is the product of
//! ρ/(3 dt²), alpha and R², so that alpha <= 1 is possible only if R >= dt √(3 E/ρ), for cells of any size.
//!
//! Regions of one cell have w = 1/2: two vertices along each axis. Their law is exact for every even
//! deformation.
//!
//! With Poisson's ratio ν, the volume term of the regions leaves the shear modulus the same, so that E is (1 + ν) times
//! this one. Its strength k = 3 ν/(1 - 2 ν) limits alpha to 1.5/(1 + k): above it, the fastest modes of a thin body
//! would gain energy. E is then at most min(1 + ν, 1.5 - 3 ν) times the one of alpha = 1 and ν = 0.

use crate::matching::{HalfWidth, bulk_of};

/// The elastic law of shape matching: E = (1 + ν) ρ (alpha/dt²) h² w (w + 1)/3.
///
/// It relates Young's modulus E of a body to the half-width w of its regions in cells and to alpha, the fraction of the
/// distance to its goal position that a vertex covers in a step ([`Stiffness::PerStep`](crate::Stiffness::PerStep)).
/// The fields are the parameters that do not depend on the regions. All of them but ν must be > 0.
///
/// ```
/// use supple::ElasticLaw;
///
/// let law = ElasticLaw { density: 1000.0, cell_size: 0.1, dt: 0.01, poisson_ratio: 0.0 };
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
    /// Poisson's ratio ν, in [0, 0.47].
    pub poisson_ratio: f64,
}

impl ElasticLaw {
    /// Computes Young's modulus, in scene units of force per area, of regions of half-width `half_width` in cells
    /// with the stiffness `alpha` per step, in (0, 1] and at most [`greatest_alpha`](Self::greatest_alpha).
    pub fn modulus(&self, half_width: impl Into<HalfWidth>, alpha: f64) -> f64 {
        alpha * self.greatest_modulus(half_width.into())
    }

    /// Computes alpha for Young's modulus `modulus` > 0, in scene units of force per area, and regions of half-width
    /// `half_width` in cells. It exceeds [`greatest_alpha`](Self::greatest_alpha), and no body can have it, if the
    /// regions are too small or the step is too long.
    pub fn alpha(&self, half_width: impl Into<HalfWidth>, modulus: f64) -> f64 {
        modulus / self.greatest_modulus(half_width.into())
    }

    /// Returns the greatest alpha with which steps are stable: 1, or 1.5/(1 + k) with k = 3 ν/(1 - 2 ν) if that is
    /// less.
    pub fn greatest_alpha(&self) -> f64 {
        Self::greatest_alpha_of(self.poisson_ratio)
    }

    /// Returns [`greatest_alpha`](Self::greatest_alpha) for Poisson's ratio.
    pub fn greatest_alpha_of(poisson_ratio: f64) -> f64 {
        (1.5 / (1.0 + bulk_of(poisson_ratio))).min(1.0)
    }

    /// Returns Young's modulus at alpha = 1.
    fn greatest_modulus(&self, half_width: HalfWidth) -> f64 {
        let square = (self.cell_size / self.dt).powi(2);
        (1.0 + self.poisson_ratio) * self.density * square * half_width.moment()
    }

    /// Returns the least whole half-width, from 1 to `limit`, for which alpha is at most the greatest one. Returns
    /// `limit` if alpha exceeds it for all of them.
    pub(crate) fn least_half_width(&self, modulus: f64, limit: usize) -> HalfWidth {
        // The largest half-width is far below 2^53.
        let moment =
            modulus / (modulus_range(self.poisson_ratio) * self.density * (self.cell_size / self.dt).powi(2));
        let root = half_width_of(3.0 * moment);
        // A rounding error of a whole number of cells must not give another cell.
        let least = (root * (1.0 - 1e-12)).ceil();
        HalfWidth::whole(if least < limit as f64 { (least as usize).max(1) } else { limit })
    }

    /// Returns the length of the longest step for which alpha is at most the greatest one with regions of half-width
    /// `half_width`. `dt` does not count.
    pub(crate) fn longest_step(&self, half_width: HalfWidth, modulus: f64) -> f64 {
        let density = modulus_range(self.poisson_ratio) * self.density;
        self.cell_size * (density * half_width.moment() / modulus).sqrt()
    }
}

/// Returns Young's modulus at the greatest alpha over the one at alpha = 1 and ν = 0.
fn modulus_range(poisson_ratio: f64) -> f64 {
    (1.0 + poisson_ratio) * ElasticLaw::greatest_alpha_of(poisson_ratio)
}

/// Returns the number w > 0 with w (w + 1) = `product`.
pub(crate) fn half_width_of(product: f64) -> f64 {
    (product + 0.25).sqrt() - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_half_width_is_the_first_whose_alpha_is_at_most_one() {
        for (half_width, poisson_ratio) in
            [1, 2, 3, 7, 30, 1000].into_iter().flat_map(|w| [0.0, 0.1, 0.25, 0.45].map(|nu| (w, nu)))
        {
            let law = ElasticLaw { density: 700.0, cell_size: 0.1, dt: 1.0 / 240.0, poisson_ratio };
            let greatest = law.greatest_alpha();
            let modulus = law.modulus(half_width, greatest);
            assert_eq!(law.least_half_width(modulus, 2000), half_width);
            assert_eq!(law.least_half_width(1.0001 * modulus, 2000), half_width + 1);
            assert_eq!(law.least_half_width(0.9999 * modulus, 2000), half_width);
            assert!((law.alpha(half_width, 0.3 * modulus) - 0.3 * greatest).abs() < 1e-12);
            let longest = law.longest_step(half_width.into(), modulus);
            assert!((longest - law.dt).abs() < 1e-12 * law.dt);
        }
        let law = ElasticLaw { density: 700.0, cell_size: 0.1, dt: 1.0 / 240.0, poisson_ratio: 0.3 };
        assert_eq!(law.least_half_width(1e300, 12), 12);
        assert_eq!(law.least_half_width(1e-300, 12), 1);
    }

    #[test]
    fn the_modulus_range_is_that_of_the_law_with_poisson_ratio() {
        for nu in [0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.47_f64] {
            assert!((modulus_range(nu) - (1.0 + nu).min(1.5 - 3.0 * nu)).abs() < 1e-12, "{nu}");
        }
        assert_eq!((ElasticLaw::greatest_alpha_of(0.0), modulus_range(0.0)), (1.0, 1.0));
    }
}
