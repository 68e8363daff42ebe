//! What a user changes between steps.

use super::{Body, Damping, Material, RangeError, Stiffness};
use crate::dynamics::damping::RegionDamping;
use crate::dynamics::{Key, KinematicsError, Motion};

impl Body {
    /// Sets how strongly vertices are drawn to their goals, from the next step on.
    ///
    /// # Errors
    ///
    /// A number out of its range.
    pub fn set_stiffness(&mut self, stiffness: Stiffness) -> Result<(), RangeError> {
        let material = Material { stiffness, ..self.material };
        material.validate()?;
        self.material = material;
        Ok(())
    }

    /// Sets the region damping, from the next step on; none leaves the stage out.
    ///
    /// # Errors
    ///
    /// A number out of its range.
    pub fn set_damping(&mut self, damping: Damping) -> Result<(), RangeError> {
        let material = Material { damping, ..self.material };
        material.validate()?;
        self.material = material;
        self.damping = match self.damping.take() {
            _ if !material.is_damped() => None,
            Some(stage) => Some(stage),
            None => Some(RegionDamping::new(&self.matching)),
        };
        Ok(())
    }

    /// Lets a pin or a handle go: the `hold`-th of all in the order in which they were added.
    ///
    /// # Errors
    ///
    /// If there are not so many.
    pub fn release(&mut self, hold: usize) -> Result<(), KinematicsError> {
        let kinematics = self.kinematics.as_mut().ok_or(KinematicsError::NoSuchHold { hold, count: 0 })?;
        kinematics.release(hold)
    }

    /// Gives a handle other keys, relative to the pose that it captured when it began.
    ///
    /// # Errors
    ///
    /// If there are not so many, or keys that are no motion or lead further than 10^15 cells.
    pub fn set_keys(&mut self, hold: usize, keys: &[Key]) -> Result<(), KinematicsError> {
        let limit = self.farthest();
        let kinematics = self.kinematics.as_mut().ok_or(KinematicsError::NoSuchHold { hold, count: 0 })?;
        let motion = Motion::new(keys.to_vec())?;
        motion.within(limit)?;
        kinematics.set_motion(hold, motion)
    }

    /// Pins and handles so far, those that were let go included.
    pub fn hold_count(&self) -> usize {
        self.kinematics.as_ref().map_or(0, |kinematics| kinematics.holds().len())
    }
}
