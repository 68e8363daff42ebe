//! Defines reports on the volume of a body and its correction.

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
    /// Volume before the correction. In the result of [`Correction::apply`](super::Correction::apply) with
    /// the scope `regional` it is the volume after the vertices have moved by their own scales.
    pub before: f64,
    /// Volume after the correction.
    pub after: f64,
    /// Scale `lambda` of the correction as a length, in scene units. The field moves the boundary by 1 along
    /// its normals, approximately, so `lambda` is approximately the displacement of the free boundary,
    /// outwards if positive. With the scope `regional` it is the scale that corrects the remaining error
    /// after the scales of the vertices. Where a single scale within the cap does not preserve the volume, it is
    /// the scale of the last pass.
    pub lambda: f64,
    /// `(after - rest) / rest`; 0 for a sliver that broke off, which has no rest volume.
    pub residual: f64,
    /// Whether the magnitude of `residual` exceeds 1e-6. The reason is one of three: a correction that is limited
    /// by `max_correction` below 1; a body that is flat or inside out, so that neither a scale within the cap nor
    /// further passes preserve the volume; or colliders or constrained vertices that leave too little space.
    pub capped: bool,
}

/// Returns [`ComponentReport::residual`] for a volume that exceeds the rest volume by `excess`.
pub(super) fn residual(excess: f64, rest: f64) -> f64 {
    if rest == 0.0 { 0.0 } else { excess / rest }
}

/// Volumes of a body, and the result of its correction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct VolumeReport {
    /// Measure by which the volume is preserved; without correction, the measure that `auto` would choose.
    pub measure: VolumeMeasure,
    /// Total volume at rest by `measure`, in cubed scene units.
    pub rest: f64,
    /// Total volume of the deformed body before the correction, by `measure`.
    pub before: f64,
    /// Total volume of the displayed body, by `measure`: after the correction.
    pub after: f64,
    /// The [`ComponentReport::lambda`] with the greatest magnitude.
    pub lambda: f64,
    /// The [`ComponentReport::residual`] with the greatest magnitude.
    pub residual: f64,
    /// Whether [`ComponentReport::capped`] is set for any component.
    pub capped: bool,
    /// Reports of the components of the lattice.
    pub components: Vec<ComponentReport>,
    /// Total volumes by each available measure: `lattice`, `cells`, and `mesh` if it can use the surface.
    pub volumes: Vec<(VolumeMeasure, Volumes)>,
}

impl VolumeReport {
    pub(super) fn new(
        measure: VolumeMeasure,
        components: Vec<ComponentReport>,
        volumes: Vec<(VolumeMeasure, Volumes)>,
    ) -> Self {
        let total = |value: fn(&ComponentReport) -> f64| components.iter().map(value).sum();
        let greatest = |value: fn(&ComponentReport) -> f64| {
            let greater = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
            components.iter().map(value).fold(0.0, greater)
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

    /// Returns the total volumes by one measure, if it is available.
    pub fn by(&self, measure: VolumeMeasure) -> Option<Volumes> {
        self.volumes.iter().find(|(kind, _)| *kind == measure).map(|(_, volumes)| *volumes)
    }
}
