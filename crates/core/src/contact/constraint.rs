//! Contact constraints: the velocity that a patch of the surface must reach at a collider, and the impulse of one
//! constraint alone.

use std::ops::Range;

use nalgebra::Point3;

use super::SKIN;
use super::collider::PosedCollider;
use super::vec4::{Vec4, dot, narrow, wide};

/// A point of the surface during a step: its place at the end, local, in cells, its velocity, in cells per second, and its
/// velocity before the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    pub(super) place: Point3<f64>,
    pub(super) velocity: Vec4,
    pub(super) velocity_before: Vec4,
}

/// The contact of a point of the surface with a collider.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// Outward normal of the collider.
    pub(super) normal: Vec4,
    /// Velocity relative to the collider's surface.
    pub(super) velocity: Vec4,
    /// Tangential velocity before the step, relative to the collider's surface.
    pub(super) slip_before: Vec4,
    /// Least normal velocity after the contact.
    pub(super) target: f32,
    /// Greatest normal velocity after the contact that adds no energy, the speed of approach; at least `target`.
    pub(super) limit: f32,
    /// Coulomb coefficient.
    pub(super) friction: f32,
    /// Depth of the deepest sample, in cells; negative outside the collider.
    pub(super) depth: f32,
}

impl SurfacePoint {
    /// The contact with a collider at the end of a step of `dt` seconds.
    ///
    /// A point that comes from outside faster than `quiet`, in cells per second, leaves as fast as restitution says.
    /// Other points stop. A point that was leaving before the step and was turned back since may return as fast as it
    /// left, which keeps its energy, but not into the collider.
    ///
    /// * `depth`: of the deepest sample, in cells.
    pub(super) fn contact(&self, collider: &PosedCollider, depth: f64, dt: f64, quiet: f64) -> Contact {
        let velocity = wide(&self.velocity);
        let normal = collider.shape.signed_distance(&self.place).normal;
        let distance_before = collider.shape_before.signed_distance(&(self.place - velocity * dt)).distance;
        let surface = collider.velocity_at(&self.place);
        let velocity_before = wide(&self.velocity_before) - surface;
        let approach = -velocity_before.dot(&normal);
        let target = if distance_before > SKIN && approach > quiet {
            collider.restitution * approach
        } else {
            approach.min(0.0).max(-distance_before.max(0.0) / dt)
        };
        Contact {
            normal: narrow(normal),
            velocity: narrow(velocity - surface),
            slip_before: narrow(velocity_before + normal * approach),
            target: target as f32,
            limit: approach.max(target) as f32,
            // Finite: infinity times an impulse of zero is NaN.
            friction: collider.friction.min(f64::from(f32::MAX)) as f32,
            depth: depth as f32,
        }
    }
}

/// The weighted mean of a vector of some rows.
pub(super) fn mean(vertices: impl Iterator<Item = (u32, f32)>, vector: impl Fn(usize) -> Vec4) -> Vec4 {
    vertices.fold(Vec4::zeros(), |sum, (row, weight)| sum + vector(row as usize) * weight)
}

/// The weighted mean of the places of some rows.
pub(super) fn mean_place(vertices: impl Iterator<Item = (u32, f32)> + Clone, places: &[Vec4]) -> Point3<f64> {
    // Relative to one of them: a small number in f32, wherever the body is.
    let from = vertices.clone().next().map_or_else(Vec4::zeros, |(row, _)| places[row as usize]);
    let offset = mean(vertices, |row| places[row] - from);
    (wide(&from) + wide(&offset)).into()
}

/// A contact and its impulses.
#[derive(Clone, Debug)]
pub(super) struct ContactConstraint {
    pub(super) contact: Contact,
    /// Its links among those of the solver.
    pub(super) links: Range<usize>,
    /// Velocity for a unit of impulse, and its inverse.
    response: f32,
    rate: f32,
    pub(super) normal_impulse: f32,
    pub(super) friction_impulse: Vec4,
}

