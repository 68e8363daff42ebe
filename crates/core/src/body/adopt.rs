//! Takes settings of another body that was built alike, for [`Simulation::adopt`](crate::Simulation::adopt).

use super::snapshot::BodySnapshot;
use super::soft_body::Body;
use crate::dynamics::Constraints;
use crate::error::Error;

/// The settings of a body that [`Simulation::adopt`](crate::Simulation::adopt) takes from another simulation. By default
/// it takes none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct AdoptedSettings {
    /// Material: elasticity, Poisson's ratio, damping, plasticity, density and the factors of zones, with their
    /// keyframes. Plastic shapes stay
    /// if both have plasticity.
    pub material: bool,
    /// Options of the volume correction.
    pub volume: bool,
    /// Ratios of the rest volume, of the body and of zones.
    pub inflation: bool,
    /// Pins and handles. Those on the same vertices with the same start keep the positions that they captured; the others
    /// capture positions when they next act.
    pub constraints: bool,
}

impl BodySnapshot {
    /// Removes the handles that follow an animation.
    pub(crate) fn remove_followers(&mut self) {
        self.constraints.iter_mut().for_each(Constraints::remove_followers);
    }
}

impl Body {
    /// Takes settings of the state `built` of a body that was built from the same mesh or lattice, and is whole.
    ///
    /// # Errors
    ///
    /// Settings that are not valid for this body.
    pub(crate) fn adopt(&mut self, built: &BodySnapshot, adopted: AdoptedSettings) -> Result<(), Error> {
        let lattice = &self.shape.lattice;
        let sources: Vec<u32> = (0..lattice.len() as u32).map(|vertex| lattice.source(vertex)).collect();
        if adopted.material {
            self.settings.material = built.material;
            self.settings.youngs_modulus = built.youngs_modulus;
            self.set_half_width(built.half_width);
            let factors = built.stiffness_factors.as_ref();
            let factors =
                factors.map(|factors| sources.iter().map(|&source| factors[source as usize]).collect());
            let factors = self.varied(&built.parts, factors)?;
            self.replace_factors(built.parts.clone(), factors);
            self.set_region_damping(built.material.region_damping)?;
            self.keyed = built.keyed.clone().map(Box::new);
            self.settings.modulus_share = built.modulus_share;
            self.update_elastic_damping();
            self.update_shapes();
        }
        if adopted.volume {
            self.replace_volume(built.volume)?;
        }
        if adopted.inflation {
            self.inflation = built.inflation.as_ref().map(|inflation| inflation.at_start(&sources));
            self.state.energy_limit = None;
            self.update_shapes();
            self.pass_inflation();
        }
        if adopted.constraints {
            let constraints = built.constraints.as_ref().map(|constraints| {
                let mut constraints = constraints.at_start(&sources);
                self.constraints.iter().for_each(|before| constraints.continue_from(before));
                constraints
            });
            self.replace_constraints(constraints);
        }
        self.wake();
        Ok(())
    }
}
