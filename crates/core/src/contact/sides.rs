//! Finds the side of a shape from which a sample came.
//!
//! The nearest surface of a thin shape may be the wrong one: a fast sample passes the middle of a plate, or the whole
//! plate, in one step. The side follows from the path of the sample in the step, in the frame of the moving shape. The
//! first point in which the path meets the surface gives the normal of the contact, and the plane there its distance. A
//! sample that is still behind the surface after the step has a *side point*: the point of the surface from which its
//! next path begins. (Zilles & Salisbury 1995 use such a point, the god-object, for haptic rendering.) The side points
//! are part of the state.
//!
//! A shape with a thickness is met at its surface without the thickness: in the layer around this surface, the nearest
//! surface is the right one.

use nalgebra::{Point3, Vector3};

use super::shape::PosedShape;

/// Distance in cells by which a path begins outside the surface. A resting sample is inside by less than this distance.
const LIFT: f64 = 1e-3;

/// Least depth in cells of a sample with a side point: greater than the overlap of a sample at rest.
const LEAST_DEPTH: f64 = 1e-3;

/// Least product of the normal where a path meets the surface and the normal of the nearest surface, for which the
/// nearest surface is the right one.
const AGREEMENT: f64 = 0.3;

/// Half thickness of a shape in cells below which the side always counts, because the push-out of a single step or a
/// slow motion may pass the middle.
const THIN: f64 = 0.5;

/// Greatest motion in a step, relative to the half thickness, for which the nearest surface is the right one.
const SAFE_MOTION: f64 = 0.25;

/// The side point of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Side {
    /// Index of the collider.
    pub(super) collider: u32,
    /// Index of the sample: its block times eight plus its lane.
    pub(super) sample: u32,
    /// The side point, in scene units, in the given position of the collider.
    pub(super) point: [f64; 3],
}

impl Side {
    /// Checks deserialized data.
    pub(crate) fn is_valid(&self) -> bool {
        self.point.iter().all(|x| x.is_finite())
    }
}

/// Contact of a sample, with lengths in cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct SidedContact {
    /// Signed distance from the surface on the side of the sample.
    pub(super) distance: f64,
    /// Unit normal of this surface.
    pub(super) normal: Vector3<f64>,
    /// Signed distance before the step.
    pub(super) before: f64,
    /// Whether this surface is not the nearest one.
    pub(super) has_passed: bool,
}

impl PosedShape<'_> {
    /// Returns whether contacts need the sides of the samples, if samples move by at most `motion` cells relative to
    /// the shape.
    pub(super) fn needs_sides(&self, motion: f64) -> bool {
        let half_thickness = match self {
            Self::Plane { .. } => return false,
            Self::Mesh(_) => return true,
            Self::Sphere { radius, .. } | Self::Capsule { radius, .. } => *radius,
            Self::Box { half, .. } => half.min(),
        };
        half_thickness < THIN || motion > SAFE_MOTION * half_thickness
    }

    /// Returns the contact of a sample that moved from `start` to `end` relative to the shape, or `None` if it does not
    /// touch.
    pub(super) fn sided_contact(
        &self,
        start: &Point3<f64>,
        end: &Point3<f64>,
        skin: f64,
    ) -> Option<SidedContact> {
        let near = self.signed_distance(end);
        let displacement = end - start;
        let regular = |normal: Vector3<f64>| {
            let (distance, before) = (near.distance, near.distance - normal.dot(&displacement));
            (distance <= skin).then_some(SidedContact { distance, normal, before, has_passed: false })
        };
        let (is_shell, height) = (self.shell() > 0.0, self.shell() + self.thickness());
        // Too far from the surface to have crossed it. The distance from the mid-surface of a shell is not negative.
        if (near.distance + height).abs() > displacement.norm() + 2.0 * LIFT {
            return regular(near.normal);
        }
        let start = if is_shell { Some(*start) } else { self.outside(start) };
        let Some(start) = start else { return regular(near.normal) };
        let Some((fraction, normal)) = self.first_hit(&start, end) else {
            // On the mid-surface of a shell the normal may have either sign.
            let is_flipped =
                is_shell && near.distance + height < LIFT && near.normal.dot(&(start - end)) < 0.0;
            return regular(if is_flipped { -near.normal } else { near.normal });
        };
        if !is_shell && near.distance <= skin && near.normal.dot(&normal) > AGREEMENT {
            return regular(near.normal);
        }
        let hit = start + (end - start) * fraction;
        let distance = normal.dot(&(end - hit)) - height;
        let before = normal.dot(&(start - hit)) - height;
        Some(SidedContact { distance, normal, before, has_passed: true })
    }

    /// Returns the side point of a sample at `end` with this contact, or `None` if it needs none.
    pub(super) fn side_point(&self, end: &Point3<f64>, contact: &SidedContact) -> Option<Point3<f64>> {
        let (shell, thickness) = (self.shell(), self.thickness());
        let least = if shell > 0.0 { 0.5 * shell } else { LEAST_DEPTH };
        let distance = contact.distance + thickness;
        if distance > -least || self.plane().is_some() {
            return None;
        }
        // The point of the plane of the contact, then the nearest point of the surface.
        let point = end - contact.normal * (distance - LIFT);
        let near = self.signed_distance(&point);
        let is_same_side = near.normal.dot(&contact.normal) > AGREEMENT;
        Some(if is_same_side { point - near.normal * (near.distance + thickness - LIFT) } else { point })
    }

    /// Returns where the segment from `a`, a point outside, to `b` first meets the surface without the thickness: the
    /// fraction of the segment, and the unit normal on the side of `a`.
    fn first_hit(&self, a: &Point3<f64>, b: &Point3<f64>) -> Option<(f64, Vector3<f64>)> {
        if let Self::Mesh(mesh) = self {
            return mesh.first_hit(a, b);
        }
        let displacement = b - a;
        let length = displacement.norm();
        let direction = displacement.try_normalize(0.0)?;
        let [first, _] = self.overlap_along(a, &direction, 0.0)?;
        (0.0..=length).contains(&first).then(|| {
            let hit = a + direction * first;
            (first / length, self.signed_distance(&hit).normal)
        })
    }

    /// Returns a point of a path outside a solid: the point itself, or the point outside the surface of a point
    /// slightly inside. `None` if the point is deeper.
    fn outside(&self, point: &Point3<f64>) -> Option<Point3<f64>> {
        let near = self.signed_distance(point);
        let distance = near.distance + self.thickness();
        if distance < -2.0 * LIFT {
            return None;
        }
        Some(point + near.normal * (LIFT - distance).max(0.0))
    }

    /// Returns the distance of the shape from its mid-surface, if it is a shell, or else zero.
    fn shell(&self) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.shell,
            _ => 0.0,
        }
    }

    /// Returns the distance of the surface from that without the thickness, where the two differ in more than their
    /// size.
    fn thickness(&self) -> f64 {
        match self {
            Self::Box { thickness, .. } => *thickness,
            Self::Mesh(mesh) => mesh.thickness,
            _ => 0.0,
        }
    }
}
