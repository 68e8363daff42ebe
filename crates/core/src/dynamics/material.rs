//! Defines the material of a body.

use super::plasticity::Plasticity;
use crate::matching::HalfWidth;
use crate::motion::sin_cos_degrees;
use crate::range::{Range, RangeError};

/// Size of the regions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RegionSize {
    /// Half-width of the regions in cells. A body with a larger half-width is stiffer. At the same half-width, a body
    /// with larger cells is stiffer.
    Cells(HalfWidth),
    /// Half-width of the regions as a length in scene units, > 0. It is rounded to a whole number of cells,
    /// at least one.
    Radius(f64),
}

/// Stiffness: the rate at which vertices move towards their goal positions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Stiffness {
    /// alpha, in (0, 1]: the fraction of the distance to the goal position that a vertex covers in one step.
    PerStep(f64),
    /// Frequency f in Hz, > 0, at which a vertex oscillates about a fixed goal position.
    /// alpha = 2 (1 - cos(2 π f dt)), limited to 1. alpha reaches 1 if f is a sixth of the step rate 1/dt.
    Frequency(f64),
}

/// Region damping: the fraction of the non-rigid velocity within regions that a step removes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RegionDamping {
    /// Fraction per step, in [0, 1]; 0 disables the stage.
    PerStep(f64),
    /// Rate in 1/s, >= 0. The fraction per step is 1 - exp(-rate dt); 0 disables the stage.
    Rate(f64),
}

/// A named material, for bodies of any size under any gravity.
///
/// Young's modulus is E = k ρ L max(g, 8 L/s²): a body of the density ρ and the size L keeps its shape under the
/// gravity g. L is the cube root of the volume of the mesh, or of its bounding box if the mesh is open; of a bare
/// lattice it is the cube root of the volume of its cells. 8 L/s² is the gravity under which the body falls its own
/// size in half a second; it counts where there is little or no gravity.
///
/// A body that is more than 4 times as long as it is wide, with the ratio s, has (s/4)^(8/3) times this modulus: then a
/// bar of any length bends under its weight like one of 1 x 1 x 4, relative to its length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Preset {
    /// k = 20, damping ratio 0.1, Poisson's ratio 0.45.
    Jelly,
    /// k = 80, damping ratio 0.3, Poisson's ratio 0.45. The default.
    #[default]
    Flesh,
    /// k = 300, damping ratio 0.2, Poisson's ratio 0.4.
    Rubber,
    /// k = 1500, damping ratio 0.2, Poisson's ratio 0.3.
    Firm,
}

impl Preset {
    /// All presets with their names.
    pub const NAMED: [(&'static str, Self); 4] =
        [("jelly", Self::Jelly), ("flesh", Self::Flesh), ("rubber", Self::Rubber), ("firm", Self::Firm)];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
    }

    /// Returns k = E / (ρ L max(g, 8 L/s²)).
    pub fn relative_modulus(self) -> f64 {
        [20.0, 80.0, 300.0, 1500.0][self as usize]
    }

    /// Returns the damping ratio.
    pub fn damping_ratio(self) -> f64 {
        [0.1, 0.3, 0.2, 0.2][self as usize]
    }

    /// Returns Poisson's ratio.
    pub fn poisson_ratio(self) -> f64 {
        [0.45, 0.45, 0.4, 0.3][self as usize]
    }

    /// Computes Young's modulus E of a body. `density` is ρ, `size` is L, `slenderness` is s, and `gravity` is g.
    pub(crate) fn youngs_modulus(self, density: f64, size: f64, slenderness: f64, gravity: f64) -> f64 {
        // The end of a bar that is held at the other one sinks by 3/2 ρ g l³/(E t²), relative to its length l; with its
        // thickness t = l/s and size L = l/s^(2/3) this is 3/2 s^(8/3)/k.
        let slender = libm::pow((slenderness / COMPACT_SLENDERNESS).max(1.0), 8.0 / 3.0);
        self.relative_modulus() * slender * density * size * effective_gravity(size, gravity)
    }
}

/// Ratio of length to width up to which Young's modulus of a named material follows from the size alone.
const COMPACT_SLENDERNESS: f64 = 4.0;

/// Returns max(g, 8 L/s²): the gravity g, but at least that under which a body of the size L falls its own size in half
/// a second.
pub(crate) fn effective_gravity(size: f64, gravity: f64) -> f64 {
    gravity.max(8.0 * size)
}

/// How closely a body with a material or Young's modulus follows the elastic law, by the half-width of its regions:
/// smaller regions need more steps.
///
/// Automatic steps are short enough for the half-width that is chosen here, which depends on the body alone and not
/// on the frame rate. If the steps are too long for it, or shorter than the widest regions need, the half-width is
/// the least whole one that reaches Young's modulus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Accuracy {
    /// The widest regions: of a half-width of 2 cells, or a length R of 0.15 of the size of the body, the cube root of its
    /// volume, if that is more; but of at most 0.3 of its [least width](crate::Body::least_width), or a half-width of 1. The
    /// fewest steps. Layers of cells that are held or touched strain more than the others, and parts of the thickness t
    /// bend 0.6 R²/t² less.
    Fast,
    /// The least half-width with which a second takes at most [`Accuracy::BUDGET`] seconds of one core, by an
    /// estimate; at most that of `Fast`, and at most one cell in a body that is plastic or breaks by itself, whose dents and
    /// cracks follow the strain of the regions.
    #[default]
    Balanced,
    /// Regions of one cell.
    Exact,
}

