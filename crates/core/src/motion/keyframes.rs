//! Defines the keyframed rigid motion of handles and colliders.

use nalgebra::{Matrix3, Point3, Vector3};
use thiserror::Error;

use super::angles::euler_degrees;
use super::interpolation::{self, Interpolation};

/// A keyframe of a motion: a pose at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Key {
    /// Time in seconds from the start of the simulation. The times of consecutive keyframes must increase.
    pub time: f64,
    /// Displacement in scene units. Default 0.
    pub translate: [f64; 3],
    /// Euler angles in degrees about the fixed axes x, then y, then z. Default 0.
    pub rotate: [f64; 3],
}

/// A rigid motion along keyframes. It is linear in time between two keyframes unless it has another
/// [`Interpolation`], and constant before the first and after the last keyframe.
///
/// The Euler angles are interpolated, not the rotations. So the motion from 0 to 720 degrees is two full
/// turns.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Motion {
    keys: Vec<Key>,
    interpolation: Interpolation,
}

/// Displacement and Euler angles relative to a given pose: a keyframe without its time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct EulerPose {
    /// Displacement in scene units.
    pub(crate) translate: [f64; 3],
    /// Euler angles in degrees about the fixed axes x, then y, then z.
    pub(crate) rotate: [f64; 3],
}

/// A pose of a motion. It moves a point `p` to `center + rotation * (p - center) + translate`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation about the center.
    pub rotation: Matrix3<f64>,
    /// Displacement in scene units.
    pub translate: Vector3<f64>,
}

/// The error that the keyframes of a motion are invalid.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum MotionError {
    /// The list of keyframes is empty.
    #[error("there are no keys; give at least one, {{ time = 0 }}")]
    NoKeys,
    /// A value of a keyframe is NaN or infinite.
    #[error("key {key}: {name} is {value}; it must be finite")]
    NotFinite {
        /// Index of the keyframe, from 0.
        key: usize,
        /// `time`, `translate` or `rotate`.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// A displacement is so large that the positions of neighboring vertices would round to the same number.
    #[error("key {key}: translate is {value:e}, too far: the limit is {limit:.3e}, 10^15 cells")]
    TooFar {
        /// Index of the keyframe, from 0.
        key: usize,
        /// The coordinate.
        value: f64,
        /// Largest valid magnitude.
        limit: f64,
    },
    /// The time of a keyframe is not greater than the time of the previous keyframe.
    #[error("key {key} is at time {time}, which is not after key {} at {previous}; sort the keys by time", key - 1)]
    NotIncreasing {
        /// Index of the keyframe, from 0.
        key: usize,
        /// Time of the keyframe in seconds.
        time: f64,
        /// Time of the previous keyframe in seconds.
        previous: f64,
    },
}

impl MotionError {
    /// Checks that there are keyframes, that all their numbers are finite, and that each time is after the one before.
    /// `values`: returns the numbers of a keyframe beside its time, with their names.
    pub(super) fn check<K, V: IntoIterator<Item = (&'static str, f64)>>(
        keys: &[K],
        time: impl Fn(&K) -> f64,
        values: impl Fn(&K) -> V,
    ) -> Result<(), Self> {
        if keys.is_empty() {
            return Err(Self::NoKeys);
        }
        let mut previous = f64::NEG_INFINITY;
        for (index, key) in keys.iter().enumerate() {
            for (name, value) in std::iter::once(("time", time(key))).chain(values(key)) {
                if !value.is_finite() {
                    return Err(Self::NotFinite { key: index, name, value });
                }
            }
            if time(key) <= previous {
                return Err(Self::NotIncreasing { key: index, time: time(key), previous });
            }
            previous = time(key);
        }
        Ok(())
    }
}

impl Motion {
    /// Creates the motion along the keyframes `keys`, in strictly increasing order of time.
    ///
    /// # Errors
    /// If the list is empty, a value is not finite, or the times do not increase.
    pub fn new(keys: Vec<Key>) -> Result<Self, MotionError> {
        let named = |name, vector: [f64; 3]| vector.map(|value| (name, value));
        let values = |key: &Key| [named("translate", key.translate), named("rotate", key.rotate)];
        MotionError::check(&keys, |key| key.time, |key| values(key).into_iter().flatten())?;
        Ok(Self { keys, interpolation: Interpolation::Linear })
    }

