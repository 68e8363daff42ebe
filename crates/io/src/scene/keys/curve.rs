//! Keyed numbers and vectors: a value, a list of keyframes, or a table of keyframes and their interpolation.

use std::fmt;

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::interpolation;
use super::ranges::{
    self, finite, inflation, not_negative, positive_fraction, time_scale as time_scale_value,
};
use supple::{Curve, CurveKey, Interpolation, KeyedMaterial, Range};

/// Defines in a module the keyframes of a value, and `serialize`. `$read` reads the value of a keyframe.
macro_rules! keyframes {
    ($value:ty, $read:literal) => {
        #[derive(Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        struct ValueKey {
            #[serde(deserialize_with = "finite")]
            time: f64,
            #[serde(deserialize_with = $read)]
            value: $value,
        }

        #[derive(Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        struct ValueKeys {
            keys: Vec<ValueKey>,
            #[serde(default, with = "interpolation")]
            interpolation: Interpolation,
        }

        impl ValueKeys {
            fn curve<E: Error>(self) -> Result<Curve<$value>, E> {
                let keys = self.keys.into_iter().map(|ValueKey { time, value }| CurveKey { time, value });
                let curve = Curve::new(keys.collect()).map_err(|error| {
                    E::custom(format_args!("a list of keyframes in the order of time: {error}"))
                })?;
                Ok(curve.interpolated(self.interpolation))
            }
        }

        pub(in crate::scene) fn serialize<S: Serializer>(
            curve: &Curve<$value>,
            serializer: S,
        ) -> Result<S::Ok, S::Error> {
            let keys = || curve.keys().iter().map(|&CurveKey { time, value }| ValueKey { time, value });
            match (curve.keys(), curve.interpolation()) {
                (&[CurveKey { value, .. }], _) => value.serialize(serializer),
                (_, Interpolation::Linear) => serializer.collect_seq(keys()),
                (_, interpolation) => {
                    ValueKeys { keys: keys().collect(), interpolation }.serialize(serializer)
                }
            }
        }
    };
}

/// Defines modules that read and write keyed numbers of a range. `$read` reads a number of a keyframe.
macro_rules! curves {
    ($($module:ident: $range:ident by $read:literal;)*) => {$(
        pub(in crate::scene) mod $module {
            use super::*;

            keyframes! { f64, $read }

            pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Curve, D::Error> {
                value.deserialize_any(Number)
            }

            struct Number;

            impl<'de> Visitor<'de> for Number {
                type Value = Curve;

                fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    f.write_str(EXPECTED)
                }

                fn visit_i64<E: Error>(self, number: i64) -> Result<Curve, E> {
                    self.visit_f64(number as f64)
                }

                fn visit_f64<E: Error>(self, number: f64) -> Result<Curve, E> {
                    match Range::$range.contains(number) {
                        true => Ok(number.into()),
                        false => Err(E::custom(Range::$range.text())),
                    }
                }

                fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Curve, A::Error> {
                    let keys = Vec::deserialize(SeqAccessDeserializer::new(list))?;
                    ValueKeys { keys, interpolation: Interpolation::Linear }.curve()
                }

                fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Curve, A::Error> {
                    ValueKeys::deserialize(MapAccessDeserializer::new(table))?.curve()
                }
            }
        }
    )*};
}

const EXPECTED: &str =
    "a number, a list of keyframes with `time` and `value`, or a table with `keys` and `interpolation`";

/// A keyed vector: three numbers, keyframes of them, or a table of keyframes and their interpolation.
pub(in crate::scene) mod vector {
    use super::*;

    keyframes! { [f64; 3], "read" }

    fn read<'de, D: Deserializer<'de>>(value: D) -> Result<[f64; 3], D::Error> {
        <[f64; 3]>::deserialize(value)
    }

    pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(
        value: D,
    ) -> Result<Curve<[f64; 3]>, D::Error> {
        value.deserialize_any(Vector)
    }

    struct Vector;

