//! Adds bodies to a simulation and removes them, between steps.

use super::groups;
use super::world::Simulation;
use crate::body::Body;
use crate::error::Error;

impl Simulation {
    /// Adds a body after the others, from the next step on, and returns its index. The other bodies keep their
    /// contacts. An automatic number of steps per frame stays as it was chosen.
    ///
    /// States that were saved before have one body less, and cannot be restored.
    pub fn add_body(&mut self, mut body: Body) -> usize {
        body.update_contact_stage(&self.colliders);
        body.search_escapes();
        body.fix_elasticity(self.gravity.norm(), self.dt());
        self.bodies.push(body);
        let index = self.bodies.len() - 1;
        groups::begin(&mut self.bodies, index, self.contact, &mut self.contacts);
        index
    }

    /// Removes a body, and returns it: another simulation, or this one, can have it. The bodies after it have indices
    /// that are lower by one. Bodies that touched it wake up. [`Simulation::contacts`] lists no contacts
    /// between bodies until the next step.
    ///
    /// # Errors
    ///
    /// A body that a link ties, or the only body. The simulation is then unchanged.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a body.
    pub fn remove_body(&mut self, index: usize) -> Result<Body, Error> {
        assert!(index < self.bodies.len(), "body {index} of {}", self.bodies.len());
        if self.bodies.len() == 1 {
            return Err(Error::NoBody);
        }
        if self.links.ties(index) {
            return Err(Error::LinkedBody { name: self.bodies[index].name().to_owned() });
        }
        let mut removed = self.bodies.remove(index);
        removed.forget_bodies();
        for body in &mut self.bodies {
            body.follow_removal(index as u32);
        }
        self.links.remove_body(index);
        self.pair_supports.remove_body(index as u32);
        // The searches and islands of the last step refer to the bodies by their indices.
        self.contacts = None;
        groups::update(&mut self.bodies, self.contact, &mut self.contacts);
        Ok(removed)
    }
}
