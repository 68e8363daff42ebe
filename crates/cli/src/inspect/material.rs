//! Describes the material of a body: what the scene asks for, and what the lattice and the steps make of it.

use std::f64::consts::TAU;

use serde::Serialize;
use supple::{Body, BodyRef, BreakLimit, Damping, Elasticity, FractureOptions, HalfWidth, Plasticity};
use supple_io::counted;

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
    pub(super) poisson_ratio: f64,
    /// How the half-width is chosen; `None` if the elasticity is that of regions.
    pub(super) accuracy: Option<&'static str>,
    /// Half-widths and the steps per second with which they reach the specified Young's modulus in all parts; empty if the
    /// elasticity is that of regions.
    pub(super) step_rates: Vec<(HalfWidth, f64)>,
    /// Length R over which the regions resist, in scene units: parts of the thickness t bend 0.6 R²/t² less than they
    /// should.
    pub(super) region_radius: f64,
    /// Least width of the body in scene units; 0 without volume.
    pub(super) least_width: f64,
    /// Shear modulus in force, E/(2 (1 + nu)).
    pub(super) shear_modulus: f64,
    /// Bulk modulus in force, E/(3 (1 - 2 nu)).
    pub(super) bulk_modulus: f64,
    /// Speed of longitudinal waves in a thin bar, the square root of Young's modulus in force over the density.
    pub(super) wave_speed: f64,
    /// Frequency of the lowest elastic mode of the free body, in Hz.
    pub(super) lowest_frequency: f64,
    /// Damping ratio of the lowest elastic mode. It exceeds 1 if `damping_rate` is so large.
    pub(super) damping_ratio: f64,
    /// Rate in 1/s at which the amplitudes of elastic modes decay.
    pub(super) damping_rate: f64,
    /// `None` if the body is elastic.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) plastic: Option<PlasticFacts>,
    /// `None` if the body does not break.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) fracture: Option<FractureFacts>,
}

/// Facts about the plasticity of a body.
#[derive(Debug, Serialize)]
pub(super) struct PlasticFacts {
    #[serde(rename = "yield")]
    yield_strain: f64,
    creep: f64,
    max: f64,
    /// Radius of the regions, which limits how small a dent can be, in scene units.
    region_radius: f64,
}

impl PlasticFacts {
    /// Collects the facts about the plasticity of a body.
    fn new(body: BodyRef<'_>) -> Option<Self> {
        let Plasticity { yield_strain, creep, max } = body.material().plastic?;
        Some(Self { yield_strain, creep, max, region_radius: region_radius(&body) })
    }

    /// Returns the facts as a line.
    pub(super) fn line(&self) -> String {
        let Self { yield_strain, creep, max, region_radius } = self;
        format!(
            "flows beyond a strain of {yield_strain}, at {creep} /s, up to a plastic strain of {max}; region radius {}, \
             best at most 0.15 of the thickness",
            number(*region_radius)
        )
    }
}

/// Facts about the fracture of a body.
#[derive(Debug, Serialize)]
pub(super) struct FractureFacts {
    /// `None` if the scene has the strain.
    strength: Option<f64>,
    /// `None` if the scene has the strength.
    strain: Option<f64>,
    /// Strain at which joints break in steps of this length, for Young's modulus in force.
    strain_in_force: f64,
    /// Stress of this strain.
    stress_in_force: f64,
    rotation: Option<f64>,
    cracks: usize,
    noise: f64,
    seed: u64,
    surface: &'static str,
}

impl FractureFacts {
    /// Collects the facts about the fracture of a body. `modulus`: Young's modulus in force.
    fn new(body: BodyRef<'_>, modulus: f64) -> Option<Self> {
        let options = body.fracture()?;
        let &FractureOptions { limit, rotation, cracks, noise, seed, surface } = options;
        let (strength, strain) = match limit {
            BreakLimit::Strength(stress) => (Some(stress), None),
            BreakLimit::Strain(strain) => (None, Some(strain)),
        };
        let strain_in_force = options.strain_limit(modulus);
        let stress_in_force = strain_in_force * modulus;
        let surface = surface.name();
        Some(Self {
            strength,
            strain,
            strain_in_force,
            stress_in_force,
            rotation,
            cracks,
            noise,
            seed,
            surface,
        })
    }

