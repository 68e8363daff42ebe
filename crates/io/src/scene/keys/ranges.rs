//! Functions that deserialize a number, vector or string and check its range. The ranges of numbers are those of
//! [`supple::Range`].

use std::path::PathBuf;

use serde::Deserialize;
use serde::de::{Deserializer, Error, Unexpected};
use supple::Range;

use crate::film::SIDES;
use crate::scene::name::is_name;

/// Defines functions that deserialize a number, or an optional number that is given, and check its range.
macro_rules! numbers {
    ($($name:ident: $range:ident;)*) => {$(
        pub(in crate::scene) fn $name<'de, D: Deserializer<'de>, T: From<f64>>(value: D) -> Result<T, D::Error> {
            let number = f64::deserialize(value)?;
            match Range::$range.contains(number) {
                true => Ok(number.into()),
                false => Err(D::Error::custom(Range::$range.text())),
            }
        }
    )*};
}

numbers! {
    finite: FINITE;
    positive: POSITIVE;
    not_negative: NOT_NEGATIVE;
    fraction: FRACTION;
    positive_fraction: POSITIVE_FRACTION;
    length: LENGTH;
    youngs_modulus: YOUNGS_MODULUS;
    poisson_ratio: POISSON_RATIO;
    half_width: HALF_WIDTH;
    frequency: FREQUENCY;
    fps: FPS;
    rate: RATE;
    creep: CREEP;
    plastic_strain: PLASTIC_STRAIN;
    stiffness_factor: STIFFNESS_FACTOR;
    inflation: INFLATION;
    break_angle: BREAK_ANGLE;
    noise: NOISE;
    time_scale: TIME_SCALE;
    preroll: PREROLL;
}

/// Defines functions that deserialize a vector or string and check it.
macro_rules! ranges {
    ($($name:ident($of:ty, $value:ident): $is_valid:expr, $range:expr;)*) => {$(
        pub(in crate::scene) fn $name<'de, D: Deserializer<'de>, T: From<$of>>(value: D) -> Result<T, D::Error> {
            let $value = <$of>::deserialize(value)?;
            if $is_valid { Ok($value.into()) } else { Err(D::Error::custom($range)) }
        }
    )*};
}

ranges! {
    direction([f64; 3], v): v != [0.0; 3], "a vector that is not zero";
    view([f64; 3], v): v.iter().all(|number| number.is_finite()) && v != [0.0; 3],
        "three finite numbers that are not all 0";
    extents([f64; 3], v): v.iter().all(|&half| Range::POSITIVE.contains(half)), "three numbers above 0";
    name(String, name): is_name(&name),
        "made of letters, digits, `-`, `_` and `.` only, without a leading `.`, and of at most 200 bytes, because \
         it names files";
    mesh(PathBuf, path): !path.as_os_str().is_empty(), "the path of a model: OBJ, GLB, glTF, STL or PLY";
    point_cache(PathBuf, path): !path.as_os_str().is_empty(), "the path of a PC2 file";
    directory(PathBuf, path): !path.as_os_str().is_empty(), "a directory; \".\" is that of the scene file";
}

/// Deserializes a whole number in the range from `LOW` to `HIGH`.
pub(in crate::scene) fn count<'de, D, T, const LOW: u32, const HIGH: u32>(value: D) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: TryFrom<u32>,
{
    let number = f64::deserialize(value)?;
    if number.is_finite() && number.fract() != 0.0 {
        return Err(D::Error::invalid_type(Unexpected::Float(number), &"a whole number"));
    }
    let is_valid = (f64::from(LOW)..=f64::from(HIGH)).contains(&number);
    let count = is_valid.then(|| T::try_from(number as u32).ok()).flatten();
    count.ok_or_else(|| D::Error::custom(format_args!("a whole number from {LOW} to {HIGH}")))
}

/// Deserializes an interval in frames that is given.
pub(in crate::scene) fn interval<'de, D: Deserializer<'de>>(value: D) -> Result<Option<u32>, D::Error> {
    count::<_, _, 1, 10_000_000>(value).map(Some)
}

/// Deserializes the width and the height of a film.
pub(in crate::scene) fn film_size<'de, D: Deserializer<'de>>(value: D) -> Result<[u32; 2], D::Error> {
    let [low, high] = SIDES;
    let size = <[f64; 2]>::deserialize(value)?;
    let is_valid = |side: &f64| side.fract() == 0.0 && (f64::from(low)..=f64::from(high)).contains(side);
    match size.iter().all(is_valid) {
        true => Ok(size.map(|side| side as u32)),
        false => Err(D::Error::custom(format_args!(
            "width and height in pixels, whole numbers from {low} to {high}"
        ))),
    }
}
