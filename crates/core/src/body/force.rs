//! Forces that a user applies for one step.

use nalgebra::Vector3;

use super::{Body, RangeError, in_range};
use crate::dynamics::Selection;
use crate::error::Error;

/// Forces for the next step, and what those since the frame began come to.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "scene", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Forces {
    /// One per lattice vertex, in scene units of mass x length / s^2; empty when none is due.
    next: Vec<[f64; 3]>,
    /// For the volume correction, one per lattice vertex, in cells: the velocity change times the step.
    pushes: Vec<[f32; 3]>,
}

impl Forces {
    /// Whether all arrays are of so many lattice vertices, or empty.
    #[cfg(feature = "scene")]
    pub(crate) fn is_whole(&self, vertices: usize) -> bool {
        [self.next.len(), self.pushes.len()].into_iter().all(|length| length == 0 || length == vertices)
    }
}

impl Body {
    /// Pulls at a part of the body in the next step, with a force shared by its lattice vertices by mass. Forces add
    /// up.
    ///
    /// * `force`: the whole force, kg x length / s^2.
    ///
    /// # Errors
    ///
    /// A number that is not finite, or a selection that takes nothing.
    pub fn apply_force(&mut self, force: [f64; 3], selection: &Selection) -> Result<(), Error> {
        let vertices = self.select(selection)?;
        let masses = self.masses();
        let whole: f64 = vertices.iter().map(|&vertex| masses[vertex as usize]).sum();
        let share = |vertex: u32| force.map(|f| f * (masses[vertex as usize] / whole));
        let shares: Vec<_> = vertices.iter().map(|&vertex| (vertex, share(vertex))).collect();
        Ok(self.apply_forces(&shares)?)
    }

    /// Pulls at single lattice vertices in the next step: pairs of vertex and force, kg x length / s^2. Forces add up.
    ///
    /// # Errors
    ///
    /// A number that is not finite; nothing is applied then.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    pub fn apply_forces(&mut self, forces: &[(u32, [f64; 3])]) -> Result<(), RangeError> {
        for f in forces.iter().flat_map(|(_, force)| force) {
            in_range("force", *f, true, "finite")?;
        }
        let own = self.forces.get_or_insert_default();
        own.next.resize(self.lattice.len(), [0.0; 3]);
        for (vertex, force) in forces {
            let sum = &mut own.next[*vertex as usize];
            *sum = std::array::from_fn(|c| sum[c] + force[c]);
        }
        Ok(())
    }

    /// What forces did to lattice vertices since the frame began: pairs of vertex and push in cells.
    pub(super) fn forced(&self) -> impl Iterator<Item = (u32, [f32; 3])> {
        let pushes = self.forces.iter().flat_map(|forces| &forces.pushes);
        (0..).zip(pushes.copied()).filter(|(_, push)| *push != [0.0; 3])
    }

    /// v += dt f/m. The momenta that this gives are measured, not booked.
    pub(super) fn pull(&mut self, dt: f64, opens_frame: bool) {
        let (cell, cell_size) = (self.cell_mass(), self.lattice.cell_size());
        let Some(forces) = &mut self.forces else { return };
        if opens_frame {
            forces.pushes.clear();
        }
        if forces.next.is_empty() {
            return;
        }
        forces.pushes.resize(forces.next.len(), [0.0; 3]);
        let slots = self.matching.layout.slots();
        for (vertex, force) in forces.next.iter().enumerate().filter(|(_, force)| **force != [0.0; 3]) {
            let mass = cell * f64::from(self.lattice.occupied_cells()[vertex]) / 8.0;
            let gain = Vector3::from(*force) * (dt / (mass * cell_size));
            let velocity = Vector3::from(self.state.velocities.get(slots[vertex]).map(f64::from)) + gain;
            self.state.velocities.set(slots[vertex], velocity.map(|v| v as f32).into());
            let push = &mut forces.pushes[vertex];
            *push = std::array::from_fn(|c| push[c] + (gain[c] * dt) as f32);
        }
        forces.next.clear();
        self.state.books.fill(None);
    }
}
