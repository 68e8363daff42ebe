//! Fades the field out beside the lattice vertices that pins and handles constrain.

use std::sync::{Arc, Weak};

use crate::volume::adjacency::Adjacency;

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
    /// Creates the ramp beside constrained vertices. The factor is 0 at a constrained vertex, and 1 at vertices that
    /// are `links` or more links away from all of them, with `links` > 0. In between it rises smoothly, which avoids a
    /// crease beside a pin.
    pub(super) fn new(adjacency: &Arc<Adjacency>, constrained: Vec<u32>, links: u32) -> Self {
        let factor = |distance: u32| {
            let t = f64::from(distance.min(links)) / f64::from(links);
            (t * t * (3.0 - 2.0 * t)) as f32
        };
        let distances = adjacency.distances(constrained.iter().map(|&i| i as usize));
        let factors = distances.into_iter().map(factor).collect();
        Self { adjacency: Arc::downgrade(adjacency), factors, constrained }
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