    /// Returns the facts as a line.
    pub(super) fn line(&self) -> String {
        let Self { strain_in_force, stress_in_force, rotation, cracks, noise, seed, surface, .. } = self;
        let rotation =
            rotation.map_or_else(String::new, |angle| format!(" or a rotation of {angle} degrees"));
        format!(
            "breaks at a strain of {}, a stress of {}{rotation}; noise {noise} with seed {seed}, at most {} at a time, {surface} surfaces",
            number(*strain_in_force),
            number(*stress_in_force),
            counted(*cracks, "crack"),
        )
    }
}

/// Returns the length R over which the regions of a body resist, in scene units.
fn region_radius(body: &Body) -> f64 {
    body.lattice().cell_size() * body.half_width().radius()
}

/// Returns the steps per second with which regions of half-width 0.5, 1, 2, 3 and that of the body reach Young's modulus
/// `modulus`.
fn step_rates(body: &Body, modulus: f64) -> Vec<(HalfWidth, f64)> {
    let greatest =
        body.stiffness_factors().map_or(1.0, |factors| factors.iter().copied().fold(0.0, f64::max));
    let rate = |half_width| (half_width, body.step_rate(half_width, greatest * modulus));
    let own = Some(body.half_width()).filter(|half_width| half_width.cells() > 3.0);
    [0.5, 1.0, 2.0, 3.0].map(HalfWidth::from).into_iter().chain(own).map(rate).collect()
}

impl MaterialFacts {
    /// Collects the facts about the material of a body in a simulation; `None` outside a simulation.
    pub(super) fn new(body: BodyRef<'_>) -> Option<Self> {
        let material = body.material();
        let (in_force, lowest_frequency) = (body.youngs_modulus()?, body.lowest_frequency()?);
        let specified = body.softened().map_or(in_force, |softened| softened.specified / softened.factor);
        let has_modulus = !matches!(material.elasticity, Elasticity::Regions { .. });
        let (angular_frequency, poisson_ratio) = (TAU * lowest_frequency, material.poisson_ratio());
        let (damping_ratio, damping_rate) = match material.damping() {
            Damping::Ratio(ratio) => (ratio, ratio * angular_frequency),
            Damping::Rate(rate) => (rate / angular_frequency, rate),
        };
        Some(Self {
            material: match material.elasticity {
                Elasticity::Preset(preset) => Some(preset.name()),
                _ => None,
            },
            youngs_modulus: has_modulus.then_some(specified),
            youngs_modulus_in_force: in_force,
            poisson_ratio,
            accuracy: has_modulus.then(|| material.accuracy.name()),
            step_rates: if has_modulus { step_rates(&body, specified) } else { Vec::new() },
            region_radius: region_radius(&body),
            least_width: body.least_width(),
            shear_modulus: in_force / (2.0 * (1.0 + poisson_ratio)),
            bulk_modulus: in_force / (3.0 * (1.0 - 2.0 * poisson_ratio)),
            wave_speed: (in_force / material.density).sqrt(),
            lowest_frequency,
            damping_ratio,
            damping_rate,
            plastic: PlasticFacts::new(body),
            fracture: FractureFacts::new(body, in_force),
        })
    }

    /// Returns why the regions have their half-width, and the steps of others; `None` if the elasticity is that of regions.
    pub(super) fn regions(&self) -> Option<String> {
        let rates: Vec<String> =
            self.step_rates.iter().map(|(half_width, rate)| format!("{half_width}: {rate:.0}")).collect();
        let width = match self.least_width {
            0.0 => String::new(),
            width => format!(" in a body {} wide", number(width)),
        };
        Some(format!(
            "accuracy {}, region radius {}{width}; steps per second by half-width: {}",
            self.accuracy?,
            number(self.region_radius),
            rates.join(", ")
        ))
    }

    /// Returns the facts as three lines.
    pub(super) fn lines(&self) -> [String; 3] {
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
        let moduli = format!(
            "Poisson's ratio {}, shear modulus {}, bulk modulus {}",
            self.poisson_ratio,
            number(self.shear_modulus),
            number(self.bulk_modulus)
        );
        [name + &modulus, moduli, format!("wave speed {speed}, lowest frequency {frequency} Hz, {damping}")]
    }
}