impl Accuracy {
    /// All values with their names.
    pub const NAMED: [(&'static str, Self); 3] =
        [("fast", Self::Fast), ("balanced", Self::Balanced), ("exact", Self::Exact)];

    /// The share of the time of one core that [`Accuracy::Balanced`] may take.
    pub const BUDGET: f64 = 0.12;

    /// Returns the name.
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
    }
}

/// The elasticity of a body: how strongly it resists deformation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Elasticity {
    /// A named material.
    Preset(Preset),
    /// Young's modulus E, > 0: force per area in scene units (Pa if these are m, kg and s).
    YoungsModulus(f64),
    /// The parameters of Rivers & James 2007. The elasticity then depends on the lattice and the step length.
    Regions {
        /// Size of the regions; default 2 cells.
        size: RegionSize,
        /// Stiffness; default alpha = 1 per step.
        stiffness: Stiffness,
    },
}

/// Damping of the elastic modes of a body. Flight, spin, sliding and swinging about a pinned vertex are undamped.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Damping {
    /// Damping ratio of the lowest elastic mode of the free body, in [0, 1]; 0 disables the stage. At 1 this mode
    /// does not oscillate.
    Ratio(f64),
    /// Rate c in 1/s, >= 0, at which the amplitude of every elastic mode of an angular frequency above c decays: as
    /// exp(-c t). Slower modes do not oscillate. 0 disables the stage. A rate above √alpha/dt, the greatest angular
    /// frequency of a mode in steps of dt, acts like √alpha/dt.
    Rate(f64),
}

/// Material of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Elasticity; default [`Preset::Flesh`].
    pub elasticity: Elasticity,
    /// Poisson's ratio ν, in [0, 0.47]: stretched by the share s, the body becomes narrower by the share ν s. `None`,
    /// the default, is the one of the preset, and without a preset 0: the body keeps its width. Steps are stable up
    /// to alpha = 1.5/(1 + k) with k = 3 ν/(1 - 2 ν), and a greater alpha acts as this one: see
    /// [`ElasticLaw`](crate::ElasticLaw).
    pub poisson_ratio: Option<f64>,
    /// How the half-width of the regions is chosen for a material or Young's modulus; default [`Accuracy::Balanced`].
    pub accuracy: Accuracy,
    /// Damping; `None`, the default, is the damping ratio of the preset, and without a preset 0.2.
    pub damping: Option<Damping>,
    /// Region damping; default 0.
    pub region_damping: RegionDamping,
    /// Density: mass per volume in scene units, > 0; default 1000.
    pub density: f64,
    /// Plasticity; `None`, the default, is an elastic body.
    pub plastic: Option<Plasticity>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            elasticity: Elasticity::default(),
            poisson_ratio: None,
            accuracy: Accuracy::default(),
            damping: None,
            region_damping: RegionDamping::PerStep(0.0),
            density: 1000.0,
            plastic: None,
        }
    }
}

impl Default for Elasticity {
    fn default() -> Self {
        Self::Preset(Preset::default())
    }
}

impl Elasticity {
    /// The default parameters of Rivers & James 2007: regions of half-width 2, and alpha = 1 per step.
    pub const REGIONS: Self =
        Self::Regions { size: RegionSize::Cells(HalfWidth::whole(2)), stiffness: Stiffness::PerStep(1.0) };

    /// Returns this elasticity with another size of the regions. Without regions, the stiffness is alpha = 1.
    #[must_use]
    pub fn with_region_size(self, size: RegionSize) -> Self {
        match self {
            Self::Regions { stiffness, .. } => Self::Regions { size, stiffness },
            _ => Self::Regions { size, stiffness: Stiffness::PerStep(1.0) },
        }
    }

    /// Returns this elasticity with another stiffness. Without regions, the half-width is 2 cells.
    #[must_use]
    pub fn with_stiffness(self, stiffness: Stiffness) -> Self {
        match self {
            Self::Regions { size, .. } => Self::Regions { size, stiffness },
            _ => Self::Regions { size: RegionSize::Cells(HalfWidth::whole(2)), stiffness },
        }
    }

