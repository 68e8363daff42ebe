//! The keys of selections.

use serde::{Deserialize, Serialize};

use super::ranges::{direction, positive};
use supple::{Map, Selection};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Selection", rename_all = "snake_case", deny_unknown_fields)]
pub(in crate::scene) enum SelectionKeys {
    Box {
        min: [f64; 3],
        max: [f64; 3],
    },
    Sphere {
        center: [f64; 3],
        #[serde(deserialize_with = "positive")]
        radius: f64,
    },
    Plane {
        point: [f64; 3],
        #[serde(deserialize_with = "direction")]
        normal: [f64; 3],
    },
    #[serde(rename = "lattice")]
    Vertices(Vec<u32>),
    #[serde(rename = "vertices")]
    MeshVertices(Vec<u32>),
    Group(String),
    Map(#[serde(with = "MapKeys")] Map),
}

/// A map: the name of one of the file, or weights.
#[derive(Serialize, Deserialize)]
#[serde(remote = "Map", untagged, expecting = "expected the name of a map of the file, or a list of weights")]
enum MapKeys {
    Name(String),
    Weights(Vec<f32>),
}
