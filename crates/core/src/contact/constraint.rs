//! Contact constraints. A constraint has the target velocity and the impulse of a contact patch; the impulse
//! lies in the Coulomb friction cone.

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use super::SKIN;
use super::patch::PatchSide;
use super::posed_collider::PosedCollider;
use super::vec4::{Vec4, dot, narrow, wide};

/// Depth in cells up to which samples are not pushed out. The impulses remove a part of it in each step, so that a
/// resting body is not moved against its elastic forces.
pub(super) const SOFT_DEPTH: f64 = 0.01;

/// Part of a gap, of at most [`SOFT_DEPTH`], that a contact closes in a step. With a greater part, contacts that are
/// pressed come and go, and the body trembles.
const GAP_PART: f64 = 0.01;

/// Greatest part of the overlap that a contact removes in a step.
const OVERLAP_PART: f64 = 0.2;

/// Greatest part of the overlap that a contact removes in a second. The speed remains in the body, so that it must
/// not grow as steps become shorter.
const OVERLAP_RATE: f64 = 12.0;

/// Contact point of a patch during a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    /// Position at the end of the step in the local frame of the body, in cells.
    pub(super) position: Point3<f64>,
    /// Distance of the surface beyond `position`, along the normal of the collider, in cells: see
    /// [`SampleCells::offset`](super::samples::SampleCells).
    pub(super) offset: f64,
    /// Depth of the deepest sample at the end of the step below the surface of the collider, in cells; negative
    /// outside.
    pub(super) deepest: f64,
    /// Velocity at the end of the step without contacts, in cells per second.
    pub(super) velocity: Vec4,
    /// Velocity before the step, in cells per second.
    pub(super) velocity_before: Vec4,
    /// Factor of the coefficient of friction.
    pub(super) friction_factor: f64,
    /// The surface, if it is not the one nearest to `position`.
    pub(super) side: Option<PatchSide>,
}

/// Contact of a point of the surface with a collider or a part of a body. Velocities are in cells per second. In a
/// push-out they stand for displacements in cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// Outward unit normal of the touched surface.
    pub(super) normal: Vec4,
    /// Velocity relative to the touched surface, without contacts.
    pub(super) velocity: Vec4,
    /// Tangential velocity before the step, relative to the touched surface.
    pub(super) slip_before: Vec4,
    /// Target velocity: the least normal velocity after the contact. Positive away from the surface.
    pub(super) target: f32,
    /// Speed of approach before the step.
    pub(super) approach: f32,
    /// Coulomb friction coefficient.
    pub(super) friction: f32,
}

/// The touched surface of a collider or a part at a contact point, and the motion of the point relative to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TouchedSurface {
    /// Outward unit normal.
    pub(super) normal: Vector3<f64>,
    /// Distance of the point from the surface before the step.
    pub(super) distance_before: f64,
    /// Velocity at the end of the step without contacts.
    pub(super) velocity: Vector3<f64>,
    /// Velocity before the step.
    pub(super) velocity_before: Vector3<f64>,
    pub(super) friction: f64,
    pub(super) restitution: f64,
    /// Least speed of approach that bounces.
    pub(super) min_bounce: f64,
}

impl TouchedSurface {
    /// Returns the contact, with velocities divided by the cell size of the problem. A point that starts the step
    /// outside the skin and approaches faster than `min_bounce` separates at the speed of approach times the
    /// restitution. Otherwise `target` returns the target velocity, by the speed of approach.
    pub(super) fn contact(&self, skin: f64, cell_size: f64, target: impl FnOnce(f64) -> f64) -> Contact {
        let &Self { normal, velocity, velocity_before, .. } = self;
        let approach = -velocity_before.dot(&normal);
        let target = match self.distance_before > skin && approach > self.min_bounce {
            true => self.restitution * approach,
            false => target(approach),
        };
        Contact {
            normal: narrow(normal),
            velocity: narrow(velocity / cell_size),
            slip_before: narrow((velocity_before + normal * approach) / cell_size),
            target: (target / cell_size) as f32,
            approach: (approach / cell_size) as f32,
            // Keeps the coefficient finite: infinity times an impulse of zero is NaN.
            friction: self.friction.min(f64::from(f32::MAX)) as f32,
        }
    }
}

impl Contact {
    /// Returns the greatest normal velocity after the contact at which the energy is taken not to increase.
    pub(super) fn limit(&self) -> f32 {
        self.approach.max(self.target)
    }

    /// Returns the contact with velocities times `factor`.
    pub(super) fn scaled(&self, factor: f32) -> Self {
        Self {
            velocity: self.velocity * factor,
            slip_before: self.slip_before * factor,
            target: self.target * factor,
            approach: self.approach * factor,
            ..*self
        }
    }
}

