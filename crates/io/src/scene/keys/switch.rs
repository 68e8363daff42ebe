//! Switches: true or false, or a list of keyframes.

use std::fmt;

use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::ranges::finite;
use supple::{Switch, SwitchKey};

/// Keyframe of a switch.
#[derive(Serialize, Deserialize)]
#[serde(remote = "SwitchKey", deny_unknown_fields)]
struct SwitchKeyKeys {
    #[serde(deserialize_with = "finite")]
    time: f64,
    value: bool,
}

/// The same as a value of a list.
#[derive(Serialize, Deserialize)]
struct Item(#[serde(with = "SwitchKeyKeys")] SwitchKey);

/// The key `enabled`, for programs that read it alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnabledTable {
    /// When the collider is enabled.
    #[serde(serialize_with = "serialize", deserialize_with = "deserialize")]
    pub enabled: Switch,
}

pub(in crate::scene) fn serialize<S: Serializer>(switch: &Switch, serializer: S) -> Result<S::Ok, S::Error> {
    match switch.constant() {
        Some(value) => serializer.serialize_bool(value),
        None => serializer.collect_seq(switch.keys().iter().copied().map(Item)),
    }
}

pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Switch, D::Error> {
    value.deserialize_any(Read)
}

struct Read;

impl<'de> Visitor<'de> for Read {
    type Value = Switch;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("true, false, or a list of keyframes with `time` and `value`")
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Switch, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Switch, A::Error> {
        let keys: Vec<Item> = Vec::deserialize(SeqAccessDeserializer::new(list))?;
        Switch::new(keys.into_iter().map(|Item(key)| key).collect()).map_err(|error| {
            A::Error::custom(format_args!("a list of keyframes in the order of time: {error}"))
        })
    }
}
