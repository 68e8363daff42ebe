//! The material of a body: per step, or in physical terms that do not change with the step.

use crate::range::{RangeError, in_range};
use crate::state::sin_cos_degrees;

/// The size of the regions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RegionSize {
    /// Half-width of a region in cells, at least 1. Larger is stiffer; so is a coarser lattice.
    Cells(usize),
    /// Half-width as a length in scene units, > 0: rounded to whole cells, at least one.
    Radius(f64),
}

/// How strongly vertices are pulled towards their goal positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stiffness {
    /// alpha, the share of the way to the goal in one step, in (0, 1].
    PerStep(f64),
    /// The frequency in Hz, > 0, of a vertex that swings about its goal: alpha = 2 (1 - cos(2 π f dt)), at most 1.
    /// It caps at a sixth of the step rate.
    Frequency(f64),
}

/// Region damping: how much of the motion within a region is removed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RegionDamping {
    /// The share in one step, in [0, 1]; 0 leaves the stage out.
    PerStep(f64),
    /// A rate in 1/s, >= 0: the share in a step is 1 - exp(-rate dt).
    Rate(f64),
}

/// The material of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// The size of the regions; default 2 cells.
    pub region_size: RegionSize,
    /// How strongly vertices are pulled towards their goal positions; default 1 per step.
    pub stiffness: Stiffness,
    /// Region damping; default none.
    pub region_damping: RegionDamping,
    /// Mass per volume, > 0; default 1000.
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
    /// Checks the ranges.
    ///
    /// # Errors
    ///
    /// A number out of its range.
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

    /// The half-width of the regions in cells, on a lattice that spans `extent` cells.
    pub(crate) fn half_width(&self, cell_size: f64, extent: usize) -> usize {
        let cells = match self.region_size {
            RegionSize::Cells(cells) => cells,
            RegionSize::Radius(radius) => (radius / cell_size).round() as usize,
        };
        cells.clamp(1, extent.max(1))
    }

    /// alpha, the share of the way to the goal in one step, for steps of `dt` seconds.
    pub fn alpha(&self, dt: f64) -> f64 {
        match self.stiffness {
            Stiffness::PerStep(alpha) => alpha,
            Stiffness::Frequency(frequency) => {
                // 2 (1 - cos 2x) = 4 sin² x, which keeps its digits at slow frequencies. Up to 1/6 of a turn per step
                // the cosine falls; beyond, alpha has long been capped.
                let (sine, _) = sin_cos_degrees(180.0 * (frequency * dt).min(0.5));
                (4.0 * sine * sine).min(1.0)
            }
        }
    }

    /// The share of the motion within a region that damping takes out in a step of `dt` seconds.
    pub fn region_damping_share(&self, dt: f64) -> f64 {
        match self.region_damping {
            RegionDamping::PerStep(share) => share,
            RegionDamping::Rate(rate) => -(-rate * dt).exp_m1(),
        }
    }

    /// Whether there is any damping.
    pub(crate) fn is_damped(&self) -> bool {
        !matches!(self.region_damping, RegionDamping::PerStep(0.0) | RegionDamping::Rate(0.0))
    }
}