    impl<'de> Visitor<'de> for Vector {
        type Value = Curve<[f64; 3]>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a list of three numbers, or keyframes with `time` and `value`")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
            let (mut numbers, mut keys) = (Vec::new(), Vec::new());
            while let Some(item) = list.next_element()? {
                match item {
                    Item::Number(number) => numbers.push(number),
                    Item::Key(key) => keys.push(key),
                }
            }
            match <[f64; 3]>::try_from(numbers) {
                Ok(vector) if keys.is_empty() => Ok(vector.into()),
                Err(numbers) if numbers.is_empty() && !keys.is_empty() => {
                    ValueKeys { keys, interpolation: Interpolation::Linear }.curve()
                }
                _ => Err(A::Error::invalid_type(Unexpected::Seq, &self)),
            }
        }

        fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Self::Value, A::Error> {
            ValueKeys::deserialize(MapAccessDeserializer::new(table))?.curve()
        }
    }

    /// An item of a list: a number of a vector, or a keyframe.
    enum Item {
        Number(f64),
        Key(ValueKey),
    }

    impl<'de> Deserialize<'de> for Item {
        fn deserialize<D: Deserializer<'de>>(value: D) -> Result<Self, D::Error> {
            struct Read;

            impl<'de> Visitor<'de> for Read {
                type Value = Item;

                fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    f.write_str("a number, or a keyframe with `time` and `value`")
                }

                fn visit_i64<E: Error>(self, number: i64) -> Result<Item, E> {
                    self.visit_f64(number as f64)
                }

                fn visit_f64<E: Error>(self, number: f64) -> Result<Item, E> {
                    match number.is_finite() {
                        true => Ok(Item::Number(number)),
                        false => Err(E::custom("a finite number")),
                    }
                }

                fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Item, A::Error> {
                    ValueKey::deserialize(MapAccessDeserializer::new(table)).map(Item::Key)
                }
            }
            value.deserialize_any(Read)
        }
    }
}

curves! {
    inflate: INFLATION by "inflation";
    strength: NOT_NEGATIVE by "not_negative";
    weight: POSITIVE_FRACTION by "positive_fraction";
    time_scale: TIME_SCALE by "time_scale_value";
    youngs_modulus: YOUNGS_MODULUS by "ranges::youngs_modulus";
    poisson_ratio: POISSON_RATIO by "ranges::poisson_ratio";
    damping_ratio: FRACTION by "ranges::fraction";
    friction: NOT_NEGATIVE by "not_negative";
}

/// Defines for each number of a material a module that reads and writes its keyframes, if they differ, and a function that
/// reads the greatest value.
macro_rules! changing {
    ($($module:ident, $greatest:ident by $keys:ident;)*) => {$(
        pub(in crate::scene) fn $greatest<'de, D: Deserializer<'de>, T: From<f64>>(value: D) -> Result<T, D::Error> {
            $keys::deserialize(value).map(|curve| curve.greatest().into())
        }

        mod $module {
            use super::*;

            pub(super) fn serialize<S: Serializer>(curve: &Option<Curve>, serializer: S) -> Result<S::Ok, S::Error> {
                match curve {
                    Some(curve) => $keys::serialize(curve, serializer),
                    None => serializer.serialize_none(),
                }
            }

            pub(super) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Curve>, D::Error> {
                $keys::deserialize(value).map(|curve| Some(curve).filter(|curve| curve.constant().is_none()))
            }
        }
    )*};
}

changing! {
    changing_modulus, greatest_modulus by youngs_modulus;
    changing_poisson_ratio, greatest_poisson_ratio by poisson_ratio;
    changing_damping_ratio, greatest_damping_ratio by damping_ratio;
    changing_friction, greatest_friction by friction;
}

/// The keyframes of the keys of a material whose greatest values `MaterialKeys` and `TouchingKeys` read.
#[derive(Serialize, Deserialize)]
#[serde(remote = "KeyedMaterial", default, bound = "")]
pub(in crate::scene) struct KeyedKeys {
    #[serde(with = "changing_modulus", skip_serializing_if = "Option::is_none")]
    youngs_modulus: Option<Curve>,
    #[serde(with = "changing_poisson_ratio", skip_serializing_if = "Option::is_none")]
    poisson_ratio: Option<Curve>,
    #[serde(with = "changing_damping_ratio", skip_serializing_if = "Option::is_none")]
    damping_ratio: Option<Curve>,
    #[serde(with = "changing_friction", skip_serializing_if = "Option::is_none")]
    friction: Option<Curve>,
}

optional! {
    optional_inflate: Curve by "inflate";
}
