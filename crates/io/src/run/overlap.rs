//! Bodies that overlap at the start, for warnings.

use std::fmt;

use super::deviation::four_digits;
use crate::escape::Escaped;
use supple::Simulation;

/// Two bodies that overlap at the start of a simulation and can touch each other.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Overlap {
    /// Names of the bodies.
    pub bodies: [String; 2],
    /// Greatest depth at which the surface of one is inside the other, in scene units.
    pub depth: f64,
}

impl Overlap {
    /// Returns the bodies that overlap at the current positions by more than a tenth of a cell.
    pub fn all(simulation: &mut Simulation) -> Vec<Self> {
        let overlaps = simulation.overlapping_bodies();
        let name = |index: usize| simulation.bodies()[index].name().to_owned();
        overlaps.into_iter().map(|(a, b, depth)| Self { bodies: [name(a), name(b)], depth }).collect()
    }
}

impl fmt::Display for Overlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.bodies.each_ref().map(Escaped);
        write!(
            f,
            "the bodies {a} and {b} overlap at the start, up to {} deep; the first steps push them apart; move one of \
             them, or let them pass through each other: `ignore = [\"{b}\"]` of {a}",
            four_digits(self.depth)
        )
    }
}
