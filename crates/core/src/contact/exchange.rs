//! What one contact asks for, and the impulse that it exchanges for that.

use std::ops::Range;

use super::quad::{Quad, add, dot};

/// A point of the surface at a collider: a weighted mean of lattice vertices.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Contact {
    /// Outward normal of the collider.
    pub(super) normal: Quad,
    /// Velocity relative to the collider's surface.
    pub(super) velocity: Quad,
    /// The velocity across the normal with which the step began, relative to the collider's surface.
    pub(super) came: Quad,
    /// Least velocity along the normal to leave with.
    pub(super) leave: f32,
    /// Velocity along the normal up to which leaving gives no energy, the speed with which it came; at least `leave`.
    pub(super) most: f32,
    /// Greatest impulse across the normal for one along it.
    pub(super) friction: f32,
    /// Depth of its deepest sample, in cells; negative outside the collider.
    pub(super) depth: f32,
}

/// A contact and the impulses that it exchanges.
#[derive(Clone, Debug)]
pub(super) struct Exchange {
    pub(super) contact: Contact,
    /// Its links among those of the solver.
    pub(super) links: Range<usize>,
    /// Velocity for a unit of impulse, and its inverse.
    response: f32,
    rate: f32,
    /// The impulses along the normal and across it.
    pub(super) along: f32,
    pub(super) across: Quad,
}

impl Exchange {
    /// No impulse yet.
    pub(super) fn new(contact: Contact, links: Range<usize>) -> Self {
        Self { contact, links, response: 0.0, rate: 0.0, along: 0.0, across: [0.0; 4] }
    }

    pub(super) fn set_response(&mut self, response: f32) {
        self.response = response;
        self.rate = 1.0 / response;
    }

    /// The change of velocity that an impulse makes.
    #[inline(always)]
    pub(super) fn effect(&self, impulse: &Quad) -> f32 {
        dot(impulse, impulse).sqrt() * self.response
    }

    /// The impulses as a vector.
    #[inline(always)]
    pub(super) fn impulse(&self) -> Quad {
        let mut impulse = self.across;
        add(&mut impulse, &self.contact.normal, self.along);
        impulse
    }

    /// Changes the impulses, as the velocity asks for, that along the normal by `far` times as much; returns the
    /// change.
    #[inline(always)]
    pub(super) fn change(&mut self, velocity: &Quad, far: f32) -> Quad {
        let Contact { normal, came, leave, friction, .. } = &self.contact;
        let rate = self.rate;
        let leaving = dot(velocity, normal);
        let along = (self.along + far * (leave - leaving) * rate).max(0.0);
        let mut change = [0.0; 4];
        add(&mut change, normal, along - self.along);
        self.along = along;
        if *friction > 0.0 {
            let mut free = *velocity;
            add(&mut free, normal, -leaving);
            add(&mut free, &self.across, -self.response);
            let mut across = slowest(&free, came);
            add(&mut across, &free, -1.0);
            let (limit, length) = (friction * along, dot(&across, &across).sqrt() * rate);
            let scale = if length > limit { rate * (limit / length) } else { rate };
            across = across.map(|x| x * scale);
            add(&mut change, &across, 1.0);
            add(&mut change, &self.across, -1.0);
            self.across = across;
        }
        change
    }
}

/// The slowest slip to which friction may bring a point that would slip with `free` and came with `came`, without
/// giving it energy.
///
/// An impulse f that changes the slip from `free` to u does the work f . (u + came)/2: none is done on the point
/// where u lies in the ball with the diameter from `free` to -`came`. Mostly that holds zero; not where the point is
/// about to turn back, as one that vibrates.
#[inline(always)]
fn slowest(free: &Quad, came: &Quad) -> Quad {
    if dot(free, came) >= 0.0 {
        return [0.0; 4];
    }
    let (mut middle, mut across) = (*free, *free);
    add(&mut middle, came, -1.0);
    add(&mut across, came, 1.0);
    // Twice the centre of the ball, and its diameter: the centre is the farther from zero.
    let (distance, diameter) = (dot(&middle, &middle).sqrt(), dot(&across, &across).sqrt());
    if !distance.is_finite() {
        return [0.0; 4];
    }
    middle.map(|x| 0.5 * x * (1.0 - diameter / distance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_that_turns_back_is_slowed_no_more_than_takes_energy() {
        let free = [2.0, 0.0, 0.0, 0.0];
        for (came, slowed) in [(0.0, 0.0), (5.0, 0.0), (-0.5, 0.5), (-1.5, 1.5), (-2.0, 2.0), (-7.0, 2.0)] {
            let slip = slowest(&free, &[came, 0.0, 0.0, 0.0]);
            assert!((slip[0] - slowed).abs() < 1e-6 && slip[1] == 0.0 && slip[2] == 0.0, "{came}: {slip:?}");
        }
        assert_eq!(slowest(&[1e30, 0.0, 0.0, 0.0], &[-1e20, 0.0, 0.0, 0.0]), [0.0; 4], "squares beyond f32");
        // In the plane: on the ball, in which no point is slower.
        let slip = slowest(&free, &[-1.0, 1.0, 0.0, 0.0]);
        let work = (slip[0] - 2.0) * (slip[0] - 1.0) + slip[1] * (slip[1] + 1.0);
        assert!(work.abs() < 1e-6 && dot(&slip, &slip) < 1.0, "{slip:?}");
    }
}
