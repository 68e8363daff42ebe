//! Reports on the volume of a body and its correction.

use super::VolumeMeasure;

/// Volumes of a body by one measure, in cubed scene units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Volumes {
    /// Volume at rest.
    pub rest: f64,
    /// Volume of the deformed body before the correction.
    pub before: f64,
    /// Volume after the correction.
    pub after: f64,
}

/// Result of the correction for one component of the lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ComponentReport {
    /// Volume at rest, in cubed scene units.
    pub rest: f64,
    /// Volume before the correction. [`Correction::apply`](super::Correction::apply) with the scope
    /// `regional` reports the volume after the regional scales.
    pub before: f64,
    /// Volume after the correction.
    pub after: f64,
    /// Scale `lambda` of the correction as a length, in scene units: the displacement of a free boundary
    /// vertex along its normal, outwards if positive. With the scope `regional` it is the scale of
    /// the remaining correction.
    pub lambda: f64,
    /// `(after - rest) / rest`.
    pub residual: f64,
    /// Whether the residual exceeds 1e-6. Either no scale within the cap preserves the volume, and `lambda`
    /// is the scale of least residual, or colliders prevent the correction.
    pub capped: bool,
}

/// Volume of a body, and the result of its correction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct VolumeReport {
    /// Measure whose value is kept; without correction the measure that `auto` would choose.
    pub measure: VolumeMeasure,
    /// Total volume at rest by that measure, in cubed scene units.
    pub rest: f64,
    /// Total volume of the deformed body before the correction.
    pub before: f64,
    /// Total volume after the correction; without correction equal to `before`.
    pub after: f64,
    /// [`ComponentReport::lambda`] of greatest magnitude.
    pub lambda: f64,
    /// [`ComponentReport::residual`] of greatest magnitude.
    pub residual: f64,
    /// Whether any component is capped.
    pub capped: bool,
    /// Reports of the components of the lattice.
    pub components: Vec<ComponentReport>,
    /// Volumes by each available measure: `lattice`, `cells`, and `mesh` if the surface is usable.
    pub volumes: Vec<(VolumeMeasure, Volumes)>,
}

impl VolumeReport {
    pub(super) fn new(
        measure: VolumeMeasure,
        components: Vec<ComponentReport>,
        volumes: Vec<(VolumeMeasure, Volumes)>,
    ) -> Self {
        let total = |part: fn(&ComponentReport) -> f64| components.iter().map(part).sum();
        let greatest = |part: fn(&ComponentReport) -> f64| {
            let greater = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
            components.iter().map(part).fold(0.0, greater)
        };
        Self {
            measure,
            rest: total(|c| c.rest),
            before: total(|c| c.before),
            after: total(|c| c.after),
            lambda: greatest(|c| c.lambda),
            residual: greatest(|c| c.residual),
            capped: components.iter().any(|c| c.capped),
            components,
            volumes,
        }
    }

    /// Returns the volumes by one measure, if it is available.
    pub fn by(&self, measure: VolumeMeasure) -> Option<Volumes> {
        self.volumes.iter().find(|(kind, _)| *kind == measure).map(|(_, volumes)| *volumes)
    }
}
