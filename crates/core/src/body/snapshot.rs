//! The state of a body: what a checkpoint holds, and what a user changed since it was built.

use super::force::Forces;
use super::{Body, Damping, Material, Reach, State, Stiffness, Surface};
use crate::dynamics::Kinematics;
use crate::error::Error;
use crate::volume::{Correction, VolumeOptions};

/// All of a body that steps and users change. It fits any body that was built alike.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodySnapshot {
    state: State,
    kinematics: Option<Kinematics>,
    reach: Reach,
    stiffness: Stiffness,
    damping: Damping,
    volume: VolumeOptions,
    forces: Option<Forces>,
    /// What contacts did since the frame began, for the volume correction.
    pushes: Vec<[f32; 3]>,
}

impl Body {
    /// The state as it is.
    pub fn snapshot(&self) -> BodySnapshot {
        BodySnapshot {
            state: self.state.clone(),
            kinematics: self.kinematics.clone(),
            reach: self.material.reach,
            stiffness: self.material.stiffness,
            damping: self.material.damping,
            volume: self.volume(),
            forces: self.forces.clone(),
            pushes: self.contacts.as_ref().map_or_else(Vec::new, |contacts| contacts.all_pushes().to_vec()),
        }
    }

    /// Goes back, or on, to a state of a body that was built like this one.
    ///
    /// # Errors
    ///
    /// A state of another body; nothing is changed then.
    pub fn restore(&mut self, snapshot: &BodySnapshot) -> Result<(), Error> {
        self.fits(snapshot).map_err(Error::State)?;
        self.adopt(snapshot)
    }

    /// Goes to a state that [`fits`](Self::fits).
    pub(crate) fn adopt(&mut self, snapshot: &BodySnapshot) -> Result<(), Error> {
        self.set_reach(snapshot.reach)?;
        self.set_stiffness(snapshot.stiffness)?;
        self.set_damping(snapshot.damping)?;
        if snapshot.volume != self.volume() {
            self.set_volume(snapshot.volume)?;
        }
        self.state = snapshot.state.clone();
        self.kinematics = snapshot.kinematics.clone();
        self.book_holds();
        self.forces = snapshot.forces.clone();
        if let Some(contacts) = &mut self.contacts {
            contacts.set_pushes(&snapshot.pushes);
        }
        Ok(())
    }

    /// Whether a snapshot is of a body like this one.
    pub(crate) fn fits(&self, snapshot: &BodySnapshot) -> Result<(), String> {
        let (size, other_size) = (self.state.frame.cell_size(), snapshot.state.frame.cell_size());
        if size != other_size {
            return Err(format!("body {:?} has cells of {size}, the state of {other_size}", self.name));
        }
        let (own, other) = (self.state.positions.blocks().len(), snapshot.state.positions.blocks().len());
        if !(own == other && snapshot.state.is_whole(own, self.state.books.len())) {
            return Err(format!(
                "body {:?} has {own} blocks of lattice vertices, the state {other}",
                self.name
            ));
        }
        let vertices = self.lattice.len();
        if !snapshot.kinematics.as_ref().is_none_or(|kinematics| kinematics.is_whole(vertices)) {
            return Err(format!("body {:?}: the state has pins and handles of another body", self.name));
        }
        self.takes(snapshot).map_err(|error| format!("body {:?}: {error}", self.name))?;
        if !snapshot.forces.as_ref().is_none_or(|forces| forces.is_whole(vertices)) {
            return Err(format!("body {:?}: the state has forces of another body", self.name));
        }
        Ok(())
    }

    /// Whether what a user changed can be set here too.
    fn takes(&self, snapshot: &BodySnapshot) -> Result<(), Error> {
        let &BodySnapshot { reach, stiffness, damping, volume, .. } = snapshot;
        Material { reach, stiffness, damping, ..self.material }.validate()?;
        if volume != self.volume() {
            Correction::new(&self.lattice, self.surface.as_ref().map(Surface::borrowed), &volume)?;
        }
        Ok(())
    }
}
