//! Defines the scene keys for the types of [`supple`]: names, ranges, and mutually exclusive keys.
//!
//! Each `...Keys` type defines for serde how a type of [`supple`] is written in a scene. The defaults come
//! from the types of [`supple`].

use std::path::PathBuf;

use serde::de::{Deserializer, Error};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::name::is_name;
use supple::{
    Collider, Damping, Elasticity, FieldKind, Handle, Key, Material, Pin, Placement, Preservation, Preset,
    RegionDamping, RegionSize, Resolution, Selection, Shape, Stiffness, TimeWindow, VolumeOptions,
    VolumeScope,
};

/// Largest number of lattice vertices. Their indices must fit in 32 bits.
const MAX_VERTICES: u32 = 2_000_000_000;
/// Largest half-width of a region, in cells. Lattices have fewer cells in each direction.
const MAX_HALF_WIDTH: u32 = 1_000_000;

/// Pairs of mutually exclusive keys of a body. The two keys of a pair set the same quantity.
const ALTERNATIVES: [[&str; 2]; 5] = [
    ["lattice_vertices", "cell_size"],
    ["half_width", "stiffness_radius"],
    ["stiffness", "frequency"],
    ["damping_ratio", "damping_rate"],
    ["region_damping", "region_damping_rate"],
];

/// The three ways to set the elasticity of a body. Keys of different ways exclude each other.
pub(super) const ELASTICITY: [&[&str]; 3] =
    [&["material"], &["youngs_modulus"], &["half_width", "stiffness_radius", "stiffness", "frequency"]];

/// Returns the keys of a body that exclude `key`.
pub fn exclusive_keys(key: &str) -> Vec<&'static str> {
    let alternatives = ALTERNATIVES.iter().filter(|pair| pair.contains(&key)).flatten().copied();
    let is_elasticity = ELASTICITY.iter().any(|way| way.contains(&key));
    let other_ways = ELASTICITY.iter().filter(|way| is_elasticity && !way.contains(&key));
    alternatives.chain(other_ways.copied().flatten().copied()).filter(|other| *other != key).collect()
}

/// Returns the keys of a body that may be left out for another key, or that have no default value.
pub fn optional_keys() -> Vec<&'static str> {
    let mut keys: Vec<_> =
        ALTERNATIVES.iter().flatten().chain(ELASTICITY[0]).chain(ELASTICITY[1]).copied().collect();
    keys.push("object");
    keys
}

/// Returns the scene keys of some fields: several keys for a field named `@...`, otherwise the name of the
/// field.
pub(super) fn expand<'a>(fields: &[&'a str]) -> Vec<&'a str> {
    let keys = |field: &&'a str| -> Vec<&'a str> {
        match *field {
            "@placement" => vec!["rotate", "translate", "velocity", "spin"],
            "@material" => expand(&["@elasticity", "@damping", "@region_damping", "density"]),
            "@elasticity" => ELASTICITY.concat(),
            "@resolution" => ALTERNATIVES[0].to_vec(),
            "@region_size" => ALTERNATIVES[1].to_vec(),
            "@stiffness" => ALTERNATIVES[2].to_vec(),
            "@damping" => ALTERNATIVES[3].to_vec(),
            "@region_damping" => ALTERNATIVES[4].to_vec(),
            "@selection" => vec!["box", "sphere", "plane", "vertices"],
            "@shape" => vec!["plane", "sphere", "box", "capsule"],
            "@window" => vec!["start", "end"],
            key => vec![key],
        }
    };
    fields.iter().flat_map(keys).collect()
}

