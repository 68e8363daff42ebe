//! Damps the elastic modes of a body: moves the velocity of each vertex towards the reference motion of its component.
//!
//! The reference motion is a rigid motion, the one that is closest to the velocities in the metric of the mass, among
//! those that the surroundings of the component allow: it moves like the constrained vertices do, and does not move
//! into or out of a collider that presses on it. Each step multiplies the difference of the velocities to the
//! reference motion by exp(-2 c dt), so that the amplitude of a mode with an angular frequency above c decays as
//! exp(-c t). A free component keeps its momenta: its reference motion is that of the rigid body with its momenta, so
//! that flight and spin are undamped.

use super::constraints::Constraints;
use super::momentum::{MomentumTracker, Projection, RigidMotion, RigidState, Sums};
use crate::state::{State, Support};

/// The elastic-damping stage. What it damps with is computed at the beginning of a step, and the integration applies
/// it.
#[derive(Clone, Debug, Default)]
pub(crate) struct ElasticDamper {
    /// Sums over the constrained vertices of each component, with unit masses, and their number.
    constrained: Vec<(Sums, f64)>,
}

impl ElasticDamper {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.constrained.as_slice())
    }

    /// Begins a step: reads the motion of the constrained vertices. `slots` has the slot of each lattice vertex.
    pub(crate) fn begin(
        &mut self,
        constraints: Option<&Constraints>,
        (state, slots): (&State, &[u32]),
        tracker: &MomentumTracker,
    ) {
        self.constrained.clear();
        let Some(constraints) = constraints.filter(|constraints| constraints.any_active()) else { return };
        self.constrained.resize(tracker.component_count(), (Sums::default(), 0.0));
        let active = constraints.list().iter().filter(|constraint| constraint.is_active());
        for &vertex in active.flat_map(|constraint| constraint.vertices()) {
            let slot = slots[vertex as usize];
            let (sums, count) = &mut self.constrained[tracker.component_of(slot)];
            sums.add_vertex(
                1.0,
                state.positions.get(slot).map(f64::from),
                state.velocities.get(slot).map(f64::from),
            );
            *count += 1.0;
        }
    }

    /// Returns the reference motion of a component. `motion` is the rigid motion with its momenta, and `supports` are
    /// the contacts that pressed on the body in the last step.
    pub(crate) fn reference(
        &self,
        (component, rigid): (usize, &RigidState),
        motion: RigidMotion,
        supports: &[Support],
    ) -> RigidMotion {
        let constrained = self.constrained.get(component).filter(|(_, count)| *count > 0.0);
        let mut supports =
            supports.iter().filter(|support| support.component as usize == component).peekable();
        if constrained.is_none() && supports.peek().is_none() {
            return motion;
        }
        let mut projection = Projection::new(rigid, motion);
        if let Some((sums, count)) = constrained {
            projection.fix_vertices(&sums.rigid_state(*count));
        }
        for support in supports {
            projection.fix_velocity(support.point.into(), support.normal.into(), support.speed);
        }
        projection.motion()
    }
}
