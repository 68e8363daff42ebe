//! Numbers of the material that change along keyframes: their values in a step.

use super::soft_body::Body;
use crate::dynamics::{Damping, Elasticity, KeyedMaterial};
use crate::motion::{Curve, CurveKey};
use crate::range::RangeError;
use crate::state::Interval;

impl Body {
    /// Sets the keyframes of numbers of the material, from the next step on. The numbers themselves become the greatest
    /// values, by which a simulation fixes the regions. A Young's modulus makes the elasticity one.
    ///
    /// # Errors
    ///
    /// A number out of range. Nothing is then changed.
    pub fn set_keyed(&mut self, keyed: KeyedMaterial) -> Result<(), RangeError> {
        keyed.validate()?;
        if let Some(curve) = &keyed.youngs_modulus {
            self.set_elasticity(Elasticity::YoungsModulus(greatest(curve)))?;
        }
        if let Some(curve) = &keyed.poisson_ratio {
            self.set_poisson_ratio(Some(greatest(curve)))?;
        }
        if let Some(curve) = &keyed.damping_ratio {
            self.set_damping(Some(Damping::Ratio(greatest(curve))))?;
        }
        if let Some(curve) = &keyed.friction {
            self.settings.touching.friction = greatest(curve);
        }
        self.settings.modulus_share = 1.0;
        self.keyed = (!keyed.is_empty()).then(|| Box::new(keyed));
        Ok(())
    }

    /// Returns the keyframes of numbers of the material; `None` if none of them changes.
    pub fn keyed(&self) -> Option<&KeyedMaterial> {
        self.keyed.as_deref()
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
        let share = keyed.youngs_modulus.as_ref().map(|curve| curve.value(interval.end) / greatest(curve));
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
            // The lowest mode bends or shears the body, so that its frequency hardly depends on the ratio.
            let eigenvalue = self.pipeline.lowest_eigenvalue.take();
            self.update_shapes();
            if let Some(eigenvalue) = eigenvalue {
                self.pipeline.lowest_eigenvalue = eigenvalue.into();
            }
        }
        if let Some(share) = share {
            self.settings.modulus_share = share;
        }
        self.limit_stiffness_factors(interval.dt);
    }
}

/// Returns the greatest value of a curve.
pub(super) fn greatest(curve: &Curve) -> f64 {
    curve.keys().iter().map(|CurveKey { value, .. }| *value).fold(f64::NEG_INFINITY, f64::max)
}