impl SurfacePoint {
    /// Computes the contact with a collider at the end of a step of `dt` seconds.
    ///
    /// The target velocity of a point that does not [bounce](TouchedSurface::contact) depends on the motion before the
    /// step:
    ///
    /// * The deepest sample of a patch that overlaps by up to [`SOFT_DEPTH`] moves out by [`OVERLAP_PART`] of its
    ///   depth in the step, or [`OVERLAP_RATE`] of it in a second if that is less. Deeper ones are pushed out: see
    ///   `stage`.
    /// * A sample outside closes [`GAP_PART`] of its gap. One that moved away before the step may
    ///   approach at up to the speed at which it moved away, because this adds no energy. No sample enters the
    ///   collider.
    ///
    /// `min_bounce` is the least speed of approach that bounces, in cells per second.
    pub(super) fn contact(&self, collider: &PosedCollider<'_>, dt: f64, min_bounce: f64) -> Contact {
        let velocity = wide(&self.velocity);
        let nearest = || PatchSide {
            normal: collider.shape.signed_distance(&self.position).normal,
            distance_before: collider.shape_before.signed_distance(&(self.position - velocity * dt)).distance
                + self.offset,
        };
        let PatchSide { normal, distance_before } = self.side.unwrap_or_else(nearest);
        let surface = collider.velocity_at(&self.position);
        let &PosedCollider { friction, restitution, .. } = collider;
        let (velocity, velocity_before) = (velocity - surface, wide(&self.velocity_before) - surface);
        let touched = TouchedSurface {
            normal,
            distance_before,
            velocity,
            velocity_before,
            friction: friction * self.friction_factor,
            restitution,
            min_bounce,
        };
        touched.contact(SKIN, 1.0, |approach| {
            // The least distance of a sample before the step.
            let distance = (-self.deepest - dt * velocity.dot(&normal)).min(distance_before);
            match distance {
                // Samples that are deeper are pushed out.
                _ if distance < -SOFT_DEPTH => 0.0,
                _ if distance < 0.0 => -distance * OVERLAP_RATE.min(OVERLAP_PART / dt),
                _ => approach.min(-GAP_PART * distance.min(SOFT_DEPTH) / dt).max(-distance / dt),
            }
        })
    }
}

/// Returns the weighted mean of the vectors of some vertices.
///
/// * `vertices`: pairs of row (index into `SampleCells::vertices`) and weight.
/// * `vector`: returns the vector of a row.
pub(super) fn mean(vertices: impl Iterator<Item = (u32, f32)>, vector: impl Fn(usize) -> Vec4) -> Vec4 {
    vertices.fold(Vec4::zeros(), |sum, (row, weight)| sum + vector(row as usize) * weight)
}

/// Returns the weighted mean of the factors of some vertices: 1 if the list of factors of the rows is empty.
/// `vertices`: see [`mean`].
pub(super) fn mean_factor(vertices: impl Iterator<Item = (u32, f32)>, factors: &[f32]) -> f64 {
    if factors.is_empty() {
        return 1.0;
    }
    vertices.map(|(row, weight)| factors[row as usize] * weight).sum::<f32>().into()
}

/// Returns the weighted mean of the positions of some vertices. `vertices`: see [`mean`].
pub(super) fn mean_position(
    vertices: impl Iterator<Item = (u32, f32)> + Clone,
    positions: &[Vec4],
) -> Point3<f64> {
    // Sums offsets from the first vertex. They are small, so f32 is accurate at any distance from the origin.
    let first = vertices.clone().next().map_or_else(Vec4::zeros, |(row, _)| positions[row as usize]);
    let offset = mean(vertices, |row| positions[row] - first);
    (wide(&first) + wide(&offset)).into()
}

/// Contact constraint: a contact and its accumulated impulses.
#[derive(Clone, Debug)]
pub(super) struct ContactConstraint {
    pub(super) contact: Contact,
    /// Range in `Solver::links` of the links of this constraint.
    pub(super) links: Range<usize>,
    /// Velocity change of the contact point if every constraint has a unit impulse in the same direction; see
    /// `Solver::find_responses`. It is used in place of the effective inverse mass.
    response: f32,
    /// `1 / response`.
    inverse_response: f32,
    pub(super) normal_impulse: f32,
    pub(super) friction_impulse: Vec4,
}

impl ContactConstraint {
    /// Creates a constraint with impulses of zero.
    pub(super) fn new(contact: Contact, links: Range<usize>) -> Self {
        let (normal_impulse, friction_impulse) = (0.0, Vec4::zeros());
        Self { contact, links, response: 0.0, inverse_response: 0.0, normal_impulse, friction_impulse }
    }

    /// Sets the velocity change of the contact point if every constraint has a unit impulse.
    pub(super) fn set_response(&mut self, response: f32) {
        self.response = response;
        // Zero if no impulse moves the point.
        self.inverse_response = if response > 0.0 { 1.0 / response } else { 0.0 };
    }

