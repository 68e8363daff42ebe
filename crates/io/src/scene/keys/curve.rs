//! Keyed numbers: a number, a list of keyframes, or a table of keyframes and their interpolation.

use serde::de::{Deserializer, Error};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use toml::Value;

use super::interpolation;
use supple::{Curve, CurveKey, Interpolation};

/// What a ratio of rest volumes may be.
const RATIO: &str = "a number in [0.1, 10], keyframes like [{ time = 0, value = 1 }, { time = 2, value = 1.3 }], or a \
                     table like { keys = [...], interpolation = \"smooth\" }";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyItem {
    time: f64,
    value: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyTable {
    keys: Vec<KeyItem>,
    #[serde(default, with = "interpolation")]
    interpolation: Interpolation,
}

fn serialize_curve<S: Serializer>(curve: &Curve, serializer: S) -> Result<S::Ok, S::Error> {
    let keys = || curve.keys().iter().map(|&CurveKey { time, value }| KeyItem { time, value });
    match (curve.keys(), curve.interpolation()) {
        (&[CurveKey { value, .. }], _) => serializer.serialize_f64(value),
        (_, Interpolation::Linear) => serializer.collect_seq(keys()),
        (_, interpolation) => KeyTable { keys: keys().collect(), interpolation }.serialize(serializer),
    }
}

/// Reads a ratio of rest volumes.
fn deserialize_ratio<'de, D: Deserializer<'de>>(value: D) -> Result<Curve, D::Error> {
    let invalid = |fault: &str| D::Error::custom(format_args!("{RATIO}{fault}"));
    let (keys, interpolation) = match Value::deserialize(value)? {
        Value::Integer(number) => return in_range(Curve::from(number as f64)).ok_or_else(|| invalid("")),
        Value::Float(number) => return in_range(Curve::from(number)).ok_or_else(|| invalid("")),
        keys @ Value::Array(_) => (keys.try_into(), Interpolation::Linear),
        table => match table.try_into::<KeyTable>() {
            Ok(KeyTable { keys, interpolation }) => (Ok(keys), interpolation),
            Err(error) => (Err(error), Interpolation::Linear),
        },
    };
    let keys: Vec<KeyItem> =
        keys.map_err(|error: toml::de::Error| invalid(&format!(" ({})", error.message().trim_end())))?;
    let keys = keys.into_iter().map(|KeyItem { time, value }| CurveKey { time, value }).collect();
    let curve = Curve::new(keys).map_err(|error| invalid(&format!(" ({error})")))?;
    in_range(curve.interpolated(interpolation)).ok_or_else(|| invalid(""))
}

/// Returns a curve if all its values are ratios of rest volumes.
fn in_range(curve: Curve) -> Option<Curve> {
    curve.keys().iter().all(|key| (0.1..=10.0).contains(&key.value)).then_some(curve)
}

/// A ratio of rest volumes.
pub(in crate::scene) mod inflate {
    use super::*;

    pub(in crate::scene) fn serialize<S: Serializer>(
        curve: &Curve,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serialize_curve(curve, serializer)
    }

    pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Curve, D::Error> {
        deserialize_ratio(value)
    }
}

/// An optional ratio of rest volumes.
pub(in crate::scene) mod optional_inflate {
    use super::*;

    #[derive(Serialize)]
    struct Item<'a>(#[serde(serialize_with = "serialize_curve_of")] &'a Curve);

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
    fn serialize_curve_of<S: Serializer>(curve: &&Curve, serializer: S) -> Result<S::Ok, S::Error> {
        serialize_curve(curve, serializer)
    }

    pub(in crate::scene) fn serialize<S: Serializer>(
        curve: &Option<Curve>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        curve.as_ref().map(Item).serialize(serializer)
    }

    pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(
        value: D,
    ) -> Result<Option<Curve>, D::Error> {
        deserialize_ratio(value).map(Some)
    }
}
