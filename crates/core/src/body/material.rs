//! Changes the material between steps.

use super::elasticity::initial_half_width;
use super::parts::Shape;
use super::soft_body::Body;
use super::stages::{DampModes, DampRegions, Stage};
use super::zones::check_stiffness;
use crate::dynamics::{Accuracy, Damping, Elasticity, Material, RegionDamping, RegionSize, Stiffness};
use crate::lattice::Lattice;
use crate::range::{RangeError, in_range};

impl Body {
    /// Replaces the material by another one of the same density, if its numbers are valid, and wakes the body up.
    pub(super) fn replace_material(&mut self, material: Material) -> Result<(), RangeError> {
        material.validate()?;
        check_stiffness(&material, self.stiffness_factors.as_ref())?;
        self.settings.material = material;
        self.wake();
        Ok(())
    }

    /// Sets the elasticity, from the next step on, and rebuilds the regions if their size changes. Positions,
    /// velocities and momenta are unchanged.
    ///
    /// In a simulation, Young's modulus and the regions are fixed as if the body joined the simulation at the next
    /// step.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_elasticity(&mut self, elasticity: Elasticity) -> Result<(), RangeError> {
        self.replace_material(Material { elasticity, ..self.settings.material })?;
        self.forget_keys(|keyed| &mut keyed.youngs_modulus);
        // The default of the damping depends on the elasticity.
        self.update_elastic_damping();
        self.settings.youngs_modulus = None;
        self.update_shapes();
        let Shape { lattice, extent, .. } = &self.shape;
        self.set_half_width(initial_half_width(&self.settings.material, lattice, *extent));
        Ok(())
    }

    /// Sets Poisson's ratio, from the next step on; `None` is the one of the material. In a simulation, Young's modulus
    /// and the regions are fixed as if the body joined the simulation at the next step.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_poisson_ratio(&mut self, poisson_ratio: Option<f64>) -> Result<(), RangeError> {
        self.replace_material(Material { poisson_ratio, ..self.settings.material })?;
        self.forget_keys(|keyed| &mut keyed.poisson_ratio);
        self.settings.youngs_modulus = None;
        self.update_shapes();
        Ok(())
    }

    /// Sets how the half-width of the regions is chosen, from the next step on. In a simulation, the regions are
    /// fixed as if the body joined the simulation at the next step; the steps stay as long as they are. With the
    /// elasticity of regions, nothing else changes.
    pub fn set_accuracy(&mut self, accuracy: Accuracy) {
        self.settings.material.accuracy = accuracy;
        self.wake();
        self.settings.youngs_modulus = None;
    }

    /// Sets the size of the regions, from the next step on: see [`Elasticity::with_region_size`].
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_region_size(&mut self, size: RegionSize) -> Result<(), RangeError> {
        self.set_elasticity(self.settings.material.elasticity.with_region_size(size))
    }

    /// Sets the stiffness of the regions, from the next step on: see [`Elasticity::with_stiffness`].
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_stiffness(&mut self, stiffness: Stiffness) -> Result<(), RangeError> {
        self.set_elasticity(self.settings.material.elasticity.with_stiffness(stiffness))
    }

    /// Sets the damping of the elastic modes, from the next step on. A damping of zero removes the stage. `None` is
    /// the damping ratio of the preset, and without a preset 0.2.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_damping(&mut self, damping: Option<Damping>) -> Result<(), RangeError> {
        self.replace_material(Material { damping, ..self.settings.material })?;
        self.forget_keys(|keyed| &mut keyed.damping_ratio);
        self.update_elastic_damping();
        Ok(())
    }

    /// Returns whether the body has the elastic-damping stage: for damping or rolling resistance.
    pub(super) fn needs_damping(&self) -> bool {
        !self.is_rigid() && self.has_damping()
    }

    fn has_damping(&self) -> bool {
        self.settings.material.is_damped()
            || self.rolling_resistance() > 0.0
            || self.contact.colliders_resist_rolling
    }

    /// Creates or removes the elastic-damping stage.
    pub(super) fn update_elastic_damping(&mut self) {
        DampModes.rebuild(self);
        if self.pipeline.elastic_damping.is_none() {
            self.state.supports.clear();
        }
    }

    /// Sets the region damping, from the next step on. A damping of zero removes the stage.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_region_damping(&mut self, region_damping: RegionDamping) -> Result<(), RangeError> {
        self.replace_material(Material { region_damping, ..self.settings.material })?;
        if DampRegions.exists(self) != self.settings.material.has_region_damping() {
            DampRegions.rebuild(self);
        }
        Ok(())
    }

    /// Sets the density, > 0: the masses change in proportion. Young's modulus, positions and velocities are
    /// unchanged.
    ///
    /// # Errors
    ///
    /// A number out of range.
    pub fn set_density(&mut self, density: f64) -> Result<(), RangeError> {
        let material = Material { density, ..self.settings.material };
        material.validate()?;
        check_cell_mass(&material, &self.shape.lattice)?;
        self.settings.material = material;
        self.wake();
        Ok(())
    }
}

/// Checks that the mass of a full cell is a finite number above 0.
pub(super) fn check_cell_mass(material: &Material, lattice: &Lattice) -> Result<(), RangeError> {
    let mass = material.density * lattice.cell_size().powi(3);
    in_range("density x cell_size^3", mass, mass > 0.0, "a finite mass > 0; change the density or the scale")
        .map(drop)
}