/// Returns the description of a valid value of a key, for the message that the key is missing or that its
/// value is not a list.
pub(super) fn hint_for(key: &str) -> &'static str {
    match key {
        "mesh" => "the path of an OBJ file, relative to the scene file",
        "keys" => "a list of keyframes like [{ time = 1, translate = [0, 1, 0] }]",
        "vertices" => "a list of lattice vertices like [0, 5]",
        "time" => "a time in seconds",
        "radius" => "a length",
        "min" => "the corner with the smallest coordinates, three numbers",
        "max" => "the corner with the largest coordinates, three numbers",
        "a" | "b" => "an end of the axis, three numbers",
        "half_extents" => "half of each edge length, three numbers",
        "normal" => "a direction, three numbers",
        "center" => "three numbers",
        "point" => "a point of the plane, three numbers",
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
#[serde(remote = "Resolution", rename_all = "snake_case")]
pub(super) enum ResolutionKeys {
    #[serde(rename = "lattice_vertices")]
    Vertices(#[serde(deserialize_with = "count::<_, _, 8, MAX_VERTICES>")] usize),
    CellSize(#[serde(deserialize_with = "positive")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Material", default, bound = "")]
pub(super) struct MaterialKeys {
    #[serde(rename = "@elasticity", with = "elasticity")]
    elasticity: Elasticity,
    #[serde(rename = "@damping", with = "damping", skip_serializing_if = "Option::is_none")]
    damping: Option<Damping>,
    #[serde(rename = "@region_damping", with = "RegionDampingKeys")]
    region_damping: RegionDamping,
    #[serde(deserialize_with = "positive")]
    density: f64,
}

/// The keys of an [`Elasticity`]. [`Field`](super::field::Field) checks that they belong to one way to set it.
mod elasticity {
    use super::*;

    #[derive(Default, Serialize, Deserialize)]
    #[serde(default)]
    struct Keys {
        #[serde(skip_serializing_if = "Option::is_none")]
        material: Option<PresetName>,
        #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "optional_positive")]
        youngs_modulus: Option<f64>,
        #[serde(rename = "@region_size", skip_serializing_if = "Option::is_none")]
        size: Option<Size>,
        #[serde(rename = "@stiffness", skip_serializing_if = "Option::is_none")]
        stiffness: Option<Alpha>,
    }

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct PresetName(#[serde(with = "preset")] Preset);

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Size(#[serde(with = "RegionSizeKeys")] RegionSize);

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Alpha(#[serde(with = "StiffnessKeys")] Stiffness);

    fn optional_positive<'de, D: Deserializer<'de>>(value: D) -> Result<Option<f64>, D::Error> {
        positive(value).map(Some)
    }

    pub(super) fn serialize<S: Serializer>(
        elasticity: &Elasticity,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let mut keys = Keys::default();
        match *elasticity {
            Elasticity::Preset(preset) => keys.material = Some(PresetName(preset)),
            Elasticity::YoungsModulus(modulus) => keys.youngs_modulus = Some(modulus),
            Elasticity::Regions { size, stiffness } => {
                (keys.size, keys.stiffness) = (Some(Size(size)), Some(Alpha(stiffness)));
            }
        }
        keys.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Elasticity, D::Error> {
        let Keys { material, youngs_modulus, size, stiffness } = Keys::deserialize(value)?;
        let mut elasticity = match (material, youngs_modulus) {
            (Some(PresetName(preset)), _) => Elasticity::Preset(preset),
            (None, Some(modulus)) => Elasticity::YoungsModulus(modulus),
            (None, None) => Elasticity::REGIONS,
        };
        if let Some(Size(size)) = size {
            elasticity = elasticity.with_region_size(size);
        }
        if let Some(Alpha(stiffness)) = stiffness {
            elasticity = elasticity.with_stiffness(stiffness);
        }
        Ok(elasticity)
    }
}

/// The keys of an optional [`Damping`].
mod damping {
    use super::*;

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Item(#[serde(with = "DampingKeys")] Damping);

    pub(super) fn serialize<S: Serializer>(
        damping: &Option<Damping>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        damping.map(Item).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Damping>, D::Error> {
        Item::deserialize(value).map(|Item(damping)| Some(damping))
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Damping")]
enum DampingKeys {
    #[serde(rename = "damping_ratio")]
    Ratio(#[serde(deserialize_with = "fraction")] f64),
    #[serde(rename = "damping_rate")]
    Rate(#[serde(deserialize_with = "not_negative")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "RegionSize")]
enum RegionSizeKeys {
    #[serde(rename = "half_width")]
    Cells(#[serde(deserialize_with = "count::<_, _, 1, MAX_HALF_WIDTH>")] usize),
    #[serde(rename = "stiffness_radius")]
    Radius(#[serde(deserialize_with = "positive")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Stiffness")]
enum StiffnessKeys {
    #[serde(rename = "stiffness")]
    PerStep(#[serde(deserialize_with = "positive_fraction")] f64),
    #[serde(rename = "frequency")]
    Frequency(#[serde(deserialize_with = "positive")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "RegionDamping")]
enum RegionDampingKeys {
    #[serde(rename = "region_damping")]
    PerStep(#[serde(deserialize_with = "fraction")] f64),
    #[serde(rename = "region_damping_rate")]
    Rate(#[serde(deserialize_with = "not_negative")] f64),
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

#[derive(Serialize, Deserialize)]
#[serde(remote = "Pin")]
struct PinKeys {
    #[serde(rename = "@selection", with = "SelectionKeys")]
    selection: Selection,
    #[serde(default, rename = "@window", with = "WindowKeys")]
    window: TimeWindow,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Handle")]
struct HandleKeys {
    #[serde(rename = "@selection", with = "SelectionKeys")]
    selection: Selection,
    #[serde(default, rename = "@window", with = "WindowKeys")]
    window: TimeWindow,
    #[serde(with = "keyframes")]
    keys: Vec<Key>,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Selection", rename_all = "snake_case", deny_unknown_fields)]
enum SelectionKeys {
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
    Vertices(Vec<u32>),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "TimeWindow", default, bound = "")]
struct WindowKeys {
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

#[derive(Serialize, Deserialize)]
#[serde(remote = "Collider")]
struct ColliderKeys {
    #[serde(rename = "@shape", with = "ShapeKeys")]
    shape: Shape,
    #[serde(default = "friction", deserialize_with = "not_negative")]
    friction: f64,
    #[serde(default, deserialize_with = "fraction")]
    restitution: f64,
    #[serde(default, with = "keyframes", skip_serializing_if = "Vec::is_empty")]
    keys: Vec<Key>,
}

/// Returns the default friction of a collider.
fn friction() -> f64 {
    Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Shape", rename_all = "snake_case", deny_unknown_fields)]
enum ShapeKeys {
    Plane {
        point: [f64; 3],
        #[serde(deserialize_with = "direction")]
        normal: [f64; 3],
    },
    Sphere {
        center: [f64; 3],
        #[serde(deserialize_with = "positive")]
        radius: f64,
    },
    Box {
        center: [f64; 3],
        #[serde(deserialize_with = "extents")]
        half_extents: [f64; 3],
        #[serde(default)]
        rotate: [f64; 3],
    },
    Capsule {
        a: [f64; 3],
        b: [f64; 3],
        #[serde(deserialize_with = "positive")]
        radius: f64,
    },
}

/// Defines modules that serialize lists of a type through its `...Keys`. `$check` returns an error if a list
/// is invalid.
macro_rules! lists {
    ($($module:ident: $of:ident by $keys:literal, $check:expr;)*) => {$(
        pub(super) mod $module {
            use super::*;

            #[derive(Serialize, Deserialize)]
            #[serde(transparent)]
            struct Item(#[serde(with = $keys)] $of);

            pub(in crate::scene) fn serialize<S: Serializer>(list: &[$of], serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_seq(list.iter().cloned().map(Item))
            }

            pub(in crate::scene) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Vec<$of>, D::Error> {
                let list: Vec<$of> = Vec::deserialize(value)?.into_iter().map(|Item(value)| value).collect();
                let check: fn(&[$of]) -> Result<(), &str> = $check;
                check(&list).map_err(D::Error::custom)?;
                Ok(list)
            }
        }
    )*};
}

lists! {
    pins: Pin by "PinKeys", |_| Ok(());
    handles: Handle by "HandleKeys", |_| Ok(());
    colliders: Collider by "ColliderKeys", |_| Ok(());
    keyframes: Key by "KeyframeKeys", |list| match list.is_empty() {
        true => Err("at least one keyframe like { time = 1, translate = [0, 1, 0] }"),
        false => Ok(()),
    };
}

/// Defines modules that serialize a value as its name.
macro_rules! words {
    ($($module:ident: $of:ident;)*) => {$(
        mod $module {
            use super::*;

            pub(super) fn serialize<S: Serializer>(value: &$of, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(value.name())
            }

            pub(super) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<$of, D::Error> {
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
}

/// Defines functions that deserialize a number, vector or string and check its range.
macro_rules! ranges {
    ($($name:ident($of:ty, $value:ident): $is_valid:expr, $range:expr;)*) => {$(
        pub(super) fn $name<'de, D: Deserializer<'de>, T: From<$of>>(value: D) -> Result<T, D::Error> {
            let $value = <$of>::deserialize(value)?;
            if $is_valid { Ok($value.into()) } else { Err(D::Error::custom($range)) }
        }
    )*};
}

ranges! {
    finite(f64, x): x.is_finite(), "a finite number";
    positive(f64, x): x.is_finite() && x > 0.0, "a number above 0";
    not_negative(f64, x): x.is_finite() && x >= 0.0, "a number of at least 0";
    positive_fraction(f64, x): x > 0.0 && x <= 1.0, "in (0, 1]";
    fraction(f64, x): (0.0..=1.0).contains(&x), "in [0, 1]";
    direction([f64; 3], v): v != [0.0; 3], "a vector that is not zero";
    extents([f64; 3], v): v.iter().all(|&half| half > 0.0), "three numbers above 0";
    name(String, name): is_name(&name),
        "made of letters, digits, `-`, `_` and `.` only, without a leading `.`, and of at most 200 bytes, because \
         it names files";
    mesh(PathBuf, path): !path.as_os_str().is_empty(), "the path of an OBJ file";
    directory(PathBuf, path): !path.as_os_str().is_empty(), "a directory; \".\" is that of the scene file";
}

/// Deserializes a whole number in the range from `LOW` to `HIGH`.
pub(super) fn count<'de, D, T, const LOW: u32, const HIGH: u32>(value: D) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: TryFrom<u32>,
{
    let number = f64::deserialize(value)?;
    let is_valid = number.fract() == 0.0 && (f64::from(LOW)..=f64::from(HIGH)).contains(&number);
    let count = is_valid.then(|| T::try_from(number as u32).ok()).flatten();
    count.ok_or_else(|| D::Error::custom(format_args!("a whole number from {LOW} to {HIGH}")))
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_infinite(number: &f64) -> bool {
    number.is_infinite()
}
