//! Numbers and vectors that change along keyframes.

use nalgebra::Vector3;

use super::interpolation::{self, Interpolation};
use super::keyframes::MotionError;

/// A value of a [`Curve`]: a number, or a vector of three.
pub trait CurveValue: Copy + PartialEq {
    /// How many numbers the value has.
    const LEN: usize;

    /// Returns the number with an index below [`LEN`](Self::LEN).
    fn number(&self, index: usize) -> f64;

    /// Returns the value of some numbers.
    fn from_numbers(number: impl Fn(usize) -> f64) -> Self;
}

impl CurveValue for f64 {
    const LEN: usize = 1;

    fn number(&self, _index: usize) -> f64 {
        *self
    }

    fn from_numbers(number: impl Fn(usize) -> f64) -> Self {
        number(0)
    }
}

impl CurveValue for [f64; 3] {
    const LEN: usize = 3;

    fn number(&self, index: usize) -> f64 {
        self[index]
    }

    fn from_numbers(number: impl Fn(usize) -> f64) -> Self {
        std::array::from_fn(number)
    }
}

/// A keyframe of a number or a vector: a value at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CurveKey<V = f64> {
    /// Time in seconds from the start of the simulation. The times of consecutive keyframes must increase.
    pub time: f64,
    /// The value at this time.
    pub value: V,
}

/// A number, or with `V = [f64; 3]` a vector, along keyframes. It is linear in time between two keyframes unless it has
/// another [`Interpolation`], and constant before the first and after the last keyframe.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Curve<V = f64> {
    keys: Vec<CurveKey<V>>,
    interpolation: Interpolation,
}

impl<V: CurveValue> Curve<V> {
    /// Creates the curve along the keyframes `keys`, in strictly increasing order of time.
    ///
    /// # Errors
    /// If the list is empty, a number is not finite, or the times do not increase.
    pub fn new(keys: Vec<CurveKey<V>>) -> Result<Self, MotionError> {
        let values = |value: V| (0..V::LEN).map(move |index| ("value", value.number(index)));
        MotionError::check(&keys, |key| key.time, |key| values(key.value))?;
        Ok(Self { keys, interpolation: Interpolation::Linear })
    }

    /// Returns the curve with another interpolation between the keyframes.
    #[must_use]
    pub fn interpolated(self, interpolation: Interpolation) -> Self {
        Self { interpolation, ..self }
    }

    /// Returns the keyframes, in order of time.
    pub fn keys(&self) -> &[CurveKey<V>] {
        &self.keys
    }

    /// Returns the interpolation between the keyframes.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Returns the value at `time`, in seconds. Each number is between those of the two keyframes around `time`.
    pub fn value(&self, time: f64) -> V {
        let at = (time, self.interpolation);
        V::from_numbers(|index| {
            interpolation::value_at(&self.keys, at, |key| key.time, |key| key.value.number(index))
        })
    }

    /// Returns whether the keyframes are valid; deserialized ones may not be.
    pub(crate) fn is_valid(&self) -> bool {
        Self::new(self.keys.clone()).is_ok()
    }

    /// Returns the value if it is the same at all times.
    pub fn constant(&self) -> Option<V> {
        let first = self.keys[0].value;
        self.keys.iter().all(|key| key.value == first).then_some(first)
    }
}

impl Curve {
    /// Returns the greatest value of a keyframe.
    pub fn greatest(&self) -> f64 {
        self.keys.iter().map(|key| key.value).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Curve<[f64; 3]> {
    /// Returns the longest vector of a keyframe, of several the first.
    pub fn longest(&self) -> [f64; 3] {
        let length = |key: &CurveKey<[f64; 3]>| Vector3::from(key.value).norm();
        let longer = |a, b| if length(b) > length(a) { b } else { a };
        self.keys.iter().reduce(longer).map(|key| key.value).unwrap_or_default()
    }
}

/// The value that never changes.
impl<V: CurveValue> From<V> for Curve<V> {
    fn from(value: V) -> Self {
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
        assert_eq!(Curve::<f64>::new(Vec::new()), Err(MotionError::NoKeys));
        let keys =
            |pairs: [(f64, f64); 2]| Curve::new(pairs.map(|(time, value)| CurveKey { time, value }).into());
        let order = MotionError::NotIncreasing { key: 1, time: 1.0, previous: 1.0 };
        assert_eq!(keys([(1.0, 0.0), (1.0, 2.0)]), Err(order));
        let infinite = keys([(0.0, 1.0), (1.0, f64::INFINITY)]);
        assert_eq!(infinite, Err(MotionError::NotFinite { key: 1, name: "value", value: f64::INFINITY }));
    }

    #[test]
    fn vectors_are_interpolated_by_component() {
        let key = |time, value| CurveKey { time, value };
        let keys = vec![key(1.0, [0.0, -9.0, 0.0]), key(3.0, [4.0, 3.0, 0.0]), key(4.0, [0.0, 9.0, 0.0])];
        let curve = Curve::new(keys.clone()).unwrap();
        assert_eq!(
            [0.0, 2.0, 9.0].map(|time| curve.value(time)),
            [[0.0, -9.0, 0.0], [2.0, -3.0, 0.0], [0.0, 9.0, 0.0]]
        );
        assert_eq!(curve.longest(), [0.0, -9.0, 0.0]);
        assert_eq!((curve.constant(), Curve::from([1.0; 3]).constant()), (None, Some([1.0; 3])));
        let nan = vec![key(1.0, [0.0, 0.0, f64::NAN])];
        assert!(matches!(Curve::new(nan), Err(MotionError::NotFinite { key: 0, name: "value", .. })));
    }

    #[test]
    fn only_a_curve_that_never_changes_is_constant() {
        assert_eq!(Curve::from(1.5).constant(), Some(1.5));
        assert_eq!(curve(&[(0.0, 1.0), (1.0, 1.0)]).constant(), Some(1.0));
        assert_eq!(curve(&[(0.0, 1.0), (1.0, 2.0)]).constant(), None);
    }
}
