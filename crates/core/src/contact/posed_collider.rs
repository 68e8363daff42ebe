//! A collider during a step: its shapes, and the motion of its surface.

use nalgebra::{Matrix3, Point3, Vector3};

use super::deformation::Deformation;
use super::field::Aabb;
use super::shape::PosedShape;
use crate::motion::Pose;
use crate::state::BodyFrame;

/// Collider during a step, in the local frame of a body. Lengths are in cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct PosedCollider<'a> {
    /// Index of the collider.
    pub(super) index: u32,
    /// The shape at the start of the step.
    pub(super) shape_before: PosedShape<'a>,
    /// The shape at the end of the step.
    pub(super) shape: PosedShape<'a>,
    pub(super) friction: f64,
    pub(super) restitution: f64,
    /// Deformation during the step; `None` for a rigid collider.
    pub(super) deformation: Option<Deformation<'a>>,
    /// Poses at the start and at the end of the step.
    pub(super) start: Pose,
    pub(super) end: Pose,
    /// Center of rotation at time 0, in scene units.
    pub(super) center: Point3<f64>,
    pub(super) frame: BodyFrame,
    /// `1 / dt`, in 1/s.
    pub(super) rate: f64,
    /// Motion during the step; `None` for a collider at rest.
    pub(super) motion: Option<SurfaceMotion>,
}

/// Rigid motion of a collider during a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceMotion {
    /// Center of the shape at time 0, in cells.
    pub(super) center: Point3<f64>,
    /// Rotation from the orientation at the end of the step to the orientation at its start.
    pub(super) rotation_to_start: Matrix3<f64>,
    /// Translation from time 0 to the start of the step, in cells.
    pub(super) translation_at_start: Vector3<f64>,
    /// Translation from time 0 to the end of the step, in cells.
    pub(super) translation_at_end: Vector3<f64>,
}

impl PosedCollider<'_> {
    /// Returns the angular velocity of the collider in rad/s, averaged over the step.
    pub(super) fn spin(&self) -> Vector3<f64> {
        self.motion.as_ref().map_or_else(Vector3::zeros, |motion| {
            // The skew part of the rotation from the end to the start is minus the sine of the angle times the axis.
            let r = &motion.rotation_to_start;
            Vector3::new(r.m23 - r.m32, r.m31 - r.m13, r.m12 - r.m21) * (0.5 * self.rate)
        })
    }

    /// Returns where a point that moves with the collider is at the end of the step, if it is at `p` at its start, in
    /// cells.
    pub(super) fn carried(&self, p: &Point3<f64>) -> Point3<f64> {
        if let Some(moved) = self.deformation.and_then(|deformation| deformation.carried(p)) {
            return moved;
        }
        self.motion.as_ref().map_or(*p, |motion| {
            let start = p - motion.center - motion.translation_at_start;
            motion.center + motion.rotation_to_start.tr_mul(&start) + motion.translation_at_end
        })
    }

    /// Returns the greatest displacement of the collider in the step within `bounds`, in cells.
    pub(super) fn greatest_displacement(&self, (center, half): &Aabb) -> f64 {
        let deformed = self.deformation.map_or(0.0, |deformation| deformation.greatest());
        if self.motion.is_none() {
            return deformed;
        }
        // The displacement is linear in the position, so that it is greatest at a corner.
        let corner = |k: usize| {
            let signs = Vector3::from_fn(|a, _| if k >> a & 1 == 1 { 1.0 } else { -1.0 });
            Point3::from(center + half.component_mul(&signs))
        };
        let rigid = Self { deformation: None, ..*self };
        let displacement = |p: Point3<f64>| (rigid.carried(&p) - p).norm();
        deformed + (0..8).map(|k| displacement(corner(k))).fold(0.0, f64::max)
    }

    /// Converts a point in the given position of the collider before the step, in scene units, to the point that it
    /// becomes at the end of the step, in the frame of the body, in cells.
    pub(super) fn posed_point(&self, p: &Point3<f64>) -> Point3<f64> {
        let posed = |pose: &Pose| {
            Point3::from((pose.apply(&self.center, p) - self.frame.origin) / self.frame.cell_size)
        };
        match self.deformation {
            Some(_) => self.carried(&posed(&self.start)),
            None => posed(&self.end),
        }
    }

    /// Converts a point at the end of the step to the given position of the collider, in scene units.
    pub(super) fn rest_point(&self, p: &Point3<f64>) -> Point3<f64> {
        let world = self.frame.origin + p.coords * self.frame.cell_size;
        self.center + self.end.rotation.tr_mul(&(world - self.center - self.end.translate))
    }

    /// Returns the velocity of the point of the collider that is at `p` at the end of the step, averaged over
    /// the step, in cells per second.
    pub(super) fn velocity_at(&self, p: &Point3<f64>) -> Vector3<f64> {
        if let Some(displacement) = self.deformation.and_then(|deformation| deformation.displacement_at(p)) {
            return displacement * self.rate;
        }
        self.motion.as_ref().map_or_else(Vector3::zeros, |motion| {
            let end = p - motion.center;
            let rotated = motion.rotation_to_start * (end - motion.translation_at_end);
            let start = rotated + motion.translation_at_start;
            (end - start) * self.rate
        })
    }
}
