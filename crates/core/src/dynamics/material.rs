//! Defines the material of a body. Its parameters are per step, or in physical units that do not depend on
//! the time step.

use crate::range::{RangeError, in_range};
use crate::state::sin_cos_degrees;

/// Size of the regions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RegionSize {
    /// Half-width of the regions in cells, at least 1. A body with a larger half-width is stiffer. At the
    /// same half-width, a body with larger cells is stiffer.
    Cells(usize),
    /// Half-width of the regions as a length in scene units, > 0. It is rounded to a whole number of cells,
    /// at least one.
    Radius(f64),
}

/// Stiffness: the rate at which vertices move towards their goal positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stiffness {
    /// alpha, in (0, 1]: the fraction of the distance to the goal position that a vertex covers in one step.
    PerStep(f64),
    /// Frequency f in Hz, > 0, at which a vertex oscillates about a fixed goal position.
    /// alpha = 2 (1 - cos(2 π f dt)), limited to 1. alpha reaches 1 if f is a sixth of the step rate 1/dt.
    Frequency(f64),
}

/// Region damping: the fraction of the non-rigid velocity within regions that a step removes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RegionDamping {
    /// Fraction per step, in [0, 1]; 0 disables the stage.
    PerStep(f64),
    /// Rate in 1/s, >= 0. The fraction per step is 1 - exp(-rate dt); 0 disables the stage.
    Rate(f64),
}

/// Material of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Size of the regions; default 2 cells.
    pub region_size: RegionSize,
    /// Stiffness; default alpha = 1 per step.
    pub stiffness: Stiffness,
    /// Region damping; default 0.
    pub region_damping: RegionDamping,
    /// Density: mass per volume in scene units, > 0; default 1000.
    pub density: f64,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            region_size: RegionSize::Cells(2),
            stiffness: Stiffness::PerStep(1.0),
            region_damping: RegionDamping::PerStep(0.0),
            density: 1000.0,
        }
    }
}

impl Material {
    /// Checks the ranges of all values.
    ///
    /// # Errors
    ///
    /// If a value is out of its range.
    pub fn validate(&self) -> Result<(), RangeError> {
        match self.region_size {
            RegionSize::Cells(w) => {
                in_range("half_width", w as f64, w >= 1, "a whole number of cells, at least 1")
            }
            RegionSize::Radius(r) => in_range("stiffness_radius", r, r > 0.0, "a length > 0"),
        }?;
        match self.stiffness {
            Stiffness::PerStep(a) => in_range("stiffness", a, a > 0.0 && a <= 1.0, "in (0, 1]"),
            Stiffness::Frequency(f) => in_range("frequency", f, f > 0.0, "a frequency in Hz, > 0"),
        }?;
        match self.region_damping {
            RegionDamping::PerStep(d) => in_range("region_damping", d, (0.0..=1.0).contains(&d), "in [0, 1]"),
            RegionDamping::Rate(r) => in_range("region_damping_rate", r, r >= 0.0, "a rate in 1/s, >= 0"),
        }?;
        in_range("density", self.density, self.density > 0.0, "> 0").map(drop)
    }

    /// Returns the half-width of the regions in cells, clamped to the range from 1 to `extent`, the extent of
    /// the lattice in cells. `cell_size` is in scene units.
    pub(crate) fn half_width(&self, cell_size: f64, extent: usize) -> usize {
        let cells = match self.region_size {
            RegionSize::Cells(cells) => cells,
            RegionSize::Radius(radius) => (radius / cell_size).round() as usize,
        };
        cells.clamp(1, extent.max(1))
    }

    /// Computes alpha, the fraction of the distance to the goal position that a vertex covers in one step of
    /// `dt` seconds.
    pub fn alpha(&self, dt: f64) -> f64 {
        match self.stiffness {
            Stiffness::PerStep(alpha) => alpha,
            Stiffness::Frequency(frequency) => {
                // alpha = 2 (1 - cos 2x) is computed as 4 sin² x, which does not cancel at low frequencies.
                // alpha is 1 for every f dt >= 1/6. So f dt is capped at 1/2, above which the sine would
                // decrease.
                let (sine, _) = sin_cos_degrees(180.0 * (frequency * dt).min(0.5));
                (4.0 * sine * sine).min(1.0)
            }
        }
    }

    /// Computes the fraction of the non-rigid velocity within regions that damping removes in one step of
    /// `dt` seconds.
    pub fn region_damping_fraction(&self, dt: f64) -> f64 {
        match self.region_damping {
            RegionDamping::PerStep(fraction) => fraction,
            RegionDamping::Rate(rate) => -(-rate * dt).exp_m1(),
        }
    }

    /// Returns whether region damping is enabled.
    pub(crate) fn is_damped(&self) -> bool {
        !matches!(self.region_damping, RegionDamping::PerStep(0.0) | RegionDamping::Rate(0.0))
    }
}
