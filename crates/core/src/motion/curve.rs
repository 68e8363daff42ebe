//! Numbers that change along keyframes.

use super::interpolation::{self, Interpolation};
use super::keyframes::MotionError;

/// A keyframe of a number: a value at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurveKey {
    /// Time in seconds from the start of the simulation. The times of consecutive keyframes must increase.
    pub time: f64,
    /// The number at this time.
    pub value: f64,
}

/// A number along keyframes. It is linear in time between two keyframes unless it has another [`Interpolation`], and
/// constant before the first and after the last keyframe.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Curve {
    keys: Vec<CurveKey>,
    interpolation: Interpolation,
}

impl Curve {
    /// Creates the curve along the keyframes `keys`, in strictly increasing order of time.
    ///
    /// # Errors
    /// If the list is empty, a number is not finite, or the times do not increase.
    pub fn new(keys: Vec<CurveKey>) -> Result<Self, MotionError> {
        if keys.is_empty() {
            return Err(MotionError::NoKeys);
        }
        for (index, key) in keys.iter().enumerate() {
            for (name, value) in [("time", key.time), ("value", key.value)] {
                if !value.is_finite() {
                    return Err(MotionError::NotFinite { key: index, name, value });
                }
            }
            MotionError::check_order(index, key.time, index.checked_sub(1).map(|before| keys[before].time))?;
        }
        Ok(Self { keys, interpolation: Interpolation::Linear })
    }

    /// Returns the curve with another interpolation between the keyframes.
    #[must_use]
    pub fn interpolated(self, interpolation: Interpolation) -> Self {
        Self { interpolation, ..self }
    }

    /// Returns the keyframes, in order of time.
    pub fn keys(&self) -> &[CurveKey] {
        &self.keys
    }

    /// Returns the interpolation between the keyframes.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Returns the number at `time`, in seconds. It is between the values of the two keyframes around `time`.
    pub fn value(&self, time: f64) -> f64 {
        interpolation::value_at(&self.keys, (time, self.interpolation), |key| key.time, |key| key.value)
    }

    /// Returns the greatest value of a keyframe.
    pub fn greatest(&self) -> f64 {
        self.keys.iter().map(|key| key.value).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the number if it is the same at all times.
    pub fn constant(&self) -> Option<f64> {
        let first = self.keys[0].value;
        self.keys.iter().all(|key| key.value == first).then_some(first)
    }
}

/// The number that never changes.
impl From<f64> for Curve {
    fn from(value: f64) -> Self {
        Self { keys: vec![CurveKey { time: 0.0, value }], interpolation: Interpolation::Linear }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(keys: &[(f64, f64)]) -> Curve {
        Curve::new(keys.iter().map(|&(time, value)| CurveKey { time, value }).collect()).unwrap()
    }

    #[test]
    fn a_curve_is_constant_outside_its_keys_and_between_them_within_their_values() {
        let curve = curve(&[(1.0, 2.0), (3.0, 6.0), (4.0, 5.0)]);
        assert_eq!([0.0, 1.0, 2.0, 3.5, 9.0].map(|time| curve.value(time)), [2.0, 2.0, 4.0, 5.5, 5.0]);
        let smooth = curve.clone().interpolated(Interpolation::Smooth);
        assert_eq!([1.0, 1.5, 2.0].map(|time| smooth.value(time)), [2.0, 2.0 + 4.0 * 5.0 / 32.0, 4.0]);
        let cubic = curve.interpolated(Interpolation::Cubic);
        let values = (0..=60).map(|k| cubic.value(1.0 + f64::from(k) / 20.0));
        assert!(values.into_iter().all(|value| (2.0..=6.0).contains(&value)));
    }

    #[test]
    fn rounding_errors_do_not_lie_beyond_the_keys() {
        let curve = curve(&[(0.0, 10.0), (1.0, 0.1)]);
        for interpolation in [Interpolation::Linear, Interpolation::Smooth, Interpolation::Cubic] {
            let curve = curve.clone().interpolated(interpolation);
            for k in 1..1000 {
                let value = curve.value(1.0 - f64::from(k) * f64::EPSILON);
                assert!((0.1..=10.0).contains(&value), "{interpolation:?}: {value}");
            }
        }
    }

    #[test]
    fn keys_out_of_order_and_numbers_that_are_not_finite_are_errors() {
        assert_eq!(Curve::new(Vec::new()), Err(MotionError::NoKeys));
        let keys =
            |pairs: [(f64, f64); 2]| Curve::new(pairs.map(|(time, value)| CurveKey { time, value }).into());
        let order = MotionError::NotIncreasing { key: 1, time: 1.0, previous: 1.0 };
        assert_eq!(keys([(1.0, 0.0), (1.0, 2.0)]), Err(order));
        let infinite = keys([(0.0, 1.0), (1.0, f64::INFINITY)]);
        assert_eq!(infinite, Err(MotionError::NotFinite { key: 1, name: "value", value: f64::INFINITY }));
    }

    #[test]
    fn only_a_curve_that_never_changes_is_constant() {
        assert_eq!(Curve::from(1.5).constant(), Some(1.5));
        assert_eq!(curve(&[(0.0, 1.0), (1.0, 1.0)]).constant(), Some(1.0));
        assert_eq!(curve(&[(0.0, 1.0), (1.0, 2.0)]).constant(), None);
    }
}
