//! The momentum tracker: conserves the momenta of free components against f32 rounding.
//!
//! The rounding error of g - x acts as a constant force that is integrated twice. An uncorrected body drifts,
//! and a body with only its drift removed starts to spin. So the linear and angular momentum of each
//! component without constraints and contacts are kept in f64 and changed by external impulses only. Each
//! step adds the rigid velocity that restores them.

mod sums;

pub(crate) use sums::{Fields, RigidVelocity, Sums, add};

use fearless_simd::dispatch;
use nalgebra::Vector3;

use crate::lattice::{Lattice, Layout};
use crate::parallel::Executor;
use crate::simd::lanes::{LANES, Lanes};
use crate::simd::level;
use crate::state::Momentum;
use sums::RigidState;

/// The connected component of each lattice vertex.
#[derive(Clone, Debug)]
pub(crate) enum Components {
    /// One component, which contains all vertices.
    One,
    /// The component of each slot.
    Several(Vec<u32>),
}

impl Components {
    /// The component of a slot.
    #[inline(always)]
    pub(crate) fn of(&self, slot: u32) -> usize {
        match self {
            Self::One => 0,
            Self::Several(of_slot) => of_slot[slot as usize] as usize,
        }
    }
}

/// The momentum tracker of a body, with the buffers of its sums.
#[derive(Clone, Debug)]
pub(crate) struct MomentumTracker {
    components: Components,
    /// Mass of each component, in units of a full cell's mass.
    masses: Vec<f64>,
    /// Sums of each component of each task, task by task.
    partial: Vec<Sums>,
    /// The last measurement of each component.
    states: Vec<RigidState>,
    corrections: Vec<RigidVelocity>,
    /// Whether each component has a constrained vertex; its momenta are then not conserved.
    constrained: Vec<bool>,
}

impl MomentumTracker {
    /// Creates the tracker for a lattice stored by `layout`, with `tasks` tasks in a step.
    pub(crate) fn new(lattice: &Lattice, layout: &Layout, tasks: usize) -> Self {
        let count = lattice.components().count;
        let mut masses = vec![0.0; count];
        for (&component, &cells) in lattice.components().of_vertex.iter().zip(lattice.occupied_cells()) {
            masses[component as usize] += f64::from(cells) / 8.0;
        }
        let components = if count == 1 {
            Components::One
        } else {
            let mut of_slot = vec![0; layout.blocks() * LANES];
            for (&slot, &component) in layout.slots().iter().zip(&lattice.components().of_vertex) {
                of_slot[slot as usize] = component;
            }
            Components::Several(of_slot)
        };
        Self {
            components,
            partial: vec![Sums::default(); count * tasks],
            states: masses.iter().map(|&mass| Sums::default().rigid_state(mass)).collect(),
            masses,
            corrections: vec![RigidVelocity::default(); count],
            constrained: vec![false; count],
        }
    }

    /// Invalidates the momenta of the components with a constrained vertex.
    ///
    /// `held` is whether each lattice vertex is constrained.
    pub(crate) fn set_constrained(&mut self, slots: &[u32], held: &[bool], momenta: &mut [Option<Momentum>]) {
        self.constrained.fill(false);
        for (&slot, _) in slots.iter().zip(held).filter(|(_, held)| **held) {
            self.constrained[self.components.of(slot)] = true;
        }
        for (momentum, _) in
            momenta.iter_mut().zip(&self.constrained).filter(|(_, constrained)| **constrained)
        {
            *momentum = None;
        }
    }

    /// Marks all components as unconstrained.
    pub(crate) fn clear_constrained(&mut self) {
        self.constrained.fill(false);
    }

    /// Whether the momenta of any unconstrained component are invalid.
    pub(crate) fn any_invalidated(&self, momenta: &[Option<Momentum>]) -> bool {
        momenta
            .iter()
            .zip(&self.constrained)
            .any(|(momentum, constrained)| momentum.is_none() && !constrained)
    }

    /// Sets the invalid momenta of unconstrained components from the last measurement.
    pub(crate) fn store_measured(&self, momenta: &mut [Option<Momentum>]) {
        for ((momentum, state), constrained) in momenta.iter_mut().zip(&self.states).zip(&self.constrained) {
            if momentum.is_none() && !constrained {
                *momentum = Some(state.momentum);
            }
        }
    }

