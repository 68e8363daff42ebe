//! Defines the scene keys for the types of [`supple`]: names, ranges, and mutually exclusive keys.
//!
//! | file | contents |
//! |---|---|
//! | `link` | the keys of links |
//! | `material` | the keys of a material |
//! | `curve` | numbers that may have keyframes |
//! | `field_laws` | the keys of acceleration fields |
//! | `fracture` | the keys of the fracture of a body |
//! | `parts` | the keys of pins, handles and zones, and of keyframes |
//! | `selection` | the keys of selections |
//! | `switch` | what is on or off, and may have keyframes |
//! | `ranges` | functions that read a number, vector or string and check its range |
//!
//! Each `...Keys` type defines for serde how a type of [`supple`] is written in a scene. The defaults come
//! from the types of [`supple`].

/// Defines modules that serialize an optional value. `$keys`, a type or module, serializes a value that is given.
macro_rules! optional {
    ($($module:ident: $of:ident by $keys:literal;)*) => {$(
        pub(in crate::scene) mod $module {
            use super::*;

            #[derive(Serialize, Deserialize)]
            #[serde(transparent)]
            struct Item(#[serde(with = $keys)] $of);

            pub(in crate::scene) fn serialize<S: Serializer>(value: &Option<$of>, serializer: S) -> Result<S::Ok, S::Error> {
                value.clone().map(Item).serialize(serializer)
            }

            pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Option<$of>, D::Error> {
                Item::deserialize(value).map(|Item(value)| Some(value))
            }
        }
    )*};
}

mod curve;
mod field_laws;
mod fracture;
mod link;
mod material;
mod parts;
mod ranges;
mod selection;
pub(super) mod switch;

use serde::de::{Deserializer, Error};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use supple::{
    Accuracy, CutSurface, FieldKind, Interpolation, Placement, Preservation, Preset, Refine, Resolution,
    SkinKind, TouchingOptions, VolumeOptions, VolumeScope,
};

pub(super) use curve::{KeyedKeys, inflate, time_scale, vector};
pub use field_laws::FieldTable;
pub(super) use fracture::optional_fracture;
pub use link::LinkTable;
pub(super) use material::MaterialKeys;
pub use parts::GoalTable;
pub(super) use parts::{WindowKeys, fields, keyframes, links, optional_goal, pins, zones};
pub(super) use ranges::{
    count, direction, directory, extents, film_size, finite, fps, fraction, interval, mesh, name,
    not_negative, point_cache, positive, preroll, view,
};
pub(super) use selection::SelectionKeys;
pub use switch::EnabledTable;

/// Largest number of lattice vertices. Their indices must fit in 32 bits.
const MAX_VERTICES: u32 = 2_000_000_000;

/// Pairs of mutually exclusive keys of a body. The two keys of a pair set the same quantity.
const ALTERNATIVES: [[&str; 2]; 5] = [
    ["lattice_vertices", "cell_size"],
    ["half_width", "stiffness_radius"],
    ["stiffness", "frequency"],
    ["damping_ratio", "damping_rate"],
    ["region_damping", "region_damping_rate"],
];

/// The two motions of a handle, which exclude each other.
const MOTIONS: [&str; 2] = ["keys", "follow"];

/// The two limits of a body that breaks, which exclude each other.
const BREAK_LIMITS: [&str; 2] = ["strength", "strain"];

/// The three ways to set the elasticity of a body. Keys of different ways exclude each other.
pub(super) const ELASTICITY: [&[&str]; 3] =
    [&["material"], &["youngs_modulus"], &["half_width", "stiffness_radius", "stiffness", "frequency"]];

/// Returns the keys of a body, its fracture or a handle that exclude `key`.
pub fn exclusive_keys(key: &str) -> Vec<&'static str> {
    let alternatives = ALTERNATIVES
        .iter()
        .chain([&MOTIONS, &BREAK_LIMITS])
        .filter(|pair| pair.contains(&key))
        .flatten()
        .copied();
    let is_elasticity = ELASTICITY.iter().any(|way| way.contains(&key));
    let other_ways = ELASTICITY.iter().filter(|way| is_elasticity && !way.contains(&key));
    alternatives.chain(other_ways.copied().flatten().copied()).filter(|other| *other != key).collect()
}

