//! Forces that a user applies for one step.

use std::ops::AddAssign;

use nalgebra::Vector3;

use super::{Body, RangeError, in_range};
use crate::dynamics::Selection;
use crate::error::Error;

/// Forces for the next step, and what those since the frame began come to: lists in increasing order of lattice
/// vertex, each once.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Forces {
    /// In scene units of mass x length / s^2.
    next: Vec<(u32, [f64; 3])>,
    /// For the volume correction, in cells: the velocity change times the step.
    pushes: Vec<(u32, [f32; 3])>,
}

impl Forces {
    /// Whether all are of a lattice of so many vertices, as those read from a file may not be.
    pub(crate) fn is_whole(&self, vertices: usize) -> bool {
        let inside = |vertex: u32| (vertex as usize) < vertices;
        self.next.iter().all(|&(vertex, _)| inside(vertex))
            && self.pushes.iter().all(|&(vertex, _)| inside(vertex))
    }
}

/// Adds up what a list sorted by vertex has for the same one.
fn add_up<T: Copy + AddAssign>(list: &mut Vec<(u32, [T; 3])>) {
    list.dedup_by(|(vertex, more), (before, sum)| {
        let same = vertex == before;
        if same {
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += *more);
        }
        same
    });
}

impl Body {
    /// Pulls at a part of the body in the next step, with a force shared by its lattice vertices by mass. Forces add
    /// up.
    ///
    /// * `force`: the whole force, kg x length / s^2.
    ///
    /// # Errors
    ///
    /// A number that is not finite, or that accelerates by more than 10^15 cells/s^2, or a selection that takes nothing.
    pub fn apply_force(&mut self, force: [f64; 3], selection: &Selection) -> Result<(), Error> {
        let vertices = self.select(selection)?;
        let whole: f64 = vertices.iter().map(|&vertex| self.mass(vertex)).sum();
        let share = |vertex: u32| force.map(|f| f * (self.mass(vertex) / whole));
        let shares: Vec<_> = vertices.iter().map(|&vertex| (vertex, share(vertex))).collect();
        Ok(self.apply_forces(&shares)?)
    }

    /// Pulls at single lattice vertices in the next step: pairs of vertex and force, kg x length / s^2. Forces add up.
    ///
    /// # Errors
    ///
    /// A number that is not finite, or that accelerates its vertex by more than 10^15 cells/s^2; nothing is applied then.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    pub fn apply_forces(&mut self, forces: &[(u32, [f64; 3])]) -> Result<(), RangeError> {
        let count = self.lattice.len();
        for &(vertex, force) in forces {
            assert!((vertex as usize) < count, "vertex {vertex} of {count}");
            let limit = self.farthest() * self.mass(vertex);
            for f in force {
                in_range("force", f, f.abs() <= limit, "finite, and accelerate by at most 1e15 cells/s^2")?;
            }
        }
        let next = &mut self.forces.get_or_insert_default().next;
        next.extend_from_slice(forces);
        next.sort_by_key(|&(vertex, _)| vertex);
        add_up(next);
        Ok(())
    }

    /// What forces did to lattice vertices since the frame began: pairs of vertex and push in cells.
    pub(super) fn forced(&self) -> impl Iterator<Item = (u32, [f32; 3])> {
        self.forces.iter().flat_map(|forces| forces.pushes.iter().copied())
    }

    /// v += dt f/m. The momenta that this gives are measured, not booked.
    pub(super) fn pull(&mut self, dt: f64, opens_frame: bool) {
        let Some(mut forces) = self.forces.take() else { return };
        if opens_frame {
            forces.pushes.clear();
        }
        let pulls = !forces.next.is_empty();
        for (vertex, force) in forces.next.drain(..) {
            let gain = Vector3::from(force) * (dt / (self.mass(vertex) * self.lattice.cell_size()));
            let slot = self.matching.layout.slots()[vertex as usize];
            let mut state = self.state.shared();
            state.set_velocity(slot, state.velocity(slot) + gain);
            self.state.shut_book(&self.lattice, vertex);
            forces.pushes.push((vertex, (gain * dt).map(|push| push as f32).into()));
        }
        if pulls {
            // Two at most for each vertex, whose order does not matter: sorted without an allocation.
            forces.pushes.sort_unstable_by_key(|&(vertex, _)| vertex);
            add_up(&mut forces.pushes);
        }
        self.forces = Some(forces);
    }
}
