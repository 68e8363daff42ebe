//! What a user changes between steps.

use super::builder::extent;
use super::look::unlocked;
use super::{Body, Damping, Material, RangeError, Reach, Stiffness, Surface};
use crate::dynamics::damping::RegionDamping;
use crate::dynamics::momentum::Bookkeeper;
use crate::dynamics::{Key, KinematicsError, Motion};
use crate::matching::cascade::Cascade;
use crate::volume::{VolumeError, VolumeOptions};

impl Body {
    /// Sets how far regions reach, from the next step on. Takes as long as building the regions does; positions,
    /// velocities and momenta stay.
    ///
    /// # Errors
    ///
    /// A number out of its range.
    pub fn set_reach(&mut self, reach: Reach) -> Result<(), RangeError> {
        let material = Material { reach, ..self.material };
        material.validate()?;
        self.material = material;
        let half_width = material.half_width(self.lattice.cell_size(), extent(&self.lattice));
        if half_width == self.half_width() {
            return Ok(());
        }
        self.matching.set_half_width(&self.lattice, half_width);
        let cascade = Cascade::new(&self.matching.layout, half_width);
        // The sums are cut into other tasks, and the bookkeeper has a place for each.
        self.bookkeeper = Bookkeeper::new(&self.lattice, &self.matching.layout, cascade.tasks());
        // Of other regions rotations and potential are others.
        self.state.fitted = false;
        (self.energy, self.state.energy) = (None, None);
        *unlocked(&mut self.cascade) = cascade;
        self.damping = material.is_damped().then(|| RegionDamping::new(&self.matching));
        self.book_holds();
        Ok(())
    }

    /// Sets whether and how the volume is kept in what is shown. Takes as long as building the correction does.
    ///
    /// # Errors
    ///
    /// A number out of its range, or a correction that the mesh cannot have; nothing is changed then.
    pub fn set_volume(&mut self, volume: impl Into<VolumeOptions>) -> Result<(), VolumeError> {
        let surface = self.surface.as_ref().map(Surface::borrowed);
        unlocked(&mut self.view).set_volume(&self.lattice, surface, &volume.into())
    }

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
