//! Numbers of a body that change along keyframes.

use crate::motion::Curve;
use crate::range::{Range, RangeError};

/// Numbers of the material of a body that change along keyframes, over the time of the simulation. `None`: the number of
/// the [material](crate::Material) or of [`TouchingOptions`](crate::TouchingOptions) holds at all times. Before the first
/// step, and for the choice of the regions and of the number of steps, the greatest value counts.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct KeyedMaterial {
    /// Young's modulus, > 0. It counts while the elasticity of the body is a Young's modulus.
    pub youngs_modulus: Option<Curve>,
    /// Poisson's ratio, in [0, 0.47].
    pub poisson_ratio: Option<Curve>,
    /// Damping ratio of the lowest elastic mode, in [0, 1].
    pub damping_ratio: Option<Curve>,
    /// Coulomb friction coefficient of the body at other bodies, >= 0.
    pub friction: Option<Curve>,
}

impl KeyedMaterial {
    /// Returns the names of the numbers, their ranges and their keyframes.
    fn numbers(&self) -> [(&'static str, Range, Option<&Curve>); 4] {
        [
            ("youngs_modulus", Range::YOUNGS_MODULUS, self.youngs_modulus.as_ref()),
            ("poisson_ratio", Range::POISSON_RATIO, self.poisson_ratio.as_ref()),
            ("damping_ratio", Range::FRACTION, self.damping_ratio.as_ref()),
            ("friction", Range::NOT_NEGATIVE, self.friction.as_ref()),
        ]
    }

    /// Returns the names of the numbers that have keyframes.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.numbers().into_iter().filter(|(.., curve)| curve.is_some()).map(|(name, ..)| name)
    }

    fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.numbers().into_iter().filter_map(|(.., curve)| curve)
    }

    /// Returns these keyframes with those of `others` in place of them where both have some.
    #[must_use]
    pub fn replaced_by(self, others: Self) -> Self {
        Self {
            youngs_modulus: others.youngs_modulus.or(self.youngs_modulus),
            poisson_ratio: others.poisson_ratio.or(self.poisson_ratio),
            damping_ratio: others.damping_ratio.or(self.damping_ratio),
            friction: others.friction.or(self.friction),
        }
    }

    /// Returns whether no number has keyframes.
    pub fn is_empty(&self) -> bool {
        self.names().next().is_none()
    }

    /// Checks the ranges.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn validate(&self) -> Result<(), RangeError> {
        for (name, range, curve) in self.numbers() {
            for key in curve.into_iter().flat_map(Curve::keys) {
                range.check(name, key.value)?;
            }
        }
        Ok(())
    }

    /// Returns whether all keyframes are valid.
    pub(crate) fn is_valid(&self) -> bool {
        self.curves().all(Curve::is_valid) && self.validate().is_ok()
    }

    /// Returns whether any number at the end of a step is another one than at its start.
    pub(crate) fn changes(&self, start: f64, end: f64) -> bool {
        self.curves().any(|curve| curve.value(start) != curve.value(end))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::CurveKey;

    #[test]
    fn numbers_out_of_range_are_errors_that_name_them() {
        let curve = |value| {
            let keys = [(0.0, 0.1), (1.0, value)].map(|(time, value)| CurveKey { time, value });
            Some(Curve::new(keys.to_vec()).unwrap())
        };
        assert!(KeyedMaterial { poisson_ratio: curve(0.47), ..KeyedMaterial::default() }.validate().is_ok());
        for (name, keyed) in [
            ("youngs_modulus", KeyedMaterial { youngs_modulus: curve(0.0), ..KeyedMaterial::default() }),
            ("poisson_ratio", KeyedMaterial { poisson_ratio: curve(0.48), ..KeyedMaterial::default() }),
            ("damping_ratio", KeyedMaterial { damping_ratio: curve(1.1), ..KeyedMaterial::default() }),
            ("friction", KeyedMaterial { friction: curve(-0.1), ..KeyedMaterial::default() }),
        ] {
            let error = keyed.validate().unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
            assert!(!keyed.is_valid() && !keyed.is_empty());
            assert_eq!(keyed.names().collect::<Vec<_>>(), [name]);
        }
    }
}
