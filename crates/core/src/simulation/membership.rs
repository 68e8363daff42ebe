//! Adds bodies to a simulation and removes them, between steps.

use super::groups;
use super::substeps::ChosenSubsteps;
use super::world::Simulation;
use crate::body::Body;
use crate::dynamics::Field;
use crate::error::Error;

impl Simulation {
    /// Adds a body after the others, from the next step on, and returns its index. The other bodies keep their
    /// contacts with each other. An automatic number of steps per frame stays as it was chosen. The body is awake.
    ///
    /// States that were saved before have one body less, and cannot be restored.
    pub fn add_body(&mut self, mut body: Body) -> usize {
        body.join(&self.colliders, self.greatest_gravity().norm(), self.dt());
        self.bodies.push(body);
        let index = self.bodies.len() - 1;
        groups::begin(&mut self.bodies, index, self.contact, &mut self.contacts);
        index
    }

    /// Removes a body, and returns it: another simulation, or this one, can have it. The bodies after it have indices
    /// that are lower by one. Bodies that touched it wake up. Fields no longer name it, and those that named it alone
    /// are removed. [`Simulation::contacts`] lists no contacts between bodies until the next step, and none between
    /// bodies that sleep on. If the body determined an automatic number of steps per frame, the next step chooses it
    /// anew.
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
        removed.leave_simulation();
        for body in &mut self.bodies {
            body.follow_removal(index as u32);
        }
        self.links.remove_body(index);
        let is_of_others = |field: &mut Field| {
            let named = !field.bodies.is_empty();
            field.bodies.retain(|name| name != removed.name());
            !named || !field.bodies.is_empty()
        };
        self.fields.retain_mut(is_of_others);
        self.remove_restored_contacts(index);
        self.chosen = match self.chosen {
            Some(chosen) if chosen.body == index => {
                self.choose_at_next_step = true;
                None
            }
            Some(chosen) => {
                Some(ChosenSubsteps { body: chosen.body - usize::from(chosen.body > index), ..chosen })
            }
            None => None,
        };
        self.pair_supports.remove_body(index as u32);
        // The searches and islands of the last step refer to the bodies by their indices.
        self.contacts = None;
        groups::update(&mut self.bodies, self.contact, &mut self.contacts);
        Ok(removed)
    }
}
