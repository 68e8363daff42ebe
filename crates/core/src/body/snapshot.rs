//! The state of a body to save and restore: what steps and users change.

use super::{Body, Surface};
use crate::dynamics::{Constraints, Forces, Material, RegionDamping, RegionSize, Stiffness};
use crate::error::Error;
use crate::state::State;
use crate::volume::{Correction, VolumeOptions};

/// All of a body that steps and users change. It fits any body that was built alike.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodySnapshot {
    state: State,
    constraints: Option<Constraints>,
    region_size: RegionSize,
    stiffness: Stiffness,
    region_damping: RegionDamping,
    volume: VolumeOptions,
    forces: Option<Forces>,
    /// What contacts did since the frame began, for the volume correction.
    pushes: Vec<[f32; 3]>,
}

/// A state that does not fit.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// The state of another number of bodies.
    #[error("the simulation has {bodies} bodies, the state {found}")]
    Bodies {
        /// Bodies of the simulation.
        bodies: usize,
        /// Bodies of the state.
        found: usize,
    },
    /// The time makes no sense.
    #[error("the state has no time")]
    Time,
    /// Cells of another size.
    #[error("body {body:?} has cells of {cell_size}, the state of {found}")]
    CellSize {
        /// The body.
        body: String,
        /// Its cell size.
        cell_size: f64,
        /// The cell size of the state.
        found: f64,
    },
    /// Another lattice.
    #[error("body {body:?} has {blocks} blocks of lattice vertices, the state {found}")]
    Lattice {
        /// The body.
        body: String,
        /// Its blocks.
        blocks: usize,
        /// The blocks of the state.
        found: usize,
    },
    /// Pins, handles or forces on vertices that the body does not have.
    #[error("body {body:?}: the state has {what} of another body")]
    Vertices {
        /// The body.
        body: String,
        /// `pins and handles` or `forces`.
        what: &'static str,
    },
    /// Settings that the body cannot have.
    #[error("body {body:?}: {source}")]
    Settings {
        /// The body.
        body: String,
        /// Why not.
        source: Box<Error>,
    },
}

impl Body {
    /// The state as it is.
    pub fn snapshot(&self) -> BodySnapshot {
        BodySnapshot {
            state: self.state.clone(),
            constraints: self.constraints.clone(),
            region_size: self.material.region_size,
            stiffness: self.material.stiffness,
            region_damping: self.material.region_damping,
            volume: self.volume,
            forces: self.forces.clone(),
            pushes: self.contacts.as_ref().map_or_else(Vec::new, |contacts| contacts.all_pushes().to_vec()),
        }
    }

    /// Restores a state of a body that was built like this one.
    ///
    /// # Errors
    ///
    /// A state of another body; nothing is changed then.
    pub fn restore(&mut self, snapshot: &BodySnapshot) -> Result<(), Error> {
        self.fits(snapshot)?;
        self.adopt(snapshot)
    }

    /// Restores a state that [`fits`](Self::fits).
    pub(crate) fn adopt(&mut self, snapshot: &BodySnapshot) -> Result<(), Error> {
        self.set_region_size(snapshot.region_size)?;
        self.set_stiffness(snapshot.stiffness)?;
        self.set_region_damping(snapshot.region_damping)?;
        if snapshot.volume != self.volume {
            self.set_volume(snapshot.volume)?;
        }
        self.state = snapshot.state.clone();
        self.constraints = snapshot.constraints.clone();
        self.track_constraints();
        self.forces = snapshot.forces.clone();
        if let Some(contacts) = &mut self.contacts {
            contacts.set_pushes(&snapshot.pushes);
        }
        Ok(())
    }

    /// Checks that a snapshot is of a body like this one.
    pub(crate) fn fits(&self, snapshot: &BodySnapshot) -> Result<(), StateError> {
        let body = || self.name.clone();
        let (cell_size, found) = (self.state.frame.cell_size(), snapshot.state.frame.cell_size());
        if cell_size != found {
            return Err(StateError::CellSize { body: body(), cell_size, found });
        }
        let (blocks, found) = (self.state.positions.blocks().len(), snapshot.state.positions.blocks().len());
        if !(blocks == found && snapshot.state.is_whole(blocks, self.state.momenta.len())) {
            return Err(StateError::Lattice { body: body(), blocks, found });
        }
        let vertices = self.lattice.len();
        if !snapshot.constraints.as_ref().is_none_or(|constraints| constraints.is_whole(vertices)) {
            return Err(StateError::Vertices { body: body(), what: "pins and handles" });
        }
        if !snapshot.forces.as_ref().is_none_or(|forces| forces.is_whole(vertices)) {
            return Err(StateError::Vertices { body: body(), what: "forces" });
        }
        let settings = |source| StateError::Settings { body: body(), source: Box::new(source) };
        self.check_settings(snapshot).map_err(settings)
    }

    fn check_settings(&self, snapshot: &BodySnapshot) -> Result<(), Error> {
        let &BodySnapshot { region_size, stiffness, region_damping, volume, .. } = snapshot;
        Material { region_size, stiffness, region_damping, ..self.material }.validate()?;
        if volume != self.volume {
            Correction::new(&self.lattice, self.surface.as_ref().map(Surface::borrowed), &volume)?;
        }
        Ok(())
    }
}
