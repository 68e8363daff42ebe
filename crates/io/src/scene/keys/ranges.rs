//! Functions that deserialize a number, vector or string and check its range.

use std::path::PathBuf;

use serde::Deserialize;
use serde::de::{Deserializer, Error};

use crate::scene::name::is_name;

/// Defines functions that deserialize a number, vector or string and check its range.
macro_rules! ranges {
    ($($name:ident($of:ty, $value:ident): $is_valid:expr, $range:expr;)*) => {$(
        pub(in crate::scene) fn $name<'de, D: Deserializer<'de>, T: From<$of>>(value: D) -> Result<T, D::Error> {
            let $value = <$of>::deserialize(value)?;
            if $is_valid { Ok($value.into()) } else { Err(D::Error::custom($range)) }
        }
    )*};
}

ranges! {
    finite(f64, x): x.is_finite(), "a finite number";
    positive(f64, x): x.is_finite() && x > 0.0, "a number above 0";
    not_negative(f64, x): x.is_finite() && x >= 0.0, "a number of at least 0";
    positive_fraction(f64, x): x > 0.0 && x <= 1.0, "in (0, 1]";
    stiffness_factor(f64, x): x > 0.0 && x <= 100.0, "in (0, 100]";
    plastic_limit(f64, x): x > 0.0 && x <= 2.0, "in (0, 2]";
    break_angle(f64, x): x > 0.0 && x <= 180.0, "in (0, 180]";
    half_width(f64, w): w == 0.5 || (w.fract() == 0.0 && (1.0..=1e6).contains(&w)),
        "0.5 or a whole number from 1 to 1000000";
    ratio(f64, x): (0.0..=0.47).contains(&x), "in [0, 0.47]";
    noise(f64, x): (0.0..=0.5).contains(&x), "in [0, 0.5]";
    fraction(f64, x): (0.0..=1.0).contains(&x), "in [0, 1]";
    direction([f64; 3], v): v != [0.0; 3], "a vector that is not zero";
    extents([f64; 3], v): v.iter().all(|&half| half > 0.0), "three numbers above 0";
    name(String, name): is_name(&name),
        "made of letters, digits, `-`, `_` and `.` only, without a leading `.`, and of at most 200 bytes, because \
         it names files";
    mesh(PathBuf, path): !path.as_os_str().is_empty(), "the path of an OBJ file";
    pc2(PathBuf, path): !path.as_os_str().is_empty(), "the path of a PC2 file";
    directory(PathBuf, path): !path.as_os_str().is_empty(), "a directory; \".\" is that of the scene file";
}

/// Deserializes an optional number above 0.
pub(in crate::scene) fn optional_positive<'de, D: Deserializer<'de>>(
    value: D,
) -> Result<Option<f64>, D::Error> {
    positive(value).map(Some)
}

/// Deserializes Poisson's ratio.
pub(in crate::scene) fn poisson_ratio<'de, D: Deserializer<'de>>(value: D) -> Result<Option<f64>, D::Error> {
    ratio(value).map(Some)
}

/// Deserializes an optional number of at least 0.
pub(in crate::scene) fn optional_not_negative<'de, D: Deserializer<'de>>(
    value: D,
) -> Result<Option<f64>, D::Error> {
    not_negative(value).map(Some)
}

/// Deserializes an optional finite number.
pub(in crate::scene) fn optional_finite<'de, D: Deserializer<'de>>(
    value: D,
) -> Result<Option<f64>, D::Error> {
    finite(value).map(Some)
}

/// Deserializes the optional path of a PC2 file.
pub(in crate::scene) fn point_cache<'de, D: Deserializer<'de>>(
    value: D,
) -> Result<Option<PathBuf>, D::Error> {
    pc2(value).map(Some)
}

/// Deserializes a whole number in the range from `LOW` to `HIGH`.
pub(in crate::scene) fn count<'de, D, T, const LOW: u32, const HIGH: u32>(value: D) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: TryFrom<u32>,
{
    let number = f64::deserialize(value)?;
    let is_valid = number.fract() == 0.0 && (f64::from(LOW)..=f64::from(HIGH)).contains(&number);
    let count = is_valid.then(|| T::try_from(number as u32).ok()).flatten();
    count.ok_or_else(|| D::Error::custom(format_args!("a whole number from {LOW} to {HIGH}")))
}
