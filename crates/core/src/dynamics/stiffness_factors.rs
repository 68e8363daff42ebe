//! Stiffness factors, with which the stiffness varies over a body.

use super::selection::Selection;
use crate::motion::Curve;
use crate::range::{Range, RangeError};

/// Least factor in force. The sums of the factors of regions are in f32.
const LEAST: f64 = 1e-6;

/// A part of a body with another stiffness or rest volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// The part: the lattice vertices inside the shape, or a list of lattice vertices. Around a shape, the logarithm of
    /// the factor decreases linearly to 0 over the length of a cell. A list has no such border.
    pub selection: Selection,
    /// Factor of Young's modulus, in (0, 100]. Factors of overlapping zones multiply; the products have the same range.
    pub factor: f64,
    /// Ratio of the rest volume of the part to its volume in the mesh, in [0.1, 10], over time; default 1. It
    /// multiplies the ratios of the body and of overlapping zones; the products are limited to the same range. The
    /// logarithm of the ratio has the border of the factor.
    pub inflate: Option<Curve>,
}

impl Zone {
    /// Creates a zone.
    pub fn new(selection: Selection, factor: f64) -> Self {
        Self { selection, factor, inflate: None }
    }

    /// Returns the zone with another ratio of the rest volume.
    #[must_use]
    pub fn inflated(self, ratio: impl Into<Curve>) -> Self {
        Self { inflate: Some(ratio.into()), ..self }
    }
}

/// The stiffness factor of the region around each lattice vertex.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StiffnessFactors {
    specified: Vec<f64>,
    least: f64,
    greatest: f64,
    /// Greatest factor in force: alpha times the factor of a region is at most the greatest alpha.
    limit: f64,
}

impl StiffnessFactors {
    /// Creates the factors from one factor per lattice vertex.
    ///
    /// # Errors
    ///
    /// If a factor is not in (0, 100].
    pub(crate) fn new(specified: Vec<f64>) -> Result<Self, RangeError> {
        for &factor in &specified {
            Range::STIFFNESS_FACTOR.check("stiffness factor", factor)?;
        }
        let least = specified.iter().copied().fold(f64::INFINITY, f64::min).max(LEAST);
        let greatest = specified.iter().copied().fold(LEAST, f64::max);
        Ok(Self { specified, least, greatest, limit: greatest })
    }

    /// Returns the factors that were specified.
    pub(crate) fn specified(&self) -> &[f64] {
        &self.specified
    }

    /// Transfers the factors to a lattice whose vertices were split: `parents` has the vertex before of each vertex.
    pub(crate) fn transfer(&mut self, parents: &[u32]) {
        self.specified = parents.iter().map(|&parent| self.specified[parent as usize]).collect();
    }

    /// Returns the least and the greatest specified factor, both at least 1e-6.
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

    /// Returns the greatest factor in force.
    pub(crate) fn greatest_in_force(&self) -> f64 {
        self.limit
    }

    /// Returns the factors in force, divided by `unit`.
    pub(crate) fn in_force(&self, unit: f64) -> Vec<f32> {
        self.specified.iter().map(|&factor| (factor.clamp(LEAST, self.limit) / unit) as f32).collect()
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.specified.as_slice())
    }
}