    /// Returns the magnitude of the velocity change of the contact point if every constraint has this
    /// impulse.
    #[inline(always)]
    pub(super) fn speed_change(&self, impulse: &Vec4) -> f32 {
        dot(impulse, impulse).sqrt() * self.response
    }

    /// Returns the sum of the normal impulse and the friction impulse.
    #[inline(always)]
    pub(super) fn impulse(&self) -> Vec4 {
        self.friction_impulse + self.contact.normal * self.normal_impulse
    }

    /// Sets the impulses: the part of `impulse` along the normal, if it pushes, and the friction in the Coulomb
    /// friction cone.
    pub(super) fn set_impulse(&mut self, impulse: &Vec4) {
        let Contact { normal, friction, .. } = &self.contact;
        let along = dot(impulse, normal);
        let tangential = impulse - normal * along;
        self.normal_impulse = along.max(0.0);
        let (length, limit) = (dot(&tangential, &tangential).sqrt(), friction * self.normal_impulse);
        self.friction_impulse = if length > limit { tangential * (limit / length) } else { tangential };
    }

    /// Updates the impulses and returns the change of their sum.
    ///
    /// The normal impulse is at least 0, and the friction impulse lies in the Coulomb friction cone.
    ///
    /// * `velocity`: current velocity of the contact point, relative to the touched surface.
    /// * `over_relaxation`: multiplies the change of the normal impulse, but not of the friction impulse.
    #[inline(always)]
    pub(super) fn update_impulses(&mut self, velocity: &Vec4, over_relaxation: f32) -> Vec4 {
        let Contact { normal, slip_before, target, friction, .. } = &self.contact;
        let inverse = self.inverse_response;
        let normal_velocity = dot(velocity, normal);
        // A contact pushes and never pulls: the accumulated normal impulse is clamped at zero.
        let impulse = (self.normal_impulse + over_relaxation * (target - normal_velocity) * inverse).max(0.0);
        let mut change = normal * (impulse - self.normal_impulse);
        self.normal_impulse = impulse;
        if *friction > 0.0 {
            // The slip (tangential velocity) that the point would have without friction.
            let mut free_slip = *velocity;
            free_slip += normal * -normal_velocity;
            free_slip += self.friction_impulse * -self.response;
            let slip_change = slowest_slip(&free_slip, slip_before) - free_slip;
            // Coulomb friction cone: clamps the friction impulse to `friction` times the normal impulse.
            let (max_friction, needed) =
                (friction * impulse, dot(&slip_change, &slip_change).sqrt() * inverse);
            let scale = if needed > max_friction { inverse * (max_friction / needed) } else { inverse };
            let friction_impulse = slip_change * scale;
            change += friction_impulse;
            change -= self.friction_impulse;
            self.friction_impulse = friction_impulse;
        }
        change
    }
}

/// Returns the slowest slip that friction can cause without adding energy.
///
/// `free` is the slip without friction, and `before` is the slip before the step. A friction impulse f that
/// changes the slip from `free` to u does the work f . (u + `before`) / 2. It does no positive work if and
/// only if u lies in the ball whose diameter runs from `free` to -`before`. Zero usually lies in this ball.
/// It does not if the point reverses its direction during the step, for example while it vibrates.
#[inline(always)]
fn slowest_slip(free: &Vec4, before: &Vec4) -> Vec4 {
    if dot(free, before) >= 0.0 {
        return Vec4::zeros();
    }
    // The ball has the center `double_center` / 2 and the diameter |`diameter_vector`|. Zero is outside it.
    let (double_center, diameter_vector) = (free - before, free + before);
    let (distance, diameter) =
        (dot(&double_center, &double_center).sqrt(), dot(&diameter_vector, &diameter_vector).sqrt());
    // Stops the slip if the squares overflow f32.
    if !distance.is_finite() {
        return Vec4::zeros();
    }
    double_center.map(|x| 0.5 * x * (1.0 - diameter / distance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slowest_slip_adds_no_energy() {
        let x = |x: f32| Vec4::new(x, 0.0, 0.0, 0.0);
        let free = x(2.0);
        for (before, expected) in [(0.0, 0.0), (5.0, 0.0), (-0.5, 0.5), (-1.5, 1.5), (-2.0, 2.0), (-7.0, 2.0)]
        {
            let slip = slowest_slip(&free, &x(before));
            assert!((slip - x(expected)).norm() < 1e-6, "{before}: {slip:?}");
        }
        assert_eq!(slowest_slip(&x(1e30), &x(-1e20)), Vec4::zeros(), "squares overflow f32");
        // In two dimensions: the slip lies on the ball's surface, at the point nearest to zero.
        let slip = slowest_slip(&free, &Vec4::new(-1.0, 1.0, 0.0, 0.0));
        let work = (slip.x - 2.0) * (slip.x - 1.0) + slip.y * (slip.y + 1.0);
        assert!(work.abs() < 1e-6 && dot(&slip, &slip) < 1.0, "{slip:?}");
    }
}
