//! The factors with which the stiffness varies over a body.

use crate::range::{Range, RangeError};

/// Least factor in force. The sums of the factors of regions are in f32.
const LEAST: f64 = 1e-6;

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
