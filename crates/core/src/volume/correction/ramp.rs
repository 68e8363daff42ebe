//! Fades the field out beside the lattice vertices that pins and handles constrain.

use std::sync::{Arc, Weak};

use super::{Correction, CorrectionWorkspace};
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
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.constrained) + size_of_val(&*self.factors)
    }

    /// Returns whether the ramp was built for this lattice.
    fn belongs_to(&self, adjacency: &Arc<Adjacency>) -> bool {
        self.adjacency.as_ptr() == Arc::as_ptr(adjacency)
    }
}

impl Correction {
    /// Sets the lattice vertices that pins and handles constrain.
    ///
    /// The correction does not move these vertices, and fades in beside them. The workspace keeps the
    /// constrained vertices until it is used for another lattice. Allocates only if the constrained vertices
    /// change.
    pub fn set_constrained(
        &self,
        workspace: &mut CorrectionWorkspace,
        constrained: impl Iterator<Item = u32> + Clone,
    ) {
        let ramp = self.ramp_of(&workspace.ramp);
        if !ramp.map_or(&[][..], |ramp| &ramp.constrained).iter().copied().eq(constrained.clone()) {
            let constrained: Vec<u32> = constrained.collect();
            workspace.ramp = (!constrained.is_empty()).then(|| Ramp {
                adjacency: Arc::downgrade(&self.adjacency),
                factors: external_forces::ramp(&self.adjacency, &constrained, self.ramp_links),
                constrained,
            });
        }
    }

    /// Returns the ramp of a workspace, if it was built for this lattice.
    pub(super) fn ramp_of<'w>(&self, ramp: &'w Option<Ramp>) -> Option<&'w Ramp> {
        ramp.as_ref().filter(|ramp| ramp.belongs_to(&self.adjacency))
    }
}
