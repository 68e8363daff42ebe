//! Describes the material of a body: what the scene asks for, and what the lattice and the steps make of it.

use std::f64::consts::TAU;

use serde::Serialize;
use supple::{BodyRef, Damping, Elasticity};

use crate::terminal::number;

/// Facts about the material of a body. Lengths, masses and forces are in scene units.
#[derive(Debug, Serialize)]
pub(super) struct MaterialFacts {
    /// Name of the material; `None` if the elasticity is set in another way.
    pub(super) material: Option<&'static str>,
    /// Specified Young's modulus, that of the material or of `youngs_modulus`; `None` if the elasticity is that of
    /// regions.
    pub(super) youngs_modulus: Option<f64>,
    /// Young's modulus in force, less than the specified one if the steps are too long for it.
    pub(super) youngs_modulus_in_force: f64,
    /// Speed of longitudinal waves in a thin bar, the square root of Young's modulus in force over the density.
    pub(super) wave_speed: f64,
    /// Frequency of the lowest elastic mode of the free body, in Hz.
    pub(super) lowest_frequency: f64,
    /// Damping ratio of the lowest elastic mode. It exceeds 1 if `damping_rate` is so large.
    pub(super) damping_ratio: f64,
    /// Rate in 1/s at which the amplitudes of elastic modes decay.
    pub(super) damping_rate: f64,
}

impl MaterialFacts {
    /// Collects the facts about the material of a body in a simulation; `None` outside a simulation.
    pub(super) fn new(body: BodyRef<'_>) -> Option<Self> {
        let material = body.material();
        let (in_force, lowest_frequency) = (body.youngs_modulus()?, body.lowest_frequency()?);
        let specified = body.softened().map_or(in_force, |softened| softened.specified / softened.factor);
        let angular_frequency = TAU * lowest_frequency;
        let (damping_ratio, damping_rate) = match material.damping() {
            Damping::Ratio(ratio) => (ratio, ratio * angular_frequency),
            Damping::Rate(rate) => (rate / angular_frequency, rate),
        };
        Some(Self {
            material: match material.elasticity {
                Elasticity::Preset(preset) => Some(preset.name()),
                _ => None,
            },
            youngs_modulus: match material.elasticity {
                Elasticity::Regions { .. } => None,
                _ => Some(specified),
            },
            youngs_modulus_in_force: in_force,
            wave_speed: (in_force / material.density).sqrt(),
            lowest_frequency,
            damping_ratio,
            damping_rate,
        })
    }

    /// Returns the facts as two lines.
    pub(super) fn lines(&self) -> [String; 2] {
        let in_force = self.youngs_modulus_in_force;
        let modulus = match self.youngs_modulus {
            Some(specified) if specified > in_force => {
                format!("Young's modulus {}, in force {}", number(specified), number(in_force))
            }
            Some(specified) => format!("Young's modulus {}", number(specified)),
            None => format!("Young's modulus {} in steps of this length", number(in_force)),
        };
        let name = match (self.material, self.youngs_modulus) {
            (Some(name), _) => format!("{name}, "),
            (None, Some(_)) => String::new(),
            (None, None) => "by half-width and stiffness, ".to_owned(),
        };
        let damping = if self.damping_rate == 0.0 {
            "no damping".to_owned()
        } else {
            format!("damping ratio {} ({} /s)", number(self.damping_ratio), number(self.damping_rate))
        };
        let (speed, frequency) = (number(self.wave_speed), number(self.lowest_frequency));
        [name + &modulus, format!("wave speed {speed}, lowest frequency {frequency} Hz, {damping}")]
    }
}
