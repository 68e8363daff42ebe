//! Numbers of the material that change along keyframes: their values in a step.

use super::soft_body::Body;
use crate::dynamics::{Damping, Elasticity, KeyedMaterial, Material};
use crate::error::Error;
use crate::motion::Curve;
use crate::state::Interval;

impl Body {
    /// Sets the keyframes of numbers of the material, from the next step on. The numbers themselves become the greatest
    /// values, by which a simulation fixes the regions. A Young's modulus makes the elasticity one.
    ///
    /// # Errors
    ///
    /// A number out of range, or keyframes of the elasticity or damping of a rigid body. Nothing is then changed.
    pub fn set_keyed(&mut self, keyed: KeyedMaterial) -> Result<(), Error> {
        keyed.validate()?;
        if keyed.names().any(|name| name != "friction") {
            self.check_deforms("keyframes of a material")?;
        }
        self.wake();
        if let Some(curve) = &keyed.youngs_modulus {
            self.set_elasticity(Elasticity::YoungsModulus(curve.greatest()))?;
        }
        if let Some(curve) = &keyed.poisson_ratio {
            self.set_poisson_ratio(Some(curve.greatest()))?;
        }
        if let Some(curve) = &keyed.damping_ratio {
            self.set_damping(Some(Damping::Ratio(curve.greatest())))?;
        }
        if let Some(curve) = &keyed.friction {
            self.settings.touching.friction = curve.greatest();
        }
        self.settings.modulus_share = 1.0;
        self.keyed = (!keyed.is_empty()).then(|| Box::new(keyed));
        Ok(())
    }

    /// Returns the keyframes of numbers of the material; `None` if none of them changes.
    pub fn keyed(&self) -> Option<&KeyedMaterial> {
        self.keyed.as_deref()
    }

    /// Returns the greatest Poisson's ratio that the body has at any time.
    pub(crate) fn greatest_poisson_ratio(&self) -> f64 {
        let keyed = self.keyed.as_ref().and_then(|keyed| keyed.poisson_ratio.as_ref());
        keyed.map_or_else(|| self.settings.material.poisson_ratio(), Curve::greatest)
    }

    /// Returns the material with the greatest values of its keyframes.
    pub(super) fn material_at_start(&self) -> Material {
        let mut material = self.settings.material;
        if let Some(KeyedMaterial { poisson_ratio, damping_ratio, .. }) = self.keyed.as_deref() {
            material.poisson_ratio = poisson_ratio.as_ref().map(Curve::greatest).or(material.poisson_ratio);
            let damping = damping_ratio.as_ref().map(|curve| Damping::Ratio(curve.greatest()));
            material.damping = damping.or(material.damping);
        }
        material
    }

    /// Forgets the keyframes of a number, which another value replaces.
    pub(super) fn forget_keys(&mut self, number: impl FnOnce(&mut KeyedMaterial) -> &mut Option<Curve>) {
        if let Some(keyed) = &mut self.keyed {
            *number(keyed) = None;
            if keyed.youngs_modulus.is_none() {
                self.settings.modulus_share = 1.0;
            }
            if keyed.is_empty() {
                self.keyed = None;
            }
        }
    }

    /// Wakes the body if numbers change in a step.
    pub(super) fn wake_to_change(&mut self, interval: Interval) {
        if self.keyed.as_ref().is_some_and(|keyed| keyed.changes(interval.start, interval.end)) {
            self.wake();
        }
    }

    /// Sets the numbers to those at the end of a step.
    pub(super) fn update_keyed(&mut self, interval: Interval) {
        let Some(keyed) = &self.keyed else { return };
        let value = |curve: &Option<Curve>| curve.as_ref().map(|curve| curve.value(interval.end));
        let share = keyed.youngs_modulus.as_ref().map(|curve| curve.value(interval.end) / curve.greatest());
        let (poisson_ratio, damping_ratio) = (value(&keyed.poisson_ratio), value(&keyed.damping_ratio));
        if let Some(friction) = value(&keyed.friction) {
            self.settings.touching.friction = friction;
        }
        if let Some(ratio) = damping_ratio {
            self.settings.material.damping = Some(Damping::Ratio(ratio));
            if self.needs_damping() != self.pipeline.elastic_damping.is_some() {
                self.update_elastic_damping();
            }
        }
        if poisson_ratio.is_some() && poisson_ratio != self.settings.material.poisson_ratio {
            self.settings.material.poisson_ratio = poisson_ratio;
            // It is that of the greatest ratio: see `lowest_angular_frequency`.
            let eigenvalue = self.pipeline.lowest_eigenvalue.take();
            self.update_shapes();
            if let Some(eigenvalue) = eigenvalue {
                self.pipeline.lowest_eigenvalue = eigenvalue.into();
            }
        }
        if let Some(share) = share {
            self.settings.modulus_share = share;
        }
        self.limit_factors_in_force(interval.dt);
    }
}
