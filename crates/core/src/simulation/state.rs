//! The state of a simulation: what a checkpoint holds, and all that is needed to go on bit for bit.

use super::Simulation;
use crate::body::BodySnapshot;
use crate::dynamics::Interval;
use crate::error::Error;

/// All of a simulation that steps change: positions, velocities, rotations, origins, momenta, what pins and handles
/// captured, and the number of steps. It fits any simulation that was built alike.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SimulationState {
    steps: u64,
    bodies: Vec<BodySnapshot>,
}

impl SimulationState {
    /// Steps that led to this state.
    pub fn step_count(&self) -> u64 {
        self.steps
    }
}

impl Simulation {
    /// The state as it is.
    pub fn state(&self) -> SimulationState {
        SimulationState {
            steps: self.count,
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
            let (own, other) = (self.bodies.len(), state.bodies.len());
            return Err(Error::State(format!("the simulation has {own} bodies, the state {other}")));
        }
        for (body, snapshot) in self.bodies.iter().zip(&state.bodies) {
            body.fits(snapshot).map_err(Error::State)?;
        }
        let last = state.steps.checked_sub(1).map(|step| Interval::of_step(step, self.dt));
        for (body, snapshot) in self.bodies.iter_mut().zip(&state.bodies) {
            body.restore(snapshot, last)?;
        }
        self.count = state.steps;
        Ok(())
    }
}
