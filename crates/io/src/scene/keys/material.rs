//! The keys of a material.

use serde::de::Deserializer;
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::ranges::{
    fraction, half_width, not_negative, plastic_limit, poisson_ratio, positive, positive_fraction,
};
use super::{accuracy, preset};
use supple::{
    Accuracy, Damping, Elasticity, HalfWidth, Material, Plasticity, Preset, RegionDamping, RegionSize,
    Stiffness,
};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Material", default, bound = "")]
pub(in crate::scene) struct MaterialKeys {
    #[serde(rename = "@elasticity", with = "elasticity")]
    elasticity: Elasticity,
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "poisson_ratio")]
    poisson_ratio: Option<f64>,
    #[serde(with = "accuracy")]
    accuracy: Accuracy,
    #[serde(rename = "@damping", with = "damping", skip_serializing_if = "Option::is_none")]
    damping: Option<Damping>,
    #[serde(rename = "@region_damping", with = "RegionDampingKeys")]
    region_damping: RegionDamping,
    #[serde(deserialize_with = "positive")]
    density: f64,
    #[serde(with = "plastic", skip_serializing_if = "Option::is_none")]
    plastic: Option<Plasticity>,
}

/// The keys of an [`Elasticity`]. [`Field`](crate::scene::field::Field) checks that they belong to one way to set it.
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

/// The table of an optional [`Plasticity`].
mod plastic {
    use super::*;

    #[derive(Serialize, Deserialize)]
    #[serde(transparent)]
    struct Item(#[serde(with = "PlasticKeys")] Plasticity);

    pub(super) fn serialize<S: Serializer>(
        plastic: &Option<Plasticity>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        plastic.map(Item).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Plasticity>, D::Error> {
        Item::deserialize(value).map(|Item(plastic)| Some(plastic))
    }
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Plasticity", default, bound = "")]
struct PlasticKeys {
    #[serde(rename = "yield", deserialize_with = "positive_fraction")]
    yield_strain: f64,
    #[serde(deserialize_with = "positive")]
    creep: f64,
    #[serde(deserialize_with = "plastic_limit")]
    max: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "RegionSize")]
enum RegionSizeKeys {
    #[serde(rename = "half_width")]
    Cells(#[serde(deserialize_with = "half_width")] HalfWidth),
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