    /// Checks the ranges of all values.
    fn validate(self) -> Result<(), RangeError> {
        match self {
            Self::Preset(_) => Ok(()),
            Self::YoungsModulus(modulus) => Range::YOUNGS_MODULUS.check("youngs_modulus", modulus).map(drop),
            Self::Regions { size, stiffness } => {
                match size {
                    RegionSize::Cells(w) => Range::HALF_WIDTH.check("half_width", w.cells()),
                    RegionSize::Radius(r) => Range::LENGTH.check("stiffness_radius", r),
                }?;
                match stiffness {
                    Stiffness::PerStep(a) => Range::POSITIVE_FRACTION.check("stiffness", a),
                    Stiffness::Frequency(f) => Range::FREQUENCY.check("frequency", f),
                }
                .map(drop)
            }
        }
    }
}

impl Stiffness {
    /// Computes the number of steps per period of a frequency at which alpha is `alpha`, in (0, 1]. It is 6 for 1.
    pub(crate) fn steps_per_period(alpha: f64) -> f64 {
        // alpha = 2 (1 - cos 2πf dt): see `alpha`.
        std::f64::consts::TAU / libm::acos(1.0 - 0.5 * alpha)
    }

    /// Computes alpha, the fraction of the distance to the goal position that a vertex covers in one step of
    /// `dt` seconds.
    pub fn alpha(self, dt: f64) -> f64 {
        match self {
            Self::PerStep(alpha) => alpha,
            Self::Frequency(frequency) => {
                // alpha = 2 (1 - cos 2x) is computed as 4 sin² x, which does not cancel at low frequencies.
                // alpha is 1 for every f dt >= 1/6. So f dt is capped at 1/2, above which the sine would
                // decrease.
                let (sine, _) = sin_cos_degrees(180.0 * (frequency * dt).min(0.5));
                (4.0 * sine * sine).min(1.0)
            }
        }
    }
}

impl Material {
    /// Returns the material of Rivers & James 2007 without damping: regions of half-width 2, alpha = 1 per step.
    pub fn fast_lsm() -> Self {
        Self { elasticity: Elasticity::REGIONS, damping: Some(Damping::Ratio(0.0)), ..Self::default() }
    }

    /// Checks the ranges of all values.
    ///
    /// # Errors
    ///
    /// If a value is out of its range.
    pub fn validate(&self) -> Result<(), RangeError> {
        self.elasticity.validate()?;
        Range::POISSON_RATIO.check("poisson_ratio", self.poisson_ratio())?;
        match self.damping() {
            Damping::Ratio(d) => Range::FRACTION.check("damping_ratio", d),
            Damping::Rate(r) => Range::RATE.check("damping_rate", r),
        }?;
        match self.region_damping {
            RegionDamping::PerStep(d) => Range::FRACTION.check("region_damping", d),
            RegionDamping::Rate(r) => Range::RATE.check("region_damping_rate", r),
        }?;
        Range::POSITIVE.check("density", self.density)?;
        self.plastic.map_or(Ok(()), |plastic| plastic.validate())
    }

    /// Returns Poisson's ratio, with the default of the material if none is set.
    pub fn poisson_ratio(&self) -> f64 {
        self.poisson_ratio.unwrap_or(match self.elasticity {
            Elasticity::Preset(preset) => preset.poisson_ratio(),
            _ => 0.0,
        })
    }

    /// Returns the damping, with the default of the material if none is set.
    pub fn damping(&self) -> Damping {
        self.damping.unwrap_or(match self.elasticity {
            Elasticity::Preset(preset) => Damping::Ratio(preset.damping_ratio()),
            _ => Damping::Ratio(Preset::Rubber.damping_ratio()),
        })
    }

    /// Returns whether the elastic modes are damped.
    pub(crate) fn is_damped(&self) -> bool {
        !matches!(self.damping(), Damping::Ratio(0.0) | Damping::Rate(0.0))
    }

    /// Computes the fraction of the non-rigid velocity within regions that region damping removes in one step of
    /// `dt` seconds.
    pub fn region_damping_fraction(&self, dt: f64) -> f64 {
        match self.region_damping {
            RegionDamping::PerStep(fraction) => fraction,
            RegionDamping::Rate(rate) => -libm::expm1(-rate * dt),
        }
    }

    /// Returns whether region damping is enabled.
    pub(crate) fn has_region_damping(&self) -> bool {
        !matches!(self.region_damping, RegionDamping::PerStep(0.0) | RegionDamping::Rate(0.0))
    }
}
