//! Continues a restored state with other settings.

use super::settings::check_fields;
use super::state::SimulationState;
use super::substeps::Substeps;
use super::world::Simulation;
use crate::body::AdoptedSettings;
use crate::error::{Error, StateError};

impl SimulationState {
    /// Returns the state without the handles that follow an animation, in the bodies that adopt pins and handles. Such
    /// handles have no captured positions, and the animation may not exist any more.
    #[must_use]
    pub fn for_adoption(mut self, adopted: &[AdoptedSettings]) -> Self {
        let bodies = self.bodies.iter_mut().zip(adopted).filter(|(_, adopted)| adopted.constraints);
        bodies.for_each(|(body, _)| body.remove_followers());
        self
    }
}

impl Simulation {
    /// Takes gravity, fields, the steps per frame and settings of the bodies from the state `built` of a simulation
    /// that was built from the same meshes or lattices with other settings, from the next step on. For a simulation
    /// that is built with other settings and then continues the state of an earlier one: save its state when it is
    /// built, restore the earlier one, and adopt the settings of the saved one.
    ///
    /// * `adopted`: the settings to take, one per body.
    ///
    /// # Errors
    ///
    /// Another number of bodies, or settings that are not valid for a body. The bodies before that one have then the
    /// new settings.
    pub fn adopt(&mut self, built: &SimulationState, adopted: &[AdoptedSettings]) -> Result<(), Error> {
        let bodies = self.bodies.len();
        if let Some(found) = [built.bodies.len(), adopted.len()].into_iter().find(|&found| found != bodies) {
            return Err(StateError::Bodies { bodies, found }.into());
        }
        check_fields(&built.fields, &self.bodies)?;
        if built.gravity != self.gravity_curve {
            self.set_gravity(built.gravity.clone())?;
        }
        if built.fields != self.fields {
            self.set_fields(built.fields.clone())?;
        }
        if let Ok(steps) = u32::try_from(built.substeps)
            && built.substeps != self.substeps
        {
            self.set_substeps(Substeps::Fixed(steps))?;
        }
        if built.clock.dt() != self.clock.dt() {
            self.set_dt(built.clock.dt())?;
        }
        let settings = built.bodies.iter().zip(adopted);
        self.bodies
            .iter_mut()
            .zip(settings)
            .try_for_each(|(body, (built, adopted))| body.adopt(built, *adopted))
    }
}
