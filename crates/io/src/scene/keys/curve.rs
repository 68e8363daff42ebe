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

/// A ratio of rest volumes.
pub(in crate::scene) mod inflate {
    use super::*;

    pub(in crate::scene) fn serialize<S: Serializer>(
        curve: &Curve,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let keys = || curve.keys().iter().map(|&CurveKey { time, value }| KeyItem { time, value });
        match (curve.keys(), curve.interpolation()) {
            (&[CurveKey { value, .. }], _) => serializer.serialize_f64(value),
            (_, Interpolation::Linear) => serializer.collect_seq(keys()),
            (_, interpolation) => KeyTable { keys: keys().collect(), interpolation }.serialize(serializer),
        }
    }

    pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Curve, D::Error> {
        let invalid = |fault: &str| D::Error::custom(format_args!("{RATIO}{fault}"));
        let curve = match Value::deserialize(value)? {
            Value::Integer(number) => Curve::from(number as f64),
            Value::Float(number) => Curve::from(number),
            value => {
                let table = match value {
                    Value::Array(_) => {
                        value.try_into().map(|keys| KeyTable { keys, interpolation: Interpolation::Linear })
                    }
                    table => table.try_into(),
                };
                let KeyTable { keys, interpolation } =
                    table.map_err(|error| invalid(&format!(" ({})", error.message().trim_end())))?;
                let keys = keys.into_iter().map(|KeyItem { time, value }| CurveKey { time, value });
                let curve = Curve::new(keys.collect()).map_err(|error| invalid(&format!(" ({error})")))?;
                curve.interpolated(interpolation)
            }
        };
        let is_valid = curve.keys().iter().all(|key| (0.1..=10.0).contains(&key.value));
        if is_valid { Ok(curve) } else { Err(invalid("")) }
    }
}

/// An optional ratio of rest volumes.
pub(in crate::scene) mod optional_inflate {
    use super::*;

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Item(#[serde(with = "inflate")] Curve);

    pub(in crate::scene) fn serialize<S: Serializer>(
        curve: &Option<Curve>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        curve.clone().map(Item).serialize(serializer)
    }

    pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(
        value: D,
    ) -> Result<Option<Curve>, D::Error> {
        Item::deserialize(value).map(|Item(curve)| Some(curve))
    }
}