/// Returns the keys of a body that may be left out for another key, or that have no default value.
pub fn optional_keys() -> Vec<&'static str> {
    let mut keys: Vec<_> =
        ALTERNATIVES.iter().flatten().chain(ELASTICITY[0]).chain(ELASTICITY[1]).copied().collect();
    keys.extend([
        "object",
        "poisson_ratio",
        "rolling_resistance",
        "thickness",
        "self_contact",
        "plastic",
        "fracture",
    ]);
    keys
}

/// Returns the scene keys of some fields: several keys for a field named `@...`, otherwise the name of the
/// field.
pub(super) fn expand<'a>(fields: &[&'a str]) -> Vec<&'a str> {
    let keys = |field: &&'a str| -> Vec<&'a str> {
        match *field {
            "@placement" => vec!["rotate", "translate", "velocity", "spin"],
            "@material" => expand(&[
                "@elasticity",
                "poisson_ratio",
                "accuracy",
                "@damping",
                "@region_damping",
                "density",
                "plastic",
            ]),
            "@elasticity" => ELASTICITY.concat(),
            "@touching" => {
                vec!["friction", "restitution", "rolling_resistance", "thickness", "ignore", "self_contact"]
            }
            "@keyed" => vec!["youngs_modulus", "poisson_ratio", "damping_ratio", "friction"],
            "@resolution" => ALTERNATIVES[0].to_vec(),
            "@region_size" => ALTERNATIVES[1].to_vec(),
            "@stiffness" => ALTERNATIVES[2].to_vec(),
            "@damping" => ALTERNATIVES[3].to_vec(),
            "@region_damping" => ALTERNATIVES[4].to_vec(),
            "@limit" => BREAK_LIMITS.to_vec(),
            "@selection" => vec!["box", "sphere", "plane", "vertices", "group", "map", "lattice"],
            "@goal" => vec!["weight", "goal_frequency", "goal_damping"],
            "@within" => vec!["box", "sphere", "plane"],
            "@law" => field_laws::LAWS.to_vec(),
            "@shape" => vec!["plane", "sphere", "box", "capsule", "mesh"],
            "@window" => vec!["start", "end"],
            key => vec![key],
        }
    };
    fields.iter().flat_map(keys).collect()
}

/// Returns the keys of the material of a body.
pub(crate) fn material_keys() -> Vec<&'static str> {
    expand(&["@material"])
}

/// Returns the keys of a body that say how it touches colliders and other bodies.
pub(crate) fn touching_keys() -> Vec<&'static str> {
    expand(&["@touching"])
}

/// Returns the keys of a body that a rigid body does not have, because it does not deform.
pub(super) fn keys_of_soft_bodies() -> Vec<&'static str> {
    let material = material_keys().into_iter().filter(|key| *key != "density");
    material.chain(["fracture", "inflate", "zone"]).collect()
}

/// Returns the description of a valid value of a key, for the message that the key is missing or that its
/// value is not a list.
pub(super) fn hint_for(key: &str) -> &'static str {
    match key {
        "mesh" => "the path of a model (OBJ, GLB, glTF, STL, PLY), relative to the scene file",
        "keys" => "a list of keyframes, each with its `time`",
        "factor" => "a factor of the stiffness in (0, 100]; or give `inflate`, a ratio of the rest volume",
        "ignore" => "a list of names of bodies like [\"eyes\"]",
        "body" => "the name of the body that is linked",
        "vertices" => "a list of mesh vertices like [0, 5]",
        "lattice" => "a list of lattice vertices like [0, 5]",
        "time" => "a time in seconds",
        "value" => "a number: the value at this time",
        "radius" => "a length",
        "min" => "the corner with the smallest coordinates, three numbers",
        "max" => "the corner with the largest coordinates, three numbers",
        "a" | "b" => "an end of the axis, three numbers",
        "half_extents" => "half of each edge length, three numbers",
        "normal" => "a direction, three numbers",
        "center" => "three numbers",
        "point" => "a point of the plane, three numbers",
        "bodies" => "a list of names of bodies like [\"flag\"]",
        "gravity" => "a kind of field: `gravity`, `wind`, `drag`, `vortex` or `attract`",
        _ => "a list of tables",
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Placement", default, bound = "")]
pub(super) struct PlacementKeys {
    rotate: [f64; 3],
    translate: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "TouchingOptions", default, bound = "")]
