//! The accelerations that fields give the vertices of a body.

use nalgebra::Vector3;

use crate::lattice::Lattice;
use crate::state::{Interval, State};

/// Accelerations by fields, of each lattice vertex in scene units; empty without fields.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(in crate::dynamics) struct FieldAccelerations {
    /// In the next step.
    pub(in crate::dynamics) next: Vec<[f64; 3]>,
    /// In the last step in which the body was not at rest.
    pub(in crate::dynamics) at_rest: Vec<[f64; 3]>,
}

impl FieldAccelerations {
    /// Returns whether the acceleration of a vertex differs from that with which the body came to rest. `matters` returns
    /// whether a difference counts.
    pub(in crate::dynamics) fn differ(&self, matters: impl Fn(u32, f64) -> bool) -> bool {
        let count = self.next.len().max(self.at_rest.len());
        let at =
            |list: &[[f64; 3]], vertex: usize| Vector3::from(list.get(vertex).copied().unwrap_or_default());
        (0..count).any(|vertex| {
            let change = at(&self.next, vertex) - at(&self.at_rest, vertex);
            matters(vertex as u32, change.norm())
        })
    }

    /// Applies the accelerations a of a step: see [`State::accelerate`].
    pub(in crate::dynamics) fn apply(
        &self,
        step: Interval,
        (lattice, slots): (&Lattice, &[u32]),
        state: &mut State,
    ) {
        let factor = step.dt / lattice.cell_size();
        for (vertex, acceleration) in (0..).zip(&self.next) {
            if *acceleration != [0.0; 3] {
                state.accelerate((lattice, slots), vertex, Vector3::from(*acceleration) * factor, step.dt);
            }
        }
    }

    /// Transfers the accelerations to a lattice whose vertices were split: pairs of a vertex and a vertex before.
    pub(in crate::dynamics) fn transfer(&mut self, pairs: &[(u32, u32)]) {
        let count = pairs.iter().map(|&(vertex, _)| vertex as usize + 1).max().unwrap_or_default();
        for list in [&mut self.next, &mut self.at_rest].into_iter().filter(|list| !list.is_empty()) {
            let mut transferred = vec![[0.0; 3]; count];
            pairs.iter().for_each(|&(vertex, before)| transferred[vertex as usize] = list[before as usize]);
            *list = transferred;
        }
    }

    pub(in crate::dynamics) fn is_empty(&self) -> bool {
        self.next.is_empty() && self.at_rest.is_empty()
    }

    pub(in crate::dynamics) fn bytes(&self) -> usize {
        (self.next.capacity() + self.at_rest.capacity()) * size_of::<[f64; 3]>()
    }

    /// Checks deserialized data.
    pub(in crate::dynamics) fn is_valid(&self, vertices: usize) -> bool {
        [&self.next, &self.at_rest].iter().all(|list| list.is_empty() || list.len() == vertices)
    }
}
