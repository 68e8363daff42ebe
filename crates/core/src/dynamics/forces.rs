//! Forces that a user applies for one step.

use std::ops::AddAssign;

use nalgebra::Vector3;

use crate::lattice::Lattice;
use crate::state::{Interval, State};

/// The stage: forces for the next step, and the pushes of those since the frame began. Both are lists in increasing
/// order of lattice vertex, each once.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Forces {
    /// In scene units of mass x length / s^2.
    next: Vec<(u32, [f64; 3])>,
    /// For the volume correction, in cells: the velocity change times the step.
    pushes: Vec<(u32, [f32; 3])>,
}

impl Forces {
    /// Adds forces on lattice vertices to those of the next step.
    pub(crate) fn add(&mut self, forces: &[(u32, [f64; 3])]) {
        self.next.extend_from_slice(forces);
        self.next.sort_by_key(|&(vertex, _)| vertex);
        add_up(&mut self.next);
    }

    /// v += h f/m. The momenta of the components that forces act on are measured anew.
    pub(crate) fn apply(
        &mut self,
        (step, opens_frame): (Interval, bool),
        (lattice, slots): (&Lattice, &[u32]),
        mass: impl Fn(u32) -> f64,
        state: &mut State,
    ) {
        if opens_frame {
            self.pushes.clear();
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
            self.pushes.push((vertex, (gain * step.dt).map(|push| push as f32).into()));
        }
        // At most two for each vertex, so their order does not matter: sorted without an allocation.
        self.pushes.sort_unstable_by_key(|&(vertex, _)| vertex);
        add_up(&mut self.pushes);
    }

    /// What forces did to lattice vertices since the frame began: pairs of vertex and push in cells.
    pub(crate) fn pushes(&self) -> impl Iterator<Item = (u32, [f32; 3])> {
        self.pushes.iter().copied()
    }

    /// Whether there are neither forces nor pushes.
    pub(crate) fn is_empty(&self) -> bool {
        self.next.is_empty() && self.pushes.is_empty()
    }

    /// Memory that they take.
    pub(crate) fn bytes(&self) -> usize {
        self.next.capacity() * size_of::<(u32, [f64; 3])>()
            + self.pushes.capacity() * size_of::<(u32, [f32; 3])>()
    }

    /// Whether all are of a lattice of `vertices` vertices: deserialised data may not be.
    pub(crate) fn is_whole(&self, vertices: usize) -> bool {
        let inside = |vertex: u32| (vertex as usize) < vertices;
        self.next.iter().all(|&(vertex, _)| inside(vertex))
            && self.pushes.iter().all(|&(vertex, _)| inside(vertex))
    }
}

/// Adds up the entries of each vertex in a list that is sorted by vertex.
fn add_up<T: Copy + AddAssign>(list: &mut Vec<(u32, [T; 3])>) {
    list.dedup_by(|(vertex, more), (before, sum)| {
        let same = vertex == before;
        if same {
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += *more);
        }
        same
    });
}