pub(super) struct TouchingKeys {
    #[serde(deserialize_with = "curve::greatest_friction")]
    friction: f64,
    #[serde(deserialize_with = "fraction")]
    restitution: f64,
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    rolling_resistance: Option<f64>,
    #[serde(skip_serializing_if = "has_no_thickness", deserialize_with = "not_negative")]
    thickness: f64,
    #[serde(rename = "ignore")]
    ignored: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    self_contact: Option<bool>,
    // Scenes have no bodies that another program moves.
    #[serde(skip)]
    soft_only: bool,
}

pub(super) fn has_no_thickness(thickness: &f64) -> bool {
    *thickness == 0.0
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Resolution", rename_all = "snake_case")]
pub(super) enum ResolutionKeys {
    #[serde(rename = "lattice_vertices")]
    Vertices(#[serde(deserialize_with = "count::<_, _, 8, MAX_VERTICES>")] usize),
    CellSize(#[serde(deserialize_with = "positive")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "VolumeOptions", rename = "VolumeOptions", default, bound = "")]
pub(super) struct VolumeKeys {
    #[serde(with = "measure")]
    measure: Preservation,
    #[serde(with = "scope")]
    scope: VolumeScope,
    #[serde(with = "field")]
    field: FieldKind,
    #[serde(deserialize_with = "not_negative")]
    max_correction: f64,
}

/// The scale of a mesh: a number, or three.
pub(super) mod scale {
    use serde::de::{Error, Unexpected};
    use serde::{Deserialize, Deserializer, Serializer};
    use supple::Scale;
    use toml::Value;

    pub(in crate::scene) fn serialize<S: Serializer>(
        scale: &Scale,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        match scale {
            Scale::Uniform(factor) => serializer.serialize_f64(*factor),
            Scale::PerAxis(factors) => serializer.collect_seq(factors),
        }
    }

    pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Scale, D::Error> {
        let expected =
            "a number above 0, or three numbers that are not 0, of which negative ones mirror the mesh";
        let wrong_type = || D::Error::invalid_type(Unexpected::Other("value"), &expected);
        let scale = match Value::deserialize(value).map_err(|_| wrong_type())? {
            Value::Array(factors) => {
                let factors: Option<Vec<f64>> = factors.iter().map(number).collect();
                factors.and_then(|factors| <[f64; 3]>::try_from(factors).ok()).map(Scale::PerAxis)
            }
            value => Some(Scale::Uniform(number(&value).ok_or_else(wrong_type)?)),
        };
        scale.filter(|scale| scale.is_valid()).ok_or_else(|| D::Error::custom(expected))
    }

    fn number(value: &Value) -> Option<f64> {
        match value {
            Value::Integer(number) => Some(*number as f64),
            Value::Float(number) => Some(*number),
            _ => None,
        }
    }
}

/// Defines modules that serialize a value as its name.
macro_rules! words {
    ($($module:ident: $of:ident;)*) => {$(
        pub(super) mod $module {
            use super::*;

            pub(in crate::scene) fn serialize<S: Serializer>(value: &$of, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(value.name())
            }

            pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<$of, D::Error> {
                let word = String::deserialize(value)?;
                let known = $of::NAMED.iter().find(|(name, _)| *name == word);
                known.map(|&(_, value)| value).ok_or_else(|| {
                    let names = $of::NAMED.map(|(name, _)| name).join("\", \"");
                    D::Error::custom(format_args!("one of \"{names}\""))
                })
            }
        }
    )*};
}

words! {
    measure: Preservation;
    scope: VolumeScope;
    field: FieldKind;
    preset: Preset;
    accuracy: Accuracy;
    skin: SkinKind;
    refine: Refine;
    interpolation: Interpolation;
    cut_surface: CutSurface;
}
