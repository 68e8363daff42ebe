//! What was measured of one case.

use std::collections::BTreeMap;

use super::Measure;
use super::trial::largest;

/// The figures of one case.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Figures {
    /// Steps that were made.
    pub steps: u64,
    /// What was measured; what is not there was not.
    pub values: BTreeMap<Measure, f64>,
    /// Step and energy at each look, of a case whose energy is known: kinetic, of deformation and of gravity, in masses
    /// of a full cell times (cells per step)².
    pub energy: Vec<(u64, f64)>,
}

impl Figures {
    /// One figure.
    pub fn get(&self, measure: Measure) -> Option<f64> {
        self.values.get(&measure).copied()
    }

    pub(crate) fn set(&mut self, measure: Measure, value: f64) {
        self.values.insert(measure, value);
    }

    /// Keeps the larger one; what is not a number is larger than any.
    pub(crate) fn raise(&mut self, measure: Measure, value: f64) {
        let kept = self.values.entry(measure).or_insert(value);
        *kept = largest(*kept, value);
    }

    pub(crate) fn add(&mut self, measure: Measure, value: f64) {
        *self.values.entry(measure).or_insert(0.0) += value;
    }
}
