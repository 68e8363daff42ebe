//! Results of the correction.

use super::VolumeMeasure;

/// Volumes in cubed units of length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Volumes {
    /// At rest.
    pub rest: f64,
    /// Of the deformed body, before correction.
    pub before: f64,
    /// After correction.
    pub after: f64,
}

/// What the correction did to one component of the lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ComponentReport {
    /// Volume at rest, in cubed units of length.
    pub rest: f64,
    /// Volume before correction; of [`Correction::apply`](super::Correction::apply) with the scope `regional` that
    /// which the regions leave.
    pub before: f64,
    /// Volume after correction.
    pub after: f64,
    /// Scale of the correction, as a length: how far a free boundary vertex moved along its normal, outwards if
    /// positive. With the scope `regional` that of what the regions leave.
    pub lambda: f64,
    /// `(after - rest) / rest`.
    pub residual: f64,
    /// Whether the volume is still off by more than a millionth: no scale within the cap keeps it, and `lambda` is the one
    /// that comes nearest; or colliders leave no way out.
    pub capped: bool,
}

/// The volume of a body, and what the correction did to it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct VolumeReport {
    /// The measure that is kept; without correction the one that `auto` would keep.
    pub measure: VolumeMeasure,
    /// Volume at rest by that measure, in cubed units of length, all components together.
    pub rest: f64,
    /// Volume of the deformed body.
    pub before: f64,
    /// Volume after correction; without correction the same as before.
    pub after: f64,
    /// [`ComponentReport::lambda`] of greatest magnitude.
    pub lambda: f64,
    /// [`ComponentReport::residual`] of greatest magnitude.
    pub residual: f64,
    /// Whether any component is capped.
    pub capped: bool,
    /// Each component of the lattice.
    pub components: Vec<ComponentReport>,
    /// The volume by each measure that the body has: `lattice`, `cells`, and `mesh` if its surface is closed.
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

    /// The volumes by one measure, if the body has it.
    pub fn by(&self, measure: VolumeMeasure) -> Option<Volumes> {
        self.volumes.iter().find(|(kind, _)| *kind == measure).map(|(_, volumes)| *volumes)
    }
}
