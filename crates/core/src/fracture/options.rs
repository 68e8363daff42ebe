//! Options of fracture: when joints break, and how cracks look.

use super::cut::CutSurface;
use crate::range::{Range, RangeError, in_range};

/// When a body breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BreakLimit {
    /// Tensile stress, > 0: force per area in scene units. The strain at which a joint breaks is this stress divided by
    /// Young's modulus in force at its place.
    Strength(f64),
    /// Tensile strain, > 0: 0.15 breaks where the material is stretched by 15 %.
    Strain(f64),
}

/// Options of a body that can break. The fields have the names and defaults of the keys in a scene file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FractureOptions {
    /// Where a joint breaks: the greatest principal strain at which it holds, without plastic strain.
    pub limit: BreakLimit,
    /// Angle in degrees, in (0, 180], between the rotations of two neighboring cells at which their joint breaks
    /// (Rivers & James 2007, section 6). It depends on the size of the cells. `None`, the default: rotations break
    /// nothing.
    pub rotation: Option<f64>,
    /// Greatest number of cracks that can grow in each connected part of the body, those that have stopped included,
    /// up to four times the strain limit; from 1 to [`FractureOptions::MAX_CRACKS`]; default 1.
    pub cracks: usize,
    /// Relative variation of the limit from joint to joint, in [0, 0.5]; default 0.05.
    pub noise: f64,
    /// Seed of the variation; default 0.
    pub seed: u64,
    /// Shape of the surfaces of cracks; default smooth.
    pub surface: CutSurface,
}

impl FractureOptions {
    /// Default of [`FractureOptions::noise`].
    pub const NOISE: f64 = 0.05;
    /// Largest value of [`FractureOptions::cracks`].
    pub const MAX_CRACKS: u32 = 1_000_000;

    /// Creates options with defaults for all but the limit.
    pub fn new(limit: BreakLimit) -> Self {
        Self { limit, rotation: None, cracks: 1, noise: Self::NOISE, seed: 0, surface: CutSurface::default() }
    }

    /// Checks the ranges.
    pub(crate) fn validate(&self) -> Result<(), RangeError> {
        match self.limit {
            BreakLimit::Strength(stress) => Range::POSITIVE.check("strength", stress)?,
            BreakLimit::Strain(strain) => Range::POSITIVE.check("strain", strain)?,
        };
        if let Some(angle) = self.rotation {
            Range::BREAK_ANGLE.check("rotation", angle)?;
        }
        let has_cracks = (1..=Self::MAX_CRACKS as usize).contains(&self.cracks);
        in_range("cracks", self.cracks as f64, has_cracks, "from 1 to 1000000")?;
        Range::NOISE.check("noise", self.noise)?;
        Ok(())
    }

    /// Returns the strain at which joints without variation break, for Young's modulus `modulus` in force.
    pub fn strain_limit(&self, modulus: f64) -> f64 {
        match self.limit {
            BreakLimit::Strength(stress) => stress / modulus,
            BreakLimit::Strain(strain) => strain,
        }
    }
}
