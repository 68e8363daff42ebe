//! The motion of the constrained vertices of each component, for `elastic_damping`.

use super::constraints::Constraints;
use super::momentum::{MomentumTracker, RigidState, Sums};
use crate::matching::Matching;
use crate::simd::vector::wide;
use crate::state::State;

/// Sums over the constrained vertices of each component, with unit masses, and their number. Empty without active
/// constraints.
#[derive(Clone, Debug, Default)]
pub(super) struct ConstrainedVertices(Vec<(Sums, f64)>);

impl ConstrainedVertices {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.0.as_slice())
    }

    /// Sums the motion of the vertices. `tracker` has the components.
    pub(super) fn read(
        &mut self,
        constraints: Option<&Constraints>,
        (matching, state): (&Matching, &State),
        tracker: &MomentumTracker,
    ) {
        self.0.clear();
        let Some(constraints) = constraints.filter(|constraints| constraints.any_active()) else { return };
        self.0.resize(tracker.states().len(), (Sums::default(), 0.0));
        for vertex in constraints.list().iter().flat_map(|constraint| constraint.held()) {
            let slot = matching.layout.slots()[vertex as usize];
            let (sums, count) = &mut self.0[tracker.components().of_slot(slot)];
            let (position, velocity) = (wide(state.positions.get(slot)), wide(state.velocities.get(slot)));
            sums.add_vertex(1.0, position.into(), velocity.into());
            *count += 1.0;
        }
    }

    /// Returns the motion of the vertices of a component, with unit masses; `None` if it has none.
    pub(super) fn of_component(&self, component: usize) -> Option<RigidState> {
        let found = self.0.get(component).filter(|(_, count)| *count > 0.0);
        found.map(|(sums, count)| sums.rigid_state(*count))
    }
}
