//! Bounds the clearance between groups of samples: see `gaps`.

use nalgebra::{Point3, Vector3};

use super::bounds::Bounds;

/// Product of two normals above which the clearance grows, for the same reason, by [`GROWTH`] times the difference. A
/// surface at a right angle to the other one can move into it sideways.
pub(super) const FACING: f32 = 0.25;

/// Growth of the clearance with the product of the normals, and with the distance by which a sample of the other surface
/// lies in front of the own one sideways: the gap there is one to another side of the other body.
pub(super) const GROWTH: f32 = 4.0;

/// Greatest overlap. Samples that are deeper face each other through a thin body.
pub(super) const MAX_OVERLAP: f32 = 0.25;

/// A sphere that contains samples, and another one that contains their normals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patch {
    center: Vector3<f32>,
    radius: f32,
    normal: Vector3<f32>,
    spread: f32,
}

impl Patch {
    /// Returns the patch of one sample.
    pub(super) fn of_sample(position: [f32; 3], normal: [f32; 3]) -> Self {
        Self { center: position.into(), normal: normal.into(), radius: 0.0, spread: 0.0 }
    }

    /// Returns the patch of samples with these positions and normals.
    pub(super) fn of(samples: impl Iterator<Item = ([f32; 3], [f32; 3])> + Clone) -> Self {
        let (mut bounds, mut sum) = (Bounds::EMPTY, Vector3::zeros());
        for (position, normal) in samples.clone() {
            bounds = bounds.union(&Bounds::of([Point3::from(position).map(f64::from)]));
            sum += Vector3::from(normal);
        }
        let (center, radius) = bounds.sphere();
        let normal = sum.try_normalize(0.0).unwrap_or_default();
        let spread = samples.map(|(_, other)| (Vector3::from(other) - normal).norm()).fold(0.0, f32::max);
        Self { center, radius, normal, spread }
    }

    /// Returns a lower bound of the clearances of the samples to those of a patch of another surface. The lengths are
    /// the distance up to which samples are opposite, and the sum of the thicknesses of the bodies.
    pub(super) fn least_clearance(&self, other: &Self, [opposite, thickness]: [f32; 2]) -> f32 {
        // The clearance of the centers, less the most by which positions and normals within the spheres change each term.
        let offset = self.center - other.center;
        let (gap, facing) = (offset.dot(&other.normal), self.normal.dot(&other.normal));
        let aside = (offset.norm_squared() - gap * gap).max(0.0).sqrt();
        let radius = self.radius + other.radius;
        let length = gap.abs() + aside + radius;
        let tilt = other.spread * length;
        if gap + radius + tilt < -MAX_OVERLAP {
            return f32::INFINITY;
        }
        let excess = (aside - radius - 2.0 * tilt - opposite).max(0.0);
        let beside = gap * facing - offset.dot(&self.normal) - radius - 2.0 * (tilt + self.spread * length);
        let turned = facing - self.spread - other.spread - FACING;
        0.5 * (gap - thickness - radius - tilt).max(0.0)
            + excess
            + GROWTH * (turned.max(0.0) + beside.max(0.0))
    }
}
