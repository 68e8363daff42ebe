//! Resets a simulation to frame 0.

use super::clock::Clock;
use super::groups::Groups;
use super::state::SimulationState;
use super::world::Simulation;
use crate::body::Body;
use crate::state::PairSupports;

impl Simulation {
    /// Sets the simulation back to time 0 and the bodies to the state in which they were built: placement, initial
    /// velocity and spin, whole, without plastic shapes, forces and contacts; broken links are whole again. Pins and handles act as in the first
    /// step, and capture positions anew. Colliders follow their keyframes again.
    ///
    /// Settings, keyframes, pins and handles, fields and colliders stay as they are now. The next steps have the bits of
    /// a simulation that is built with them. If the number of steps per frame is automatic, the next step chooses it. No
    /// copy of the first state is kept: it is computed again.
    pub fn reset(&mut self) {
        let is_automatic = self.has_automatic_substeps();
        let state = SimulationState {
            clock: Clock::new(self.dt()),
            substeps: self.substeps,
            choose_at_next_step: is_automatic,
            gravity: self.gravity_curve.clone(),
            fields: self.fields.clone(),
            bodies: self.bodies.iter().map(Body::initial_snapshot).collect(),
            driven: Vec::new(),
            pair_supports: PairSupports::default(),
            broken_links: Vec::new(),
            contacts: Vec::new(),
        };
        self.restore(&state).expect("the state is made of these bodies");
        // As when the simulation is built, but without the regions that are replaced at once.
        let gravity = self.greatest_gravity().norm();
        let dt = match self.fps {
            Some(fps) if is_automatic => 1.0 / fps,
            _ => self.dt(),
        };
        match is_automatic {
            true => self.choose_substeps(),
            false => self.bodies.iter_mut().for_each(|body| body.fix_elasticity(gravity, dt)),
        }
        self.bodies.iter_mut().for_each(|body| body.finish_reset(gravity, dt));
        self.groups = Groups::default();
    }
}
