//! External forces on lattice vertices, applied for one step.

use std::ops::AddAssign;

use nalgebra::Vector3;

use crate::lattice::Lattice;
use crate::state::{Interval, State};

/// The external-force stage: forces of the next step, and the displacements by the forces of the current
/// frame. Both lists are sorted by lattice vertex, without duplicates.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Forces {
    /// Forces of the next step, in scene units of mass x length / s^2.
    next: Vec<(u32, [f64; 3])>,
    /// Velocity change times dt, in cells: f of Eq. (2) in `volume::external_forces`.
    displacements: Vec<(u32, [f32; 3])>,
}

impl Forces {
    /// Adds forces on lattice vertices to the forces of the next step.
    pub(crate) fn add(&mut self, forces: &[(u32, [f64; 3])]) {
        self.next.extend_from_slice(forces);
        self.next.sort_by_key(|&(vertex, _)| vertex);
        sum_duplicates(&mut self.next);
    }

    /// Applies the forces: v += h f/m. Invalidates the momenta of the components that they act on.
    pub(crate) fn apply(
        &mut self,
        (step, is_frame_start): (Interval, bool),
        (lattice, slots): (&Lattice, &[u32]),
        mass: impl Fn(u32) -> f64,
        state: &mut State,
    ) {
        if is_frame_start {
            self.displacements.clear();
        }
        if self.next.is_empty() {
            return;
        }
        for (vertex, force) in self.next.drain(..) {
            let gain = Vector3::from(force) * (step.dt / (mass(vertex) * lattice.cell_size()));
            let slot = slots[vertex as usize];
            let mut shared = state.shared();
            shared.set_velocity(slot, shared.velocity(slot) + gain);
            state.invalidate_momentum(lattice, vertex);
            self.displacements.push((vertex, (gain * step.dt).map(|push| push as f32).into()));
        }
        // A vertex has at most two entries, so their order does not matter. An unstable sort does not
        // allocate.
        self.displacements.sort_unstable_by_key(|&(vertex, _)| vertex);
        sum_duplicates(&mut self.displacements);
    }

    /// The displacements by the forces of the current frame: pairs of lattice vertex and velocity change
    /// times dt, in cells.
    pub(crate) fn displacements(&self) -> impl Iterator<Item = (u32, [f32; 3])> {
        self.displacements.iter().copied()
    }

    /// Whether there are neither forces nor displacements.
    pub(crate) fn is_empty(&self) -> bool {
        self.next.is_empty() && self.displacements.is_empty()
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.next.capacity() * size_of::<(u32, [f64; 3])>()
            + self.displacements.capacity() * size_of::<(u32, [f32; 3])>()
    }

    /// Checks deserialized data: whether all indices fit a lattice of `vertices` vertices.
    pub(crate) fn is_valid(&self, vertices: usize) -> bool {
        let in_range = |vertex: u32| (vertex as usize) < vertices;
        self.next.iter().all(|&(vertex, _)| in_range(vertex))
            && self.displacements.iter().all(|&(vertex, _)| in_range(vertex))
    }
}

/// Replaces the entries of each vertex by their sum; `list` is sorted by vertex.
fn sum_duplicates<T: Copy + AddAssign>(list: &mut Vec<(u32, [T; 3])>) {
    list.dedup_by(|(vertex, value), (previous, sum)| {
        let same = vertex == previous;
        if same {
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += *value);
        }
        same
    });
}