impl ContactConstraint {
    /// A constraint without impulses.
    pub(super) fn new(contact: Contact, links: Range<usize>) -> Self {
        let (normal_impulse, friction_impulse) = (0.0, Vec4::zeros());
        Self { contact, links, response: 0.0, rate: 0.0, normal_impulse, friction_impulse }
    }

    pub(super) fn set_response(&mut self, response: f32) {
        self.response = response;
        self.rate = 1.0 / response;
    }

    /// The speed that an impulse causes.
    #[inline(always)]
    pub(super) fn speed(&self, impulse: &Vec4) -> f32 {
        dot(impulse, impulse).sqrt() * self.response
    }

    /// The whole impulse.
    #[inline(always)]
    pub(super) fn impulse(&self) -> Vec4 {
        self.friction_impulse + self.contact.normal * self.normal_impulse
    }

    /// Corrects the impulses for a velocity, the normal impulse times `over_relaxation`; returns the change.
    #[inline(always)]
    pub(super) fn correct(&mut self, velocity: &Vec4, over_relaxation: f32) -> Vec4 {
        let Contact { normal, slip_before, target, friction, .. } = &self.contact;
        let rate = self.rate;
        let leaving = dot(velocity, normal);
        let impulse = (self.normal_impulse + over_relaxation * (target - leaving) * rate).max(0.0);
        let mut change = normal * (impulse - self.normal_impulse);
        self.normal_impulse = impulse;
        if *friction > 0.0 {
            let mut free = *velocity;
            free += normal * -leaving;
            free += self.friction_impulse * -self.response;
            let wanted = slowest_slip(&free, slip_before) - free;
            let (limit, length) = (friction * impulse, dot(&wanted, &wanted).sqrt() * rate);
            let scale = if length > limit { rate * (limit / length) } else { rate };
            let wanted = wanted * scale;
            change += wanted;
            change -= self.friction_impulse;
            self.friction_impulse = wanted;
        }
        change
    }
}

/// The slowest slip that friction may cause without adding energy, for a point that slips with `free` without friction
/// and slipped with `before` before the step.
///
/// An impulse f that changes the slip from `free` to u does the work f . (u + before)/2: it takes energy from the point
/// if u lies in the ball with the diameter from `free` to -`before`. Zero mostly lies in this ball; it does not where the
/// point is about to turn back, for instance while it vibrates.
#[inline(always)]
fn slowest_slip(free: &Vec4, before: &Vec4) -> Vec4 {
    if dot(free, before) >= 0.0 {
        return Vec4::zeros();
    }
    // Twice the center of the ball, and its diameter: the center is farther from zero than the radius.
    let (center, across) = (free - before, free + before);
    let (distance, diameter) = (dot(&center, &center).sqrt(), dot(&across, &across).sqrt());
    if !distance.is_finite() {
        return Vec4::zeros();
    }
    center.map(|x| 0.5 * x * (1.0 - diameter / distance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_on_a_point_that_turns_back_adds_no_energy() {
        let x = |x: f32| Vec4::new(x, 0.0, 0.0, 0.0);
        let free = x(2.0);
        for (before, slowed) in [(0.0, 0.0), (5.0, 0.0), (-0.5, 0.5), (-1.5, 1.5), (-2.0, 2.0), (-7.0, 2.0)] {
            let slip = slowest_slip(&free, &x(before));
            assert!((slip - x(slowed)).norm() < 1e-6, "{before}: {slip:?}");
        }
        assert_eq!(slowest_slip(&x(1e30), &x(-1e20)), Vec4::zeros(), "squares beyond f32");
        // In the plane: on the ball, in which no point is slower.
        let slip = slowest_slip(&free, &Vec4::new(-1.0, 1.0, 0.0, 0.0));
        let work = (slip.x - 2.0) * (slip.x - 1.0) + slip.y * (slip.y + 1.0);
        assert!(work.abs() < 1e-6 && dot(&slip, &slip) < 1.0, "{slip:?}");
    }
}
