//! The keys of the fracture of a body.

use serde::de::Deserializer;
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::cut_surface;
use super::ranges::{break_angle, count, noise, positive};
use supple::{BreakLimit, CutSurface, FractureOptions};

#[derive(Serialize, Deserialize)]
#[serde(transparent)]
struct Item(#[serde(with = "FractureKeys")] FractureOptions);

/// Writes the table of optional [`FractureOptions`].
pub(in crate::scene) fn serialize<S: Serializer>(
    fracture: &Option<FractureOptions>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    fracture.map(Item).serialize(serializer)
}

/// Reads the table of optional [`FractureOptions`].
pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(
    value: D,
) -> Result<Option<FractureOptions>, D::Error> {
    Item::deserialize(value).map(|Item(fracture)| Some(fracture))
}

/// The defaults of all keys but the limit, which a table must have.
fn default() -> FractureOptions {
    FractureOptions::new(BreakLimit::Strain(1.0))
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "FractureOptions")]
struct FractureKeys {
    #[serde(rename = "@limit", with = "BreakLimitKeys")]
    limit: BreakLimit,
    #[serde(default, deserialize_with = "angle", skip_serializing_if = "Option::is_none")]
    rotation: Option<f64>,
    #[serde(
        default = "default_cracks",
        deserialize_with = "count::<_, _, 1, { FractureOptions::MAX_CRACKS }>"
    )]
    cracks: usize,
    #[serde(default = "default_noise", deserialize_with = "noise")]
    noise: f64,
    #[serde(default = "default_seed", deserialize_with = "count::<_, _, 0, { u32::MAX }>")]
    seed: u64,
    #[serde(default, with = "cut_surface")]
    surface: CutSurface,
}

fn angle<'de, D: Deserializer<'de>>(value: D) -> Result<Option<f64>, D::Error> {
    break_angle(value).map(Some)
}

fn default_cracks() -> usize {
    default().cracks
}

fn default_noise() -> f64 {
    default().noise
}

fn default_seed() -> u64 {
    default().seed
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "BreakLimit", rename_all = "snake_case")]
enum BreakLimitKeys {
    Strength(#[serde(deserialize_with = "positive")] f64),
    Strain(#[serde(deserialize_with = "positive")] f64),
}
