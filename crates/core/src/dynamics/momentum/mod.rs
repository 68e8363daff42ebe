//! Tracks the momenta of connected components of the lattice, and corrects their change by f32 rounding.
//!
//! The rounding error of g - x, the distance of a vertex to its goal position, acts as a constant force that
//! is integrated twice. Without a correction, a body drifts; if only the drift is corrected, the body starts
//! to spin. So the linear and the angular momentum of each component without constraints and contacts are
//! stored in f64, and only external impulses change them. Each step adds to the component the rigid velocity
//! that restores the stored momenta.
//!
//! A slot is the index of a vertex in the storage order ([`Lanes`]).

mod components;
mod projection;
mod rigid;
mod sums;

pub(crate) use components::Components;
pub(super) use projection::{Mobility, Projection, SOFTNESS};
pub(super) use rigid::RigidVelocity;
pub(super) use sums::{Fields, RigidState, Sums, add};

use fearless_simd::dispatch;
use nalgebra::Vector3;

use crate::lattice::{Lattice, Layout};
use crate::matching::Matching;
use crate::parallel::Executor;
use crate::simd::lanes::{LANES, Lanes};
use crate::simd::level;
use crate::state::{Momentum, State};

/// The momentum tracker of a body.
#[derive(Clone, Debug)]
pub(crate) struct MomentumTracker {
    components: Components,
    /// Mass of each component, in units of a full cell's mass.
    masses: Vec<f64>,
    /// Sums of each component over the vertices of each task, task by task.
    task_sums: Vec<Sums>,
    /// Last measured rigid state of each component.
    states: Vec<RigidState>,
    /// Whether the last measurement is of the positions and velocities at the start of the present step.
    pub(crate) is_measured: bool,
    /// Rigid velocity of each component that corrects its momenta.
    corrections: Vec<RigidVelocity>,
    /// Whether each component has a constrained vertex, so that its momenta are not conserved.
    constrained: Vec<bool>,
}

impl MomentumTracker {
    /// Creates the tracker for a lattice in the storage order `layout`. A step has `tasks` tasks. `vertex_masses` has
    /// the mass of each vertex in units of a full cell's mass.
    pub(crate) fn new(lattice: &Lattice, vertex_masses: &[f32], layout: &Layout, tasks: usize) -> Self {
        let count = lattice.components().count;
        let mut masses = vec![0.0; count];
        for (&component, &mass) in lattice.components().of_vertex.iter().zip(vertex_masses) {
            masses[component as usize] += f64::from(mass);
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
            task_sums: vec![Sums::default(); count * tasks],
            states: masses.iter().map(|&mass| Sums::default().rigid_state(mass)).collect(),
            masses,
            is_measured: false,
            corrections: vec![RigidVelocity::default(); count],
            constrained: vec![false; count],
        }
    }

    /// Sets the masses of the components from the masses of the vertices in the fits of the regions, or in the damping.
    pub(crate) fn set_masses(&mut self, slots: &[u32], vertex_masses: impl Iterator<Item = f32>) {
        self.masses.fill(0.0);
        for (&slot, mass) in slots.iter().zip(vertex_masses) {
            self.masses[self.components.of_slot(slot)] += f64::from(mass);
        }
    }

    /// Sets which components have a constrained vertex, and invalidates the momenta of these components.
    ///
    /// `slots` has the slot of each lattice vertex, and `is_constrained` whether the vertex is constrained; it is empty if
    /// none is.
    pub(crate) fn set_constrained(
        &mut self,
        slots: &[u32],
        is_constrained: &[bool],
        momenta: &mut [Option<Momentum>],
    ) {
        self.constrained.fill(false);
        for (&slot, _) in slots.iter().zip(is_constrained).filter(|(_, constrained)| **constrained) {
            self.constrained[self.components.of_slot(slot)] = true;
        }
        let of_components = momenta.iter_mut().zip(&self.constrained);
        of_components.filter(|(_, constrained)| **constrained).for_each(|(momentum, _)| *momentum = None);
    }

    /// Returns whether a component has a constrained vertex.
    pub(crate) fn is_constrained(&self, component: usize) -> bool {
        self.constrained[component]
    }

    /// Returns whether the momenta of any unconstrained component are invalidated (`None`).
    pub(crate) fn any_invalidated(&self, momenta: &[Option<Momentum>]) -> bool {
        momenta
            .iter()
            .zip(&self.constrained)
            .any(|(momentum, constrained)| momentum.is_none() && !constrained)
    }

    /// Replaces invalidated momenta of unconstrained components by the momenta of the last measurement.
    pub(crate) fn store_measured(&self, momenta: &mut [Option<Momentum>]) {
        for ((momentum, state), constrained) in momenta.iter_mut().zip(&self.states).zip(&self.constrained) {
            if momentum.is_none() && !constrained {
                *momentum = Some(state.momentum);
            }
        }
    }

    /// Measures the center of mass, the momenta and the inertia of each component of a body.
    pub(crate) fn measure(&mut self, (matching, state): (&Matching, &State), executor: &Executor) {
        let (task_blocks, weights) = (matching.cascade.task_blocks(), &matching.regions.weights);
        self.measure_fields(executor, task_blocks, weights, &state.positions, &state.velocities);
    }

