//! The keys of acceleration fields.

use serde::de::Deserializer;
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::curve::strength;
use super::ranges::{count, direction, finite, fraction, not_negative, positive, rate};
use super::selection::SelectionKeys;
use supple::{Attraction, Curve, Field, FieldLaw, Selection, Vortex, Wind};

/// The kinds of fields.
pub(super) const LAWS: [&str; 5] = ["gravity", "wind", "drag", "vortex", "attract"];

#[derive(Serialize, Deserialize)]
#[serde(remote = "Field")]
pub(super) struct FieldKeys {
    #[serde(rename = "@law", with = "FieldLawKeys")]
    law: FieldLaw,
    #[serde(default = "one", with = "strength")]
    strength: Curve,
    #[serde(default)]
    bodies: Vec<String>,
    #[serde(
        default,
        rename = "@within",
        with = "optional_selection",
        skip_serializing_if = "Option::is_none"
    )]
    within: Option<Selection>,
}

/// A field, as serde reads and writes the table of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FieldTable(#[serde(with = "FieldKeys")] pub Field);

fn one() -> Curve {
    1.0.into()
}

optional! {
    optional_selection: Selection by "SelectionKeys";
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "FieldLaw", rename_all = "snake_case")]
enum FieldLawKeys {
    Gravity([f64; 3]),
    Wind(#[serde(with = "WindKeys")] Wind),
    Drag(#[serde(deserialize_with = "rate")] f64),
    Vortex(#[serde(with = "VortexKeys")] Vortex),
    Attract(#[serde(with = "AttractionKeys")] Attraction),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Wind", default, bound = "")]
struct WindKeys {
    velocity: [f64; 3],
    #[serde(deserialize_with = "rate")]
    drag: f64,
    #[serde(deserialize_with = "fraction")]
    gust: f64,
    #[serde(deserialize_with = "not_negative")]
    turbulence: f64,
    #[serde(deserialize_with = "count::<_, _, 0, { u32::MAX }>")]
    seed: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Vortex", default, bound = "")]
struct VortexKeys {
    center: [f64; 3],
    #[serde(deserialize_with = "direction")]
    axis: [f64; 3],
    #[serde(deserialize_with = "finite")]
    spin: f64,
    #[serde(deserialize_with = "positive")]
    radius: f64,
    #[serde(deserialize_with = "rate")]
    drag: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Attraction", default, bound = "")]
struct AttractionKeys {
    center: [f64; 3],
    #[serde(deserialize_with = "finite")]
    acceleration: f64,
    #[serde(deserialize_with = "positive")]
    radius: f64,
    #[serde(deserialize_with = "not_negative")]
    power: f64,
}
