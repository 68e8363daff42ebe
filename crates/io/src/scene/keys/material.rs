//! The keys of a material.

use serde::de::Deserializer;
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};

use super::ranges::{
    creep, fraction, frequency, half_width, length, plastic_strain, positive, positive_fraction, rate,
};
use super::{accuracy, curve, preset};
use supple::{
    Accuracy, Damping, Elasticity, HalfWidth, Material, Plasticity, Preset, RegionDamping, RegionSize,
    Stiffness,
};

#[derive(Serialize, Deserialize)]
#[serde(remote = "Material", default, bound = "")]
pub(in crate::scene) struct MaterialKeys {
    #[serde(rename = "@elasticity", with = "elasticity")]
    elasticity: Elasticity,
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "curve::greatest_poisson_ratio")]
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
        #[serde(with = "optional_preset", skip_serializing_if = "Option::is_none")]
        material: Option<Preset>,
        #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "curve::greatest_modulus")]
        youngs_modulus: Option<f64>,
        #[serde(rename = "@region_size", with = "optional_size", skip_serializing_if = "Option::is_none")]
        size: Option<RegionSize>,
        #[serde(rename = "@stiffness", with = "optional_stiffness", skip_serializing_if = "Option::is_none")]
        stiffness: Option<Stiffness>,
    }

    optional! {
        optional_preset: Preset by "preset";
        optional_size: RegionSize by "RegionSizeKeys";
        optional_stiffness: Stiffness by "StiffnessKeys";
    }

    pub(super) fn serialize<S: Serializer>(
        elasticity: &Elasticity,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let mut keys = Keys::default();
        match *elasticity {
            Elasticity::Preset(preset) => keys.material = Some(preset),
            Elasticity::YoungsModulus(modulus) => keys.youngs_modulus = Some(modulus),
            Elasticity::Regions { size, stiffness } => {
                (keys.size, keys.stiffness) = (Some(size), Some(stiffness));
            }
        }
        keys.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(value: D) -> Result<Elasticity, D::Error> {
        let Keys { material, youngs_modulus, size, stiffness } = Keys::deserialize(value)?;
        let mut elasticity = match (material, youngs_modulus) {
            (Some(preset), _) => Elasticity::Preset(preset),
            (None, Some(modulus)) => Elasticity::YoungsModulus(modulus),
            (None, None) => Elasticity::REGIONS,
        };
        if let Some(size) = size {
            elasticity = elasticity.with_region_size(size);
        }
        if let Some(stiffness) = stiffness {
            elasticity = elasticity.with_stiffness(stiffness);
        }
        Ok(elasticity)
    }
}

optional! {
    damping: Damping by "DampingKeys";
    plastic: Plasticity by "PlasticKeys";
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Damping")]
enum DampingKeys {
    #[serde(rename = "damping_ratio")]
    Ratio(#[serde(deserialize_with = "curve::greatest_damping_ratio")] f64),
    #[serde(rename = "damping_rate")]
    Rate(#[serde(deserialize_with = "rate")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Plasticity", default, bound = "")]
struct PlasticKeys {
    #[serde(rename = "yield", deserialize_with = "positive_fraction")]
    yield_strain: f64,
    #[serde(deserialize_with = "creep")]
    creep: f64,
    #[serde(deserialize_with = "plastic_strain")]
    max: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "RegionSize")]
enum RegionSizeKeys {
    #[serde(rename = "half_width")]
    Cells(#[serde(deserialize_with = "half_width")] HalfWidth),
    #[serde(rename = "stiffness_radius")]
    Radius(#[serde(deserialize_with = "length")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "Stiffness")]
enum StiffnessKeys {
    #[serde(rename = "stiffness")]
    PerStep(#[serde(deserialize_with = "positive_fraction")] f64),
    #[serde(rename = "frequency")]
    Frequency(#[serde(deserialize_with = "frequency")] f64),
}

#[derive(Serialize, Deserialize)]
#[serde(remote = "RegionDamping")]
enum RegionDampingKeys {
    #[serde(rename = "region_damping")]
    PerStep(#[serde(deserialize_with = "fraction")] f64),
    #[serde(rename = "region_damping_rate")]
    Rate(#[serde(deserialize_with = "rate")] f64),
}
