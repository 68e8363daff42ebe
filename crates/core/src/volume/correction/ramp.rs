//! Fades the field out beside the lattice vertices that pins and handles constrain.

use std::sync::{Arc, Weak};

use crate::volume::adjacency::Adjacency;
use crate::volume::external_forces;

/// Factors by which the field fades in beside constrained vertices.
#[derive(Clone, Debug)]
pub(super) struct Ramp {
    /// Identifies the lattice for which the ramp was built.
    adjacency: Weak<Adjacency>,
    /// Constrained vertices.
    pub(super) constrained: Vec<u32>,
    /// Factor of each vertex, in [0, 1].
    pub(super) factors: Vec<f32>,
}

impl Ramp {
    /// Creates the ramp beside constrained vertices. It is `links` links long.
    pub(super) fn new(adjacency: &Arc<Adjacency>, constrained: Vec<u32>, links: u32) -> Self {
        Self {
            adjacency: Arc::downgrade(adjacency),
            factors: external_forces::ramp(adjacency, &constrained, links),
            constrained,
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.constrained) + size_of_val(&*self.factors)
    }

    /// Returns whether the ramp was built for this lattice.
    pub(super) fn belongs_to(&self, adjacency: &Arc<Adjacency>) -> bool {
        self.adjacency.as_ptr() == Arc::as_ptr(adjacency)
    }
}
