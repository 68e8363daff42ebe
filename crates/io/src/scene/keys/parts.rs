//! The keys of pins, handles and zones, and of keyframes.

use serde::de::{Deserializer, Error};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::curve::{optional_inflate, weight};
use super::field_laws::FieldKeys;
use super::link::LinkKeys;
use super::ranges::{finite, fraction, frequency, not_negative, stiffness_factor};
use super::selection::SelectionKeys;
use supple::{Curve, Field, Goal, Key, Link, Pin, Selection, TimeWindow, Zone};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Pin")]
struct PinKeys {
    #[serde(rename = "@selection", with = "SelectionKeys")]
    selection: Selection,
    #[serde(default, rename = "@window", with = "WindowKeys")]
    window: TimeWindow,
    #[serde(default, rename = "@goal", with = "optional_goal", skip_serializing_if = "Option::is_none")]
    goal: Option<Goal>,
}

optional! {
    optional_goal: Goal by "GoalKeys";
}

/// A soft goal, as serde reads and writes the table of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct GoalTable(#[serde(with = "GoalKeys")] pub Goal);

#[derive(Serialize, Deserialize)]
#[serde(remote = "Goal", default, bound = "")]
struct GoalKeys {
    #[serde(with = "weight")]
    weight: Curve,
    #[serde(rename = "goal_frequency", deserialize_with = "frequency")]
    frequency: f64,
    #[serde(rename = "goal_damping", deserialize_with = "fraction")]
    damping_ratio: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Zone")]
struct ZoneKeys {
    #[serde(rename = "@selection", with = "SelectionKeys")]
    selection: Selection,
    /// 0 if it is missing.
    #[serde(default, deserialize_with = "stiffness_factor")]
    factor: f64,
    #[serde(default, with = "optional_inflate", skip_serializing_if = "Option::is_none")]
    inflate: Option<Curve>,
    #[serde(default = "missing", rename = "density_factor", deserialize_with = "stiffness_factor")]
    #[serde(skip_serializing_if = "is_one")]
    density: f64,
    #[serde(default = "missing", rename = "strength_factor", deserialize_with = "stiffness_factor")]
    #[serde(skip_serializing_if = "is_one")]
    strength: f64,
    #[serde(default = "missing", rename = "damping_factor", deserialize_with = "stiffness_factor")]
    #[serde(skip_serializing_if = "is_one")]
    damping: f64,
    #[serde(default = "missing", rename = "friction_factor", deserialize_with = "stiffness_factor")]
    #[serde(skip_serializing_if = "is_one")]
    friction: f64,
    #[serde(default = "missing", rename = "yield_factor", deserialize_with = "stiffness_factor")]
    #[serde(skip_serializing_if = "is_one")]
    yield_strain: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "TimeWindow", default, bound = "")]
pub(in crate::scene) struct WindowKeys {
    #[serde(deserialize_with = "not_negative")]
    start: f64,
    #[serde(deserialize_with = "finite", skip_serializing_if = "is_infinite")]
    end: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Key")]
struct KeyframeKeys {
    #[serde(deserialize_with = "finite")]
    time: f64,
    #[serde(default)]
    translate: [f64; 3],
    #[serde(default)]
    rotate: [f64; 3],
}

/// The number of a key that is missing, until the list of zones is complete.
fn missing() -> f64 {
    f64::NAN
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_one(number: &f64) -> bool {
    *number == 1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_infinite(number: &f64) -> bool {
    number.is_infinite()
}

/// Defines modules that serialize lists of a type through its `...Keys`. `$check` completes a list, and
/// returns an error if it is invalid.
macro_rules! lists {
    ($($module:ident: $of:ident by $keys:literal, $check:expr;)*) => {$(
        pub(in crate::scene) mod $module {
            use super::*;

            #[derive(Serialize, Deserialize)]
            #[serde(transparent)]
            struct Item(#[serde(with = $keys)] $of);

            pub(in crate::scene) fn serialize<S: Serializer>(list: &[$of], serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_seq(list.iter().cloned().map(Item))
            }

            pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Vec<$of>, D::Error> {
                let mut list: Vec<$of> = Vec::deserialize(value)?.into_iter().map(|Item(value)| value).collect();
                let check: fn(&mut [$of]) -> Result<(), &str> = $check;
                check(&mut list).map_err(D::Error::custom)?;
                Ok(list)
            }
        }
    )*};
}

lists! {
    pins: Pin by "PinKeys", |_| Ok(());
    fields: Field by "FieldKeys", |_| Ok(());
    links: Link by "LinkKeys", |_| Ok(());
    zones: Zone by "ZoneKeys", |list| {
        for zone in list {
            let is_given = zone.inflate.is_some() || zone.part_factors().iter().any(|(_, number)| !number.is_nan());
            if zone.factor == 0.0 && is_given {
                zone.factor = 1.0;
            }
            let missing = zone.part_factors_mut().into_iter().filter(|(_, number)| number.is_nan());
            missing.for_each(|(_, number)| *number = 1.0);
        }
        Ok(())
    };
    keyframes: Key by "KeyframeKeys", |list| match list.is_empty() {
        true => Err("at least one keyframe like { time = 1, translate = [0, 1, 0] }"),
        false => Ok(()),
    };
}
