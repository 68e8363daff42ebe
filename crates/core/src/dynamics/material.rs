//! The material of a body, in parameters per step or in physical units that are independent of the time step.

use crate::range::{RangeError, in_range};
use crate::state::sin_cos_degrees;

/// The size of the regions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RegionSize {
    /// Half-width of a region in cells, at least 1. A larger half-width or a coarser lattice is stiffer.
    Cells(usize),
    /// Half-width as a length in scene units, > 0. It is rounded to whole cells, at least one.
    Radius(f64),
}

/// Stiffness: how fast vertices move to their goal positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stiffness {
    /// alpha: the fraction of the distance to the goal covered in one step, in (0, 1].
    PerStep(f64),
    /// Frequency f in Hz, > 0, at which a vertex oscillates about a fixed goal.
    /// alpha = 2 (1 - cos(2 π f dt)), at most 1; alpha reaches 1 where f is a sixth of the step rate.
    Frequency(f64),
}

/// Region damping: the fraction of the non-rigid velocity within regions that is removed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RegionDamping {
    /// Fraction per step, in [0, 1]; 0 disables the stage.
    PerStep(f64),
    /// Rate in 1/s, >= 0: the fraction per step is 1 - exp(-rate dt).
    Rate(f64),
}

/// The material of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Size of the regions; default 2 cells.
    pub region_size: RegionSize,
    /// Stiffness; default alpha = 1 per step.
    pub stiffness: Stiffness,
    /// Region damping; default 0.
    pub region_damping: RegionDamping,
    /// Mass per volume in scene units, > 0; default 1000.
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
    /// A value out of its range.
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

    /// The half-width of the regions in cells, from 1 to `extent`, the extent of the lattice in cells.
    pub(crate) fn half_width(&self, cell_size: f64, extent: usize) -> usize {
        let cells = match self.region_size {
            RegionSize::Cells(cells) => cells,
            RegionSize::Radius(radius) => (radius / cell_size).round() as usize,
        };
        cells.clamp(1, extent.max(1))
    }

    /// alpha, the fraction of the distance to the goal covered in one step of `dt` seconds.
    pub fn alpha(&self, dt: f64) -> f64 {
        match self.stiffness {
            Stiffness::PerStep(alpha) => alpha,
            Stiffness::Frequency(frequency) => {
                // 2 (1 - cos 2x) = 4 sin² x, which does not cancel at low frequencies. From f dt = 1/6 on
                // alpha is 1, so f dt is capped at 1/2, where the sine stops growing.
                let (sine, _) = sin_cos_degrees(180.0 * (frequency * dt).min(0.5));
                (4.0 * sine * sine).min(1.0)
            }
        }
    }

    /// The fraction of the non-rigid velocity within regions that damping removes in a step of `dt` seconds.
    pub fn region_damping_share(&self, dt: f64) -> f64 {
        match self.region_damping {
            RegionDamping::PerStep(share) => share,
            RegionDamping::Rate(rate) => -(-rate * dt).exp_m1(),
        }
    }

    /// Whether region damping is enabled.
    pub(crate) fn is_damped(&self) -> bool {
        !matches!(self.region_damping, RegionDamping::PerStep(0.0) | RegionDamping::Rate(0.0))
    }
}
