//! Switches: what is on or off along keyframes.

use super::keyframes::MotionError;

/// A keyframe of a switch: whether it is on from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SwitchKey {
    /// Time in seconds from the start of the simulation. The times of consecutive keyframes must increase.
    pub time: f64,
    /// Whether the switch is on from this time until the next keyframe.
    pub value: bool,
}

/// Whether something is on, at all times or along keyframes. A value holds from its keyframe until the next one.
///
/// A first keyframe after the time 0 switches: before it, the switch has the other value. A first keyframe at the time 0
/// or before it also holds for all times before.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Vec<SwitchKey>"))]
pub struct Switch(Vec<SwitchKey>);

impl Switch {
    /// Creates the switch along the keyframes `keys`, in strictly increasing order of time.
    ///
    /// # Errors
    /// If the list is empty, a time is not finite, or the times do not increase.
    pub fn new(keys: Vec<SwitchKey>) -> Result<Self, MotionError> {
        MotionError::check(&keys, |key| key.time, |_| [])?;
        Ok(Self(keys))
    }

    /// Returns the keyframes, in order of time.
    pub fn keys(&self) -> &[SwitchKey] {
        &self.0
    }

    /// Returns whether the switch is on at `time`, in seconds. Times within rounding of a keyframe are its time.
    pub fn value(&self, time: f64) -> bool {
        let rounded = if time.is_finite() { time + 8.0 * f64::EPSILON * time.abs() } else { time };
        let after = self.0.partition_point(|key| key.time <= rounded);
        match after.checked_sub(1) {
            Some(last) => self.0[last].value,
            None => self.0[0].value != (self.0[0].time > 0.0),
        }
    }

    /// Returns the value if it is the same at all times.
    pub fn constant(&self) -> Option<bool> {
        let first = self.value(f64::NEG_INFINITY);
        self.0.iter().all(|key| key.value == first).then_some(first)
    }

    /// Returns whether the switch is always on.
    pub fn is_always_on(&self) -> bool {
        self.constant() == Some(true)
    }
}

impl TryFrom<Vec<SwitchKey>> for Switch {
    type Error = MotionError;

    fn try_from(keys: Vec<SwitchKey>) -> Result<Self, MotionError> {
        Self::new(keys)
    }
}

/// The switch that never changes.
impl From<bool> for Switch {
    fn from(value: bool) -> Self {
        Self(vec![SwitchKey { time: 0.0, value }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn switch(keys: &[(f64, bool)]) -> Switch {
        Switch::new(keys.iter().map(|&(time, value)| SwitchKey { time, value }).collect()).unwrap()
    }

    #[test]
    fn a_value_holds_from_its_keyframe_until_the_next_one() {
        let values =
            |keys: &[(f64, bool)]| [-1.0, 0.0, 0.5, 1.0, 2.0, 9.0].map(|time| switch(keys).value(time));
        assert_eq!(
            values(&[(0.0, false), (1.0, true), (2.0, false)]),
            [false, false, false, true, false, false]
        );
        // The products of steps and their length are below the quotients of frames and their rate.
        for frame in 1..2000 {
            let key = f64::from(frame) / 60.0;
            assert!(switch(&[(key, true)]).value(f64::from(frame) * (1.0 / 60.0)), "{frame}");
            assert!(!switch(&[(key, true)]).value((f64::from(frame) - 0.01) / 60.0), "{frame}");
        }
        // A first keyframe after the time 0 switches.
        assert_eq!(values(&[(1.0, false)]), [true, true, true, false, false, false]);
        assert_eq!(values(&[(0.5, true), (2.0, false)]), [false, false, true, true, false, false]);
        assert_eq!(values(&[(-0.5, true), (1.0, false)]), [true, true, true, false, false, false]);
    }

    #[test]
    fn only_a_switch_that_never_changes_is_constant() {
        assert_eq!([true, false].map(|value| Switch::from(value).constant()), [Some(true), Some(false)]);
        assert_eq!(switch(&[(0.0, true), (1.0, true)]).constant(), Some(true));
        assert_eq!(switch(&[(1.0, true)]).constant(), None);
        assert!(!switch(&[(0.0, true), (1.0, false)]).is_always_on());
    }

    #[test]
    fn keyframes_out_of_order_and_infinite_times_are_errors() {
        let keys = |pairs: [(f64, bool); 2]| {
            Switch::new(pairs.map(|(time, value)| SwitchKey { time, value }).into())
        };
        assert_eq!(Switch::new(Vec::new()), Err(MotionError::NoKeys));
        let order = MotionError::NotIncreasing { key: 1, time: 1.0, previous: 1.0 };
        assert_eq!(keys([(1.0, false), (1.0, true)]), Err(order));
        let infinite = MotionError::NotFinite { key: 1, name: "time", value: f64::INFINITY };
        assert_eq!(keys([(0.0, true), (f64::INFINITY, true)]), Err(infinite));
    }
}