    /// Measures mass, center and momenta of each component.
    ///
    /// `bounds` is the first block of each task, then the number of blocks.
    pub(crate) fn measure(
        &mut self,
        executor: &Executor,
        bounds: &[usize],
        weights: &Lanes<2>,
        positions: &Lanes<3>,
        velocities: &Lanes<3>,
    ) {
        let (components, partial) = self.begin_sums();
        executor.tasks(bounds, (&mut [], &mut [], partial), |task, _: &mut [()], _: &mut [()], sums| {
            let blocks = bounds[task]..bounds[task + 1];
            let fields = Fields {
                weights: &weights.blocks()[blocks.clone()],
                positions: &positions.blocks()[blocks.clone()],
                velocities: &velocities.blocks()[blocks.clone()],
            };
            dispatch!(level(), simd => add(simd, components, blocks.start, fields, sums));
        });
        self.finish_sums();
    }

    /// Sets the sums to zero and returns them: one for each component of each task.
    pub(crate) fn begin_sums(&mut self) -> (&Components, &mut [Sums]) {
        self.partial.fill(Sums::default());
        (&self.components, &mut self.partial)
    }

    /// Computes mass, center and momenta of each component from the sums of the tasks.
    pub(crate) fn finish_sums(&mut self) {
        let count = self.states.len();
        for (component, state) in self.states.iter_mut().enumerate() {
            let mut total = Sums::default();
            for sums in self.partial.iter().skip(component).step_by(count) {
                total.add(sums);
            }
            *state = total.rigid_state(self.masses[component]);
        }
    }

    /// Adds the impulse of a velocity change `gain` of all vertices, in cells/s.
    pub(crate) fn add_impulse(&self, momenta: &mut [Option<Momentum>], gain: Vector3<f64>) {
        for (momentum, mass) in momenta.iter_mut().zip(&self.masses) {
            if let Some(momentum) = momentum {
                momentum.linear = (Vector3::from(momentum.linear) + gain * *mass).into();
            }
        }
    }

    /// The kinetic energy of the rigid part of the motion at the last measurement, in full cells times
    /// (cells/s)².
    pub(crate) fn rigid_energy(&self) -> f64 {
        self.states.iter().map(RigidState::rigid_energy).sum()
    }

    /// Scales the measured momenta after the velocities were scaled by `scale`.
    pub(crate) fn scale(&mut self, scale: f64) {
        for momentum in self.states.iter_mut().map(|state| &mut state.momentum) {
            momentum.linear = momentum.linear.map(|p| p * scale);
            momentum.angular = momentum.angular.map(|l| l * scale);
        }
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let of_slots = match &self.components {
            Components::One => 0,
            Components::Several(of_slot) => size_of_val(of_slot.as_slice()),
        };
        let of_components = size_of_val(self.masses.as_slice())
            + size_of_val(self.states.as_slice())
            + size_of_val(self.corrections.as_slice())
            + self.constrained.len();
        of_slots + size_of_val(self.partial.as_slice()) + of_components
    }

    /// Whether any component is unconstrained.
    pub(crate) fn any_free(&self) -> bool {
        self.constrained.contains(&false)
    }

    /// The center of mass of the body at the last measurement, in cells from the body's origin.
    pub(crate) fn center(&self) -> Vector3<f64> {
        self.states.iter().map(|state| state.center * state.mass).sum::<Vector3<f64>>() / self.mass()
    }

    /// The velocity of the center of mass at the last measurement, in cells/s.
    pub(crate) fn velocity(&self) -> Vector3<f64> {
        self.states.iter().map(|state| Vector3::from(state.momentum.linear)).sum::<Vector3<f64>>()
            / self.mass()
    }

    fn mass(&self) -> f64 {
        self.states.iter().map(|state| state.mass).sum()
    }

    /// Computes the rigid velocity of each component that changes its measured momenta to `momenta`. It is
    /// zero where `momenta` has `None`.
    pub(crate) fn corrections(&mut self, momenta: &[Option<Momentum>]) -> (&Components, &[RigidVelocity]) {
        for ((state, momentum), correction) in self.states.iter().zip(momenta).zip(&mut self.corrections) {
            *correction = momentum.map_or_else(RigidVelocity::default, |target| state.correction_to(target));
        }
        (&self.components, &self.corrections)
    }
}
