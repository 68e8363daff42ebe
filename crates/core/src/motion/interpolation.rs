//! Interpolates keyframes: linear, with rests at the keyframes, or cubic through them.

/// The interpolation between two keyframes. Before the first and after the last keyframe it always rests.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Interpolation {
    /// With constant velocity, which jumps at the keyframes. The default.
    #[default]
    Linear,
    /// From rest to rest: the velocity is zero at each keyframe. The share s of the displacement is 3 s² - 2 s³.
    Smooth,
    /// Through the keyframes with a continuous velocity. A coordinate rests at the first and the last keyframe, and
    /// where it turns back or did not change; it stays between its values at the two keyframes.
    Cubic,
}

impl Interpolation {
    /// All values, with their names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 3] =
        [("linear", Self::Linear), ("smooth", Self::Smooth), ("cubic", Self::Cubic)];

    /// Returns the name of the value in [`Interpolation::NAMED`].
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
    }

    /// Returns whether this is the default.
    pub fn is_linear(&self) -> bool {
        *self == Self::Linear
    }
}

/// Returns the value of a coordinate at `time`, where `keys` are keyframes in order of time. Before the first and
/// after the last keyframe it is constant; without keyframes it is 0.
pub(super) fn value_at<K>(
    keys: &[K],
    (time, interpolation): (f64, Interpolation),
    time_of: impl Fn(&K) -> f64,
    value_of: impl Fn(&K) -> f64,
) -> f64 {
    let after = keys.partition_point(|key| time_of(key) <= time);
    match (after.checked_sub(1).map(|k| &keys[k]), keys.get(after)) {
        (Some(previous), Some(next)) => {
            let length = time_of(next) - time_of(previous);
            let s = (time - time_of(previous)) / length;
            let [a, b] = [previous, next].map(&value_of);
            let value = match interpolation {
                Interpolation::Linear => a + s * (b - a),
                Interpolation::Smooth => a + smooth(s) * (b - a),
                Interpolation::Cubic => {
                    let slopes =
                        [after - 1, after].map(|key| length * slope_at(keys, key, &time_of, &value_of));
                    hermite(a, b, slopes, s)
                }
            };
            // Rounding errors could lie outside.
            value.clamp(a.min(b), a.max(b))
        }
        (Some(only), None) | (None, Some(only)) => value_of(only),
        (None, None) => 0.0,
    }
}

/// Returns the slope of the cubics of a coordinate at a keyframe, per second. The motion begins and ends at rest.
fn slope_at<K>(keys: &[K], key: usize, time_of: impl Fn(&K) -> f64, value_of: impl Fn(&K) -> f64) -> f64 {
    let (Some(before), Some(after)) = (key.checked_sub(1), keys.get(key + 1)) else { return 0.0 };
    let (before, at) = (&keys[before], &keys[key]);
    slope(
        [value_of(at) - value_of(before), value_of(after) - value_of(at)],
        [time_of(at) - time_of(before), time_of(after) - time_of(at)],
    )
}

/// Returns the share of the displacement from rest to rest: the cubic with slope zero at s = 0 and s = 1.
fn smooth(s: f64) -> f64 {
    s * s * (3.0 - 2.0 * s)
}

/// Returns the cubic Hermite polynomial from `a` at s = 0 to `b` at s = 1, with the slopes `[start, end]` in units of
/// s.
fn hermite(a: f64, b: f64, [start, end]: [f64; 2], s: f64) -> f64 {
    let rest = 1.0 - s;
    a + (b - a) * smooth(s) + s * rest * (rest * start - s * end)
}

/// Returns the slope at a keyframe between two intervals of the lengths `lengths`, in which a value changes by
/// `changes`: a weighted harmonic mean of the slopes of the two (Fritsch & Butland 1984, SIAM J. Sci. Stat. Comput. 5,
/// 300), zero if they differ in sign. With it the Hermite cubics of both intervals are monotone.
fn slope(changes: [f64; 2], lengths: [f64; 2]) -> f64 {
    let [before, after] = [changes[0] / lengths[0], changes[1] / lengths[1]];
    if before * after <= 0.0 {
        return 0.0;
    }
    let weights = [2.0 * lengths[1] + lengths[0], lengths[1] + 2.0 * lengths[0]];
    (weights[0] + weights[1]) / (weights[0] / before + weights[1] / after)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hermite_cubics_have_the_given_values_and_slopes() {
        let (a, b, slopes) = (-1.0, 2.5, [0.7, -3.0]);
        let cubic = |s| hermite(a, b, slopes, s);
        assert_eq!([cubic(0.0), cubic(1.0)], [a, b]);
        for (s, slope) in [(0.0, slopes[0]), (1.0, slopes[1])] {
            let difference = (cubic(s + 1e-5) - cubic(s - 1e-5)) / 2e-5;
            assert!((difference - slope).abs() < 1e-8, "{difference} {slope}");
        }
        // Without slopes of its own it is the cubic from rest to rest, and exact for a line.
        assert_eq!(hermite(0.0, 1.0, [0.0; 2], 0.3), smooth(0.3));
        assert!((hermite(1.0, 3.0, [2.0; 2], 0.3) - 1.6).abs() < 1e-15);
    }

    #[test]
    fn slopes_are_those_of_lines_and_at_most_three_times_the_lesser_slope() {
        assert!((slope([1.0, 3.0], [0.5, 1.5]) - 2.0).abs() < 1e-15);
        assert_eq!(
            [slope([1.0, -1.0], [1.0; 2]), slope([0.0, 1.0], [1.0; 2]), slope([1.0, 0.0], [1.0; 2])],
            [0.0; 3]
        );
        // A product of two slopes that underflows counts as zero.
        assert_eq!(slope([1e-200, 1e-200], [1.0; 2]), 0.0);
        for lengths in [[1.0, 1.0], [0.01, 5.0], [5.0, 0.01]] {
            for changes in [[1.0, 2.0], [-1.0, -100.0], [1e-3, 40.0]] {
                let found = slope(changes, lengths);
                let least = (changes[0] / lengths[0]).abs().min((changes[1] / lengths[1]).abs());
                assert!(found.abs() <= 3.0 * least && found * changes[0] > 0.0);
                assert_eq!(slope([changes[1], changes[0]], [lengths[1], lengths[0]]), found);
            }
        }
    }
}