    /// As [`measure`](Self::measure), of any fields.
    ///
    /// `task_blocks` has the first block of each task, then the number of blocks. `weights` has the mass of
    /// each vertex in its first row.
    pub(super) fn measure_fields(
        &mut self,
        executor: &Executor,
        task_blocks: &[usize],
        weights: &Lanes<2>,
        positions: &Lanes<3>,
        velocities: &Lanes<3>,
    ) {
        let (components, task_sums) = self.begin_sums();
        executor.tasks(task_blocks, ((), (), task_sums), |task, (), (), sums| {
            let blocks = task_blocks[task]..task_blocks[task + 1];
            let fields = Fields {
                weights: &weights.blocks()[blocks.clone()],
                positions: &positions.blocks()[blocks.clone()],
                velocities: &velocities.blocks()[blocks.clone()],
            };
            dispatch!(level(), simd => add(simd, components, blocks.start, fields, sums));
        });
        self.finish_sums();
    }

    /// Sets the sums to zero. Returns the component of each slot, and the sums of each component for each
    /// task.
    pub(crate) fn begin_sums(&mut self) -> (&Components, &mut [Sums]) {
        self.task_sums.fill(Sums::default());
        (&self.components, &mut self.task_sums)
    }

    /// Computes the center of mass, the momenta and the inertia of each component from the sums of the tasks.
    pub(crate) fn finish_sums(&mut self) {
        let count = self.states.len();
        for (component, state) in self.states.iter_mut().enumerate() {
            let mut total = Sums::default();
            for sums in self.task_sums.iter().skip(component).step_by(count) {
                total.add(sums);
            }
            *state = total.rigid_state(self.masses[component]);
        }
    }

    /// Adds to the linear momenta the impulse of `velocity_change`, a velocity change of all vertices in
    /// cells/s.
    pub(crate) fn add_impulse(&self, momenta: &mut [Option<Momentum>], velocity_change: Vector3<f64>) {
        for (momentum, mass) in momenta.iter_mut().zip(&self.masses) {
            if let Some(momentum) = momentum {
                momentum.linear = (Vector3::from(momentum.linear) + velocity_change * *mass).into();
            }
        }
    }

    /// Returns the kinetic energy of the rigid part of the motion at the last measurement, in units of a full
    /// cell's mass times (cells/s)².
    pub(super) fn rigid_energy(&self) -> f64 {
        self.states.iter().map(RigidState::rigid_energy).sum()
    }

    /// Scales the measured momenta by `scale`, after all velocities were scaled by `scale`.
    pub(in crate::dynamics) fn scale(&mut self, scale: f64) {
        for momentum in self.states.iter_mut().map(|state| &mut state.momentum) {
            momentum.linear = momentum.linear.map(|p| p * scale);
            momentum.angular = momentum.angular.map(|l| l * scale);
        }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let slot_bytes = match &self.components {
            Components::One => 0,
            Components::Several(of_slot) => size_of_val(of_slot.as_slice()),
        };
        let component_bytes = size_of_val(self.masses.as_slice())
            + size_of_val(self.states.as_slice())
            + size_of_val(self.corrections.as_slice())
            + self.constrained.len();
        slot_bytes + size_of_val(self.task_sums.as_slice()) + component_bytes
    }

    /// Returns whether any component is unconstrained.
    pub(crate) fn any_free(&self) -> bool {
        self.constrained.contains(&false)
    }

    /// Returns the center of mass of the body at the last measurement, in cells from the body's origin.
    pub(crate) fn center(&self) -> Vector3<f64> {
        self.states.iter().map(|state| state.center * state.mass).sum::<Vector3<f64>>() / self.mass()
    }

    /// Returns the velocity of the center of mass at the last measurement, in cells/s, relative to the
    /// velocity of the body's origin.
    pub(crate) fn velocity(&self) -> Vector3<f64> {
        self.states.iter().map(|state| Vector3::from(state.momentum.linear)).sum::<Vector3<f64>>()
            / self.mass()
    }

    fn mass(&self) -> f64 {
        self.states.iter().map(|state| state.mass).sum()
    }

    /// Returns the component of each slot.
    pub(crate) fn components(&self) -> &Components {
        &self.components
    }

    /// Returns the rigid state of each component at the last measurement.
    pub(crate) fn states(&self) -> &[RigidState] {
        &self.states
    }

    /// Computes, for each component, the rigid velocity that changes the measured momenta to the momenta in
    /// `momenta`. The rigid velocity is zero for a component whose entry in `momenta` is `None`.
    pub(crate) fn corrections(&mut self, momenta: &[Option<Momentum>]) -> (&Components, &[RigidVelocity]) {
        for ((state, momentum), correction) in self.states.iter().zip(momenta).zip(&mut self.corrections) {
            *correction = momentum.map_or_else(RigidVelocity::default, |target| state.correction_to(target));
        }
        (&self.components, &self.corrections)
    }
}
