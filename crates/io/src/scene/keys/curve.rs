//! Keyed numbers: a number, a list of keyframes, or a table of keyframes and their interpolation.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::interpolation;
use super::ranges::{finite, inflation};
use supple::{Curve, CurveKey, Interpolation, Range};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RatioKey {
    #[serde(deserialize_with = "finite")]
    time: f64,
    #[serde(deserialize_with = "inflation")]
    value: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RatioKeys {
    keys: Vec<RatioKey>,
    #[serde(default, with = "interpolation")]
    interpolation: Interpolation,
}

impl RatioKeys {
    fn curve<E: Error>(self) -> Result<Curve, E> {
        let keys = self.keys.into_iter().map(|RatioKey { time, value }| CurveKey { time, value });
        let curve = Curve::new(keys.collect())
            .map_err(|error| E::custom(format_args!("a list of keyframes in the order of time: {error}")))?;
        Ok(curve.interpolated(self.interpolation))
    }
}

/// A ratio of rest volumes.
pub(in crate::scene) mod inflate {
    use super::*;

    pub(in crate::scene) fn serialize<S: Serializer>(
        curve: &Curve,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let keys = || curve.keys().iter().map(|&CurveKey { time, value }| RatioKey { time, value });
        match (curve.keys(), curve.interpolation()) {
            (&[CurveKey { value, .. }], _) => serializer.serialize_f64(value),
            (_, Interpolation::Linear) => serializer.collect_seq(keys()),
            (_, interpolation) => RatioKeys { keys: keys().collect(), interpolation }.serialize(serializer),
        }
    }

    pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Curve, D::Error> {
        value.deserialize_any(Ratio)
    }

    struct Ratio;

    impl<'de> Visitor<'de> for Ratio {
        type Value = Curve;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a number, a list of keyframes with `time` and `value`, or a table with `keys` and `interpolation`")
        }

        fn visit_i64<E: Error>(self, ratio: i64) -> Result<Curve, E> {
            self.visit_f64(ratio as f64)
        }

        fn visit_f64<E: Error>(self, ratio: f64) -> Result<Curve, E> {
            match Range::INFLATION.contains(ratio) {
                true => Ok(ratio.into()),
                false => Err(E::custom(Range::INFLATION.text())),
            }
        }

        fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Curve, A::Error> {
            let keys = Vec::deserialize(SeqAccessDeserializer::new(list))?;
            RatioKeys { keys, interpolation: Interpolation::Linear }.curve()
        }

        fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Curve, A::Error> {
            RatioKeys::deserialize(MapAccessDeserializer::new(table))?.curve()
        }
    }
}

optional! {
    optional_inflate: Curve by "inflate";
}
