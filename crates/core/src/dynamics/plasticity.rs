//! Plasticity: how a body keeps a dent.

use crate::matching::Flow;
use crate::range::{Range, RangeError};

/// Plasticity of a body: parts that are strained beyond a limit keep a part of their deformation.
///
/// Each region has a plastic shape, a symmetric matrix S of determinant 1, which takes the place of the rest shape of
/// the region; it is the identity at first. The strain is the deviatoric part of the stretch of the region from its
/// plastic shape, relative to the mean stretch. So a change of the volume alone is elastic. Norms are Frobenius norms:
/// the strain of a bar that is pulled to 1 + e times its length is √6 e/(3 + e), about 0.82 e, as long as it is
/// elastic. If it keeps this length at its volume, |S - 1| is about 1.22 e.
///
/// The regions must be small beside the parts that bend or are pressed: their radius at most about 0.15 of the
/// thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Plasticity {
    /// Strain beyond which a region flows, in (0, 1]; default 0.05. Smaller deformations are elastic.
    pub yield_strain: f64,
    /// Rate in 1/s, > 0, at which the strain beyond the yield strain becomes plastic, at most half of it in a step;
    /// default 5.
    pub creep: f64,
    /// Greatest |S - 1|, in (0, 2]; default 1. At 1, a region keeps at most 1.9 times its length, or 0.41 times; at 2,
    /// 2.9 times or 0.19 times. A body with a yield strain near 0 and a greatest one above 1 may not come to rest.
    pub max: f64,
}

impl Default for Plasticity {
    fn default() -> Self {
        Self { yield_strain: 0.05, creep: 5.0, max: 1.0 }
    }
}

/// Greatest part of the strain beyond the yield strain that becomes plastic in a step. With the whole of it, the shapes
/// of regions that are crushed flat would follow each oscillation, and drive it.
const GREATEST_FRACTION: f64 = 0.5;

impl Plasticity {
    /// Checks the ranges of all values.
    ///
    /// # Errors
    ///
    /// If a value is out of its range.
    pub fn validate(&self) -> Result<(), RangeError> {
        let Self { yield_strain, creep, max } = *self;
        Range::POSITIVE_FRACTION.check("plastic.yield", yield_strain)?;
        Range::CREEP.check("plastic.creep", creep)?;
        Range::PLASTIC_STRAIN.check("plastic.max", max).map(drop)
    }

    /// Returns the part of the strain beyond the yield strain that becomes plastic in a step of `dt` seconds.
    pub(crate) fn fraction(&self, dt: f64) -> f64 {
        (-libm::expm1(-self.creep * dt)).min(GREATEST_FRACTION)
    }

    /// Returns the flow in a step of `dt` seconds.
    pub(crate) fn flow(&self, dt: f64) -> Flow {
        Flow {
            fraction: self.fraction(dt) as f32,
            yield_strain: self.yield_strain as f32,
            max: self.max as f32,
        }
    }
}
