//! Saves and restores the state of a body.

use std::sync::OnceLock;

use super::snapshot::BodySnapshot;
use super::soft_body::Body;
use super::stages::stages;
use super::surface::Surface;
use super::zones::{check_stiffness, checked_factors};
use crate::error::{Error, StateError};
use crate::lattice::{Embedding, Lattice, Layout};
use crate::range::{Range, in_range};
use crate::state::{ArrayError, State};
use crate::volume::{self, Correction, VolumeError, VolumeOptions};

impl Body {
    /// Returns a copy of the current state.
    pub fn snapshot(&self) -> BodySnapshot {
        let mut snapshot = BodySnapshot { cracks: self.cracks(), ..self.snapshot_of(self.state.clone()) };
        stages().for_each(|stage| stage.save(self, &mut snapshot));
        snapshot
    }

    /// Returns a snapshot of a state of the whole body, with the present settings, without the data of stages.
    pub(super) fn snapshot_of(&self, state: State) -> BodySnapshot {
        BodySnapshot {
            cracks: None,
            state,
            constraints: None,
            material: self.settings.material,
            youngs_modulus: self.settings.youngs_modulus,
            half_width: self.half_width(),
            stiffness_factors: self.stiffness_factors().map(<[f64]>::to_vec),
            parts: self.settings.parts.clone(),
            inflation: None,
            keyed: None,
            modulus_share: 1.0,
            friction: None,
            volume: self.settings.volume,
            forces: None,
            displacements: Vec::new(),
            sides: Vec::new(),
        }
    }

    /// Restores a state of a body that was built from the same mesh or lattice with the same settings.
    ///
    /// # Errors
    ///
    /// A state that does not match the body. The body is then unchanged.
    pub fn restore(&mut self, snapshot: &BodySnapshot) -> Result<(), Error> {
        self.check_snapshot(snapshot)?;
        self.apply_snapshot(snapshot)?;
        // The other bodies may be elsewhere than when the state was saved.
        self.state.touches.forget_bodies();
        Ok(())
    }

    /// Restores the cracks of a state that passed [`check_snapshot`](Self::check_snapshot).
    pub(crate) fn apply_cracks(&mut self, snapshot: &BodySnapshot) {
        self.restore_cracks(snapshot.cracks.as_ref());
    }

    /// Restores a state that passed [`check_snapshot`](Self::check_snapshot).
    pub(crate) fn apply_snapshot(&mut self, snapshot: &BodySnapshot) -> Result<(), Error> {
        self.apply_cracks(snapshot);
        self.settings.material = snapshot.material;
        self.settings.youngs_modulus = snapshot.youngs_modulus;
        self.set_half_width(snapshot.half_width);
        let stiffness = snapshot.stiffness_factors.as_deref();
        if snapshot.parts != self.settings.parts || stiffness != self.stiffness_factors() {
            let factors = self.varied(&snapshot.parts, snapshot.stiffness_factors.clone())?;
            self.replace_factors(snapshot.parts.clone(), factors);
        }
        self.set_region_damping(snapshot.material.region_damping)?;
        self.update_elastic_damping();
        self.replace_volume(snapshot.volume)?;
        // Before the state, which it could change.
        self.update_shapes();
        self.state = snapshot.state.clone();
        stages().for_each(|stage| stage.restore(self, snapshot));
        Ok(())
    }

    /// Replaces the options of the volume correction by others that are valid for the whole body.
    pub(super) fn replace_volume(&mut self, volume: VolumeOptions) -> Result<(), VolumeError> {
        if volume != self.settings.volume {
            if self.shape.lattice.broken_joints().is_empty() {
                self.set_volume(volume)?;
            } else {
                // As after an event, it is created when it is needed.
                self.settings.volume = volume;
                self.display.correction = OnceLock::new();
            }
        }
        Ok(())
    }

    /// Checks that a snapshot matches this body: cell size, lattice, constraints, forces and settings.
    pub(crate) fn check_snapshot(&self, snapshot: &BodySnapshot) -> Result<(), StateError> {
        let body = || self.name.clone();
        let (cell_size, found) = (self.state.frame.cell_size(), snapshot.state.frame.cell_size());
        if cell_size != found {
            return Err(StateError::CellSize { body: body(), cell_size, found });
        }
        let found = snapshot.state.positions.blocks().len();
        let Ok(other) = self.lattice_with(snapshot.cracks.as_ref()) else {
            return Err(StateError::Lattice {
                body: body(),
                blocks: self.pipeline.matching.layout.blocks(),
                found,
            });
        };
        let (lattice, blocks) = match &other {
            None => (&self.shape.lattice, self.pipeline.matching.layout.blocks()),
            Some(lattice) => (lattice, Layout::new(lattice).blocks()),
        };
        let components = lattice.components().count;
        if snapshot.state.strains.is_some() != snapshot.material.plastic.is_some() {
            return Err(StateError::Plastic { body: body() });
        }
        if !(blocks == found && snapshot.state.is_valid(blocks, components)) {
            return Err(StateError::Lattice { body: body(), blocks, found });
        }
        let vertices = lattice.len();
        stages().try_for_each(|stage| stage.check(self, snapshot, vertices))?;
        let settings = |source| StateError::Settings { body: body(), source: Box::new(source) };
        self.check_settings(snapshot, vertices).map_err(settings)?;
        self.check_volume(snapshot.volume, (lattice, other.is_some())).map_err(|error| settings(error.into()))
    }

    /// Checks that the options of the volume correction are valid for the lattice of a snapshot. `is_other`: whether it
    /// has other broken joints than the body.
    fn check_volume(
        &self,
        volume: VolumeOptions,
        (lattice, is_other): (&Lattice, bool),
    ) -> Result<(), VolumeError> {
        if volume == self.settings.volume {
            return Ok(());
        }
        // Pieces that the measure does not allow keep the volume of their cells.
        if !lattice.broken_joints().is_empty() {
            return volume.validate();
        }
        let whole = match &self.breaking {
            Some(breaking) if is_other => breaking.whole.as_ref(),
            _ => {
                let surface = self.surface().map(Surface::volume_surface);
                return Correction::new(lattice, surface, &volume).map(|_| ());
            }
        };
        let embedding = whole.map(|mesh| Embedding::new(lattice, mesh.vertices()));
        let surface =
            whole.zip(embedding.as_ref()).map(|(mesh, embedding)| volume::Surface { mesh, embedding });
        Correction::new(lattice, surface, &volume).map(|_| ())
    }

    /// Checks that the settings of a snapshot are valid for this body with `vertices` lattice vertices.
    fn check_settings(&self, snapshot: &BodySnapshot, vertices: usize) -> Result<(), Error> {
        let &BodySnapshot { material, youngs_modulus, half_width, .. } = snapshot;
        material.validate()?;
        let factors = snapshot.stiffness_factors.as_ref();
        let factors = factors.map(|factors| checked_factors(factors, vertices)).transpose()?;
        check_stiffness(&material, factors.as_ref())?;
        let expected = self.whole().1.len();
        if let Some(count) = snapshot.parts.check(expected)? {
            return Err(ArrayError::Length { name: "zones", count, expected }.into());
        }
        if let Some(modulus) = youngs_modulus {
            Range::YOUNGS_MODULUS.check("youngs_modulus", modulus)?;
        }
        let is_within = half_width.links() <= self.shape.extent.max(1);
        in_range(
            "half_width",
            half_width.cells(),
            half_width.is_valid() && is_within,
            "0.5, or at least 1 and at most the extent",
        )?;
        Ok(())
    }
}
