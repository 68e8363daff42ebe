//! The state of a simulation: what a checkpoint holds, and all that is needed to go on bit for bit.

use super::{Clock, Simulation};
use crate::body::{BodySnapshot, StateError};
use crate::error::Error;

/// All of a simulation that steps and users change: positions, velocities, rotations, origins, momenta, pins and
/// handles with what they captured, time, gravity. It fits any simulation that was built alike.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SimulationState {
    clock: Clock,
    gravity: [f64; 3],
    bodies: Vec<BodySnapshot>,
}

impl SimulationState {
    /// Steps that led to this state.
    pub fn step_count(&self) -> u64 {
        self.clock.steps()
    }
}

impl Simulation {
    /// The state as it is.
    pub fn state(&self) -> SimulationState {
        SimulationState {
            clock: self.clock,
            gravity: self.gravity.into(),
            bodies: self.bodies.iter().map(|body| body.snapshot()).collect(),
        }
    }

    /// Goes back, or on, to a state of a simulation that was built like this one.
    ///
    /// # Errors
    ///
    /// A state of other bodies than these; nothing is changed then.
    pub fn restore(&mut self, state: &SimulationState) -> Result<(), Error> {
        if state.bodies.len() != self.bodies.len() {
            return Err(StateError::Bodies { bodies: self.bodies.len(), found: state.bodies.len() }.into());
        }
        if !state.clock.is_whole() {
            return Err(StateError::Time.into());
        }
        for (body, snapshot) in self.bodies.iter().zip(&state.bodies) {
            body.fits(snapshot)?;
        }
        self.set_gravity(state.gravity)?;
        for (body, snapshot) in self.bodies.iter_mut().zip(&state.bodies) {
            body.adopt(snapshot)?;
        }
        self.clock = state.clock;
        Ok(())
    }
}