    /// Returns the motion with another interpolation between the keyframes.
    pub fn interpolated(self, interpolation: Interpolation) -> Self {
        Self { interpolation, ..self }
    }

    /// Returns the interpolation between the keyframes.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Checks that the components of each displacement have a magnitude of at most `limit`.
    pub(crate) fn check_limit(&self, limit: f64) -> Result<(), MotionError> {
        for (key, Key { translate, .. }) in self.keys.iter().enumerate() {
            if let Some(&value) = translate.iter().find(|x| x.abs() > limit) {
                return Err(MotionError::TooFar { key, value, limit });
            }
        }
        Ok(())
    }

    /// Returns the keyframes, in order of time.
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// Returns the pose at `time`, in seconds.
    pub fn pose(&self, time: f64) -> Pose {
        self.euler_pose(time).pose()
    }

    /// Returns the displacement and the interpolated Euler angles at `time`, in seconds.
    pub(crate) fn euler_pose(&self, time: f64) -> EulerPose {
        let at = (time, self.interpolation);
        let value = |of: fn(&Key) -> &[f64; 3]| {
            std::array::from_fn(|c| interpolation::value_at(&self.keys, at, |key| key.time, |key| of(key)[c]))
        };
        EulerPose { translate: value(|key| &key.translate), rotate: value(|key| &key.rotate) }
    }

    /// Returns the greatest speed, in scene units per second, of a point at the distance `radius` from the center of
    /// rotation; to about 1 % between cubic keyframes.
    pub(crate) fn greatest_speed(&self, radius: f64) -> f64 {
        let speed = |a: &EulerPose, b: &EulerPose, seconds: f64| {
            let translation = Vector3::from(b.translate) - Vector3::from(a.translate);
            let degrees = Vector3::from(b.rotate) - Vector3::from(a.rotate);
            (translation.norm() + degrees.norm().to_radians() * radius) / seconds
        };
        let greatest = |next: usize| {
            let (a, b) = (&self.keys[next - 1], &self.keys[next]);
            let length = b.time - a.time;
            match self.interpolation {
                Interpolation::Linear => speed(&a.pose(), &b.pose(), length),
                // The slope of 3 s² - 2 s³ is at most 3/2.
                Interpolation::Smooth => 1.5 * speed(&a.pose(), &b.pose(), length),
                Interpolation::Cubic => (0..16).fold(0.0, |greatest: f64, part| {
                    let [from, to] = [part, part + 1]
                        .map(|part| self.euler_pose(a.time + length * f64::from(part) / 16.0));
                    greatest.max(speed(&from, &to, length / 16.0))
                }),
            }
        };
        (1..self.keys.len()).map(greatest).fold(0.0, f64::max)
    }
}

impl Key {
    /// Returns the keyframe without its time.
    fn pose(&self) -> EulerPose {
        EulerPose { translate: self.translate, rotate: self.rotate }
    }
}

impl EulerPose {
    /// Returns the displacement and the rotation matrix.
    pub(crate) fn pose(&self) -> Pose {
        Pose { rotation: euler_degrees(self.rotate), translate: Vector3::from(self.translate) }
    }

    /// Interpolates displacement and angles linearly, from this pose at s = 0 to `other` at s = 1.
    pub(super) fn lerp(&self, other: &Self, s: f64) -> Self {
        Self {
            translate: lerp(self.translate, other.translate, s),
            rotate: lerp(self.rotate, other.rotate, s),
        }
    }
}

impl Pose {
    /// Returns the pose without displacement and rotation.
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translate: Vector3::zeros() }
    }

    /// Returns the position to which this pose moves `point`. The rotation is about `center`.
    #[inline]
    pub fn apply(&self, center: &Point3<f64>, point: &Point3<f64>) -> Point3<f64> {
        center + self.rotation * (point - center) + self.translate
    }
}

/// Interpolates linearly from `a` at s = 0 to `b` at s = 1.
fn lerp(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + s * (b[i] - a[i]))
}
