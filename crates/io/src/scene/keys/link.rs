//! The keys of links.

use serde::{Deserialize, Serialize};

use super::ranges::{fraction, positive};
use super::selection::SelectionKeys;
use supple::{Link, Selection};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Link")]
pub(super) struct LinkKeys {
    body: String,
    #[serde(rename = "@selection", with = "SelectionKeys")]
    selection: Selection,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    other: Option<String>,
    #[serde(default, deserialize_with = "positive", skip_serializing_if = "Option::is_none")]
    stiffness: Option<f64>,
    #[serde(default = "damping_ratio", deserialize_with = "fraction")]
    damping_ratio: f64,
    #[serde(
        default,
        rename = "break",
        deserialize_with = "positive",
        skip_serializing_if = "Option::is_none"
    )]
    break_force: Option<f64>,
}

/// A link, as serde reads and writes the table of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct LinkTable(#[serde(with = "LinkKeys")] pub Link);

fn damping_ratio() -> f64 {
    Link::new("", Selection::Vertices(Vec::new())).damping_ratio
}
