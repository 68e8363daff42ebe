//! Saves and restores the state of a simulation. A restored simulation continues bit-identically.

use super::clock::Clock;
use super::contact_point::ContactPoint;
use super::settings::check_fields;
use super::world::Simulation;
use crate::body::BodySnapshot;
use crate::contact::DrivenCollider;
use crate::dynamics::Field;
use crate::error::{Error, StateError};
use crate::motion::Curve;
use crate::state::PairSupports;

/// The saved state of a simulation: time, step length, steps per frame, gravity, fields, the motions of driven colliders,
/// which bodies rest on each other, the contacts of the last step, which links are broken and, for each body, a
/// [`BodySnapshot`] with positions, velocities, rotations, origin, momenta, forces, pins and handles with their captured
/// poses, and the settings that can change between steps. Descriptions of colliders and links are not included. A state
/// can be restored in any simulation that was built with the same bodies and colliders.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SimulationState {
    pub(super) clock: Clock,
    pub(super) substeps: u64,
    /// Whether the next step chooses the number of steps per frame.
    pub(super) choose_at_next_step: bool,
    pub(super) gravity: Curve<[f64; 3]>,
    pub(super) fields: Vec<Field>,
    pub(super) bodies: Vec<BodySnapshot>,
    pub(super) driven: Vec<DrivenCollider>,
    /// The supports of the bodies by each other.
    pub(super) pair_supports: PairSupports,
    /// Which links are broken.
    pub(super) broken_links: Vec<bool>,
    /// The contacts of the last step.
    pub(super) contacts: Vec<ContactPoint>,
}

impl SimulationState {
    /// Returns the number of steps after which the state was saved.
    pub fn step_count(&self) -> u64 {
        self.clock.steps()
    }
}

impl Simulation {
    /// Returns a copy of the current state.
    pub fn state(&self) -> SimulationState {
        SimulationState {
            clock: self.clock,
            substeps: self.substeps,
            choose_at_next_step: self.choose_at_next_step,
            gravity: self.gravity_curve.clone(),
            fields: self.fields.clone(),
            bodies: self.bodies.iter().map(|body| body.snapshot()).collect(),
            driven: self.colliders.driven(),
            pair_supports: self.pair_supports.clone(),
            broken_links: self.links.broken(),
            contacts: self.contacts(),
        }
    }

    /// Restores a state of a simulation that was built with the same bodies and colliders. Colliders that were
    /// not driven when the state was saved follow their keyframes again.
    ///
    /// # Errors
    ///
    /// A state that does not match the bodies or the number of colliders. The simulation is then unchanged.
    pub fn restore(&mut self, state: &SimulationState) -> Result<(), Error> {
        if state.bodies.len() != self.bodies.len() {
            return Err(StateError::Bodies { bodies: self.bodies.len(), found: state.bodies.len() }.into());
        }
        if !state.gravity.is_valid() {
            return Err(StateError::Gravity.into());
        }
        if !state.clock.is_valid() || state.substeps == 0 {
            return Err(StateError::Time.into());
        }
        check_fields(&state.fields, &self.bodies)?;
        if !state.pair_supports.is_valid() {
            return Err(StateError::Supports.into());
        }
        for (body, snapshot) in self.bodies.iter().zip(&state.bodies) {
            body.check_snapshot(snapshot)?;
        }
        for driven in &state.driven {
            let (colliders, index) = (self.colliders.len(), driven.collider as usize);
            if index >= colliders {
                return Err(StateError::Collider { colliders, index }.into());
            }
            if !driven.drive.is_valid() {
                return Err(StateError::Drive { index }.into());
            }
        }
        self.set_gravity(state.gravity.clone())?;
        self.fields.clone_from(&state.fields);
        for (body, snapshot) in self.bodies.iter_mut().zip(&state.bodies) {
            body.apply_cracks(snapshot);
        }
        // Before the states, because pieces that can touch each other keep their contacts.
        self.update_pieces();
        for (body, snapshot) in self.bodies.iter_mut().zip(&state.bodies) {
            body.apply_snapshot(snapshot)?;
        }
        self.links.set_broken(&state.broken_links);
        self.colliders.set_driven(&state.driven);
        self.pair_supports = state.pair_supports.clone();
        let count = self.bodies.len();
        self.pair_supports.retain(|support| support.sides.iter().all(|side| (side.0 as usize) < count));
        if let Some(contacts) = &mut self.contacts {
            contacts.clear_records();
        }
        // The colliders may be others than when the state was saved.
        let contacts = state.contacts.iter().filter(|contact| self.has_touched(contact));
        self.restored_contacts = contacts.copied().collect();
        self.clock = state.clock;
        self.gravity = self.gravity_curve.value(self.clock.time()).into();
        self.colliders.set_time(self.clock.time());
        self.substeps = state.substeps;
        self.choose_at_next_step = state.choose_at_next_step && self.fps.is_some();
        Ok(())
    }
}
