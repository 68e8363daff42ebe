//! Zones: parts of a body with another material.

use super::selection::Selection;
use crate::lattice::Lattice;
use crate::motion::Curve;
use crate::range::{Range, RangeError};

/// A part of a body with another stiffness, rest volume, density, strength, damping, friction or yield strain.
///
/// The part is a selection: the lattice vertices inside a shape, a list of vertices, a group or a map. Around a shape,
/// the logarithms of all factors decrease linearly to 0 over the length of a cell; a map is the share of them at each
/// vertex, so that a factor f counts as f^w at the weight w. Lists and groups have no border. The factors of
/// overlapping zones multiply.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// The part.
    pub selection: Selection,
    /// Factor of Young's modulus, in (0, 100]. The products of overlapping zones have the same range.
    pub factor: f64,
    /// Ratio of the rest volume of the part to its volume in the mesh, in [0.1, 10], over time; default 1. It
    /// multiplies the ratios of the body and of overlapping zones; the products are limited to the same range.
    pub inflate: Option<Curve>,
    /// Factor of the density, in (0, 100]; default 1. Young's modulus stays as it is.
    pub density: f64,
    /// Factor in (0, 100] of the limit at which the body breaks, see [`FractureOptions`](crate::FractureOptions);
    /// default 1.
    pub strength: f64,
    /// Factor in (0, 100] of the rate at which the elastic damping takes velocities away, see
    /// [`Damping`](crate::Damping); default 1. The momenta of a free body stay as they are. Rolling resistance acts in
    /// proportion to the fractions that the parts lose in a step.
    pub damping: f64,
    /// Factor in (0, 100] of the coefficient of friction at colliders and bodies; default 1.
    pub friction: f64,
    /// Factor in (0, 100] of the yield strain, see [`Plasticity`](crate::Plasticity); default 1.
    pub yield_strain: f64,
}

impl Zone {
    /// Creates a zone.
    pub fn new(selection: Selection, factor: f64) -> Self {
        Self {
            selection,
            factor,
            inflate: None,
            density: 1.0,
            strength: 1.0,
            damping: 1.0,
            friction: 1.0,
            yield_strain: 1.0,
        }
    }

    /// Returns the zone with another ratio of the rest volume.
    #[must_use]
    pub fn inflated(self, ratio: impl Into<Curve>) -> Self {
        Self { inflate: Some(ratio.into()), ..self }
    }

    /// Returns the factors beside the one of Young's modulus, with their keys in scenes.
    pub fn part_factors(&self) -> [(&'static str, f64); 5] {
        let factors = [self.density, self.strength, self.damping, self.friction, self.yield_strain];
        std::array::from_fn(|i| (Quantity::ALL[i].key(), factors[i]))
    }

    /// As [`part_factors`](Self::part_factors), to be changed.
    pub fn part_factors_mut(&mut self) -> [(&'static str, &mut f64); 5] {
        let Self { density, strength, damping, friction, yield_strain, .. } = self;
        let mut factors = [density, strength, damping, friction, yield_strain].into_iter();
        Quantity::ALL.map(|quantity| (quantity.key(), factors.next().expect("a factor of each quantity")))
    }
}

/// A quantity that zones multiply, beside the stiffness and the rest volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Quantity {
    Density,
    Strength,
    Damping,
    Friction,
    YieldStrain,
}

impl Quantity {
    pub(crate) const ALL: [Self; 5] =
        [Self::Density, Self::Strength, Self::Damping, Self::Friction, Self::YieldStrain];

    /// Returns the key of the factor in scenes.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::Density => "density_factor",
            Self::Strength => "strength_factor",
            Self::Damping => "damping_factor",
            Self::Friction => "friction_factor",
            Self::YieldStrain => "yield_factor",
        }
    }
}

/// The factors of each [`Quantity`]: one for each vertex of the lattice before the body broke. `None` where all are 1.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PartFactors([Option<Vec<f64>>; Quantity::ALL.len()]);

impl PartFactors {
    /// Returns the factors of a quantity.
    pub(crate) fn of(&self, quantity: Quantity) -> Option<&[f64]> {
        self.0[quantity as usize].as_deref()
    }

    /// Returns a function that returns the factor of a quantity at a vertex of a lattice, whole or broken; `None` if all
    /// are 1.
    pub(crate) fn on<'a>(
        &'a self,
        lattice: &'a Lattice,
        quantity: Quantity,
    ) -> Option<impl Fn(u32) -> f64 + 'a> {
        self.of(quantity).map(|factors| move |vertex| factors[lattice.source(vertex) as usize])
    }

    /// Sets the factors of a quantity.
    pub(crate) fn set(&mut self, quantity: Quantity, factors: Option<Vec<f64>>) {
        self.0[quantity as usize] = factors;
    }

    /// Checks the numbers of a lattice of `vertices` vertices. Returns a count that does not fit.
    ///
    /// # Errors
    ///
    /// A factor out of range.
    pub(crate) fn check(&self, vertices: usize) -> Result<Option<usize>, RangeError> {
        for (quantity, factors) in Quantity::ALL.into_iter().zip(&self.0) {
            for &factor in factors.iter().flatten() {
                Range::STIFFNESS_FACTOR.check(quantity.key(), factor)?;
            }
        }
        Ok(self.0.iter().flatten().map(Vec::len).find(|&count| count != vertices))
    }

    /// Returns the least factor of a quantity, at most 1.
    pub(crate) fn least(&self, quantity: Quantity) -> f64 {
        self.of(quantity).into_iter().flatten().copied().fold(1.0, f64::min)
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.0.iter().flatten().map(|list| size_of_val(list.as_slice())).sum()
    }
}
