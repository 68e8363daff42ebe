//! The keys of the fracture of a body.

use serde::de::Deserializer;
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::cut_surface;
use super::ranges::{break_angle, count, noise, positive};
use supple::{BreakLimit, CutSurface, FractureOptions};

optional! {
    optional_fracture: FractureOptions by "FractureKeys";
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
    #[serde(default, deserialize_with = "break_angle")]
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
