//! Zones, and the factors with which the material varies over a body.

use super::selection::Selection;
use crate::motion::Curve;
use crate::range::{Range, RangeError};

/// Least factor in force. The sums of the factors of regions are in f32.
const LEAST: f64 = 1e-6;

/// A part of a body with another stiffness, rest volume, density or strength.
///
/// The part is a selection: the lattice vertices inside a shape, a list of vertices, a group or a map. Around a shape, the
/// logarithms of all factors decrease linearly to 0 over the length of a cell; a map is the share of them at each vertex,
/// so that a factor f counts as f^w at the weight w. Lists and groups have no border. The factors of overlapping zones
/// multiply.
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
}

impl Zone {
    /// Creates a zone.
    pub fn new(selection: Selection, factor: f64) -> Self {
        Self { selection, factor, inflate: None, density: 1.0, strength: 1.0 }
    }

    /// Returns the zone with another ratio of the rest volume.
    #[must_use]
    pub fn inflated(self, ratio: impl Into<Curve>) -> Self {
        Self { inflate: Some(ratio.into()), ..self }
    }
}

/// The factors that vary over a body, beside those of the stiffness: one for each vertex of the lattice before the body
/// broke. `None` where all are 1.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct PartFactors {
    pub(crate) density: Option<Vec<f64>>,
    pub(crate) strength: Option<Vec<f64>>,
}

impl PartFactors {
    /// Checks the numbers of a lattice of `vertices` vertices. Returns whether their count fits.
    ///
    /// # Errors
    ///
    /// A factor out of range.
    pub(crate) fn check(&self, vertices: usize) -> Result<bool, RangeError> {
        for (name, factors) in [("density factor", &self.density), ("strength factor", &self.strength)] {
            for &factor in factors.iter().flatten() {
                Range::STIFFNESS_FACTOR.check(name, factor)?;
            }
        }
        Ok([&self.density, &self.strength].into_iter().flatten().all(|factors| factors.len() == vertices))
    }

    /// Returns the least factor of the strength.
    pub(crate) fn least_strength(&self) -> f64 {
        self.strength.iter().flatten().copied().fold(f64::INFINITY, f64::min).min(1.0)
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        [&self.density, &self.strength].into_iter().flatten().map(|list| size_of_val(list.as_slice())).sum()
    }
}

/// The stiffness factor of the region around each vertex.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StiffnessFactors {
    /// Factors of Young's modulus.
    specified: Vec<f64>,
    /// Those divided by the factors of the density, with which alpha varies; `None` if the density does not.
    relative: Option<Vec<f64>>,
    least: f64,
    greatest: f64,
    /// Greatest factor in force: alpha times the factor of a region is at most the greatest alpha.
    limit: f64,
}

impl StiffnessFactors {
    /// Creates the factors from one factor of Young's modulus per lattice vertex, and one of the density.
    ///
    /// # Errors
    ///
    /// If a factor is not in (0, 100].
    pub(crate) fn new(
        specified: Vec<f64>,
        density: Option<impl Iterator<Item = f64>>,
    ) -> Result<Self, RangeError> {
        for &factor in &specified {
            Range::STIFFNESS_FACTOR.check("stiffness factor", factor)?;
        }
        let relative: Option<Vec<f64>> = density
            .map(|density| specified.iter().zip(density).map(|(factor, other)| factor / other).collect());
        let factors = relative.as_ref().unwrap_or(&specified);
        let least = factors.iter().copied().fold(f64::INFINITY, f64::min).max(LEAST);
        let greatest = factors.iter().copied().fold(LEAST, f64::max);
        Ok(Self { specified, relative, least, greatest, limit: greatest })
    }

    /// Returns the factors of Young's modulus that were specified.
    pub(crate) fn specified(&self) -> &[f64] {
        &self.specified
    }

    /// Returns the factors of alpha, without limits.
    pub(crate) fn relative(&self) -> &[f64] {
        self.relative.as_ref().unwrap_or(&self.specified)
    }

    /// Returns the factor in force of Young's modulus around a vertex.
    pub(crate) fn of_modulus(&self, vertex: u32) -> f64 {
        let specified = self.specified[vertex as usize];
        match self.relative.as_ref().map(|relative| relative[vertex as usize]) {
            None => specified.min(self.limit),
            Some(relative) if relative > self.limit => specified * (self.limit / relative),
            Some(_) => specified,
        }
    }

    /// Returns the greatest factor in force of Young's modulus.
    pub(crate) fn greatest_of_modulus(&self) -> f64 {
        match self.relative {
            None => self.limit,
            Some(_) => {
                (0..self.specified.len() as u32).map(|vertex| self.of_modulus(vertex)).fold(0.0, f64::max)
            }
        }
    }

    /// Transfers the factors to a lattice whose vertices were split: `parents` has the vertex before of each vertex.
    pub(crate) fn transfer(&mut self, parents: &[u32]) {
        let transferred = |list: &[f64]| parents.iter().map(|&parent| list[parent as usize]).collect();
        self.relative = self.relative.as_deref().map(transferred);
        self.specified = transferred(&self.specified);
    }

    /// Returns the least and the greatest factor of alpha, both at least 1e-6.
    pub(crate) fn range(&self) -> (f64, f64) {
        (self.least, self.greatest)
    }

    /// Limits the factors in force for a body with this `alpha`, and with this greatest one. Returns whether they
    /// change.
    pub(crate) fn limit(&mut self, alpha: f64, greatest_alpha: f64) -> bool {
        let limit = self.greatest.min(greatest_alpha / alpha);
        let changes = limit != self.limit;
        self.limit = limit;
        changes
    }

    /// Returns the greatest factor of alpha in force.
    pub(crate) fn greatest_in_force(&self) -> f64 {
        self.limit
    }

    /// Returns the factors of alpha in force.
    pub(crate) fn in_force(&self) -> Vec<f32> {
        self.limited(self.limit, 1.0)
    }

    /// Returns the factors of alpha that a limit leaves, as parts of that limit.
    pub(crate) fn parts_of(&self, limit: f64) -> Vec<f32> {
        self.limited(limit, limit)
    }

    fn limited(&self, limit: f64, unit: f64) -> Vec<f32> {
        self.relative().iter().map(|&factor| (factor.clamp(LEAST, limit) / unit) as f32).collect()
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.specified.as_slice())
            + self.relative.as_ref().map_or(0, |factors| size_of_val(factors.as_slice()))
    }
}
