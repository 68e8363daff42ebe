//! Tracks how long a body has been at rest.

use super::place::Place;
use crate::simd::lanes::Lanes;

/// The time that a body has been at rest, and whether it sleeps.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Rest {
    /// Time in seconds for which all vertices have been slow, or stayed where other bodies were searched.
    slow_time: f64,
    /// Time in seconds for which the body has stayed in a place, as of the last check.
    still_time: f64,
    /// Time in seconds since the last check.
    unchecked_time: f64,
    /// The place.
    place: Place,
    /// Whether the body sleeps: it is not stepped.
    pub(crate) is_asleep: bool,
}

/// Whether a body can be at rest because it stays in a place.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stay {
    Impossible,
    /// `stays`: whether the body is still in the place, in the steps in which this is checked.
    Possible {
        stays: Option<bool>,
    },
}

impl Rest {
    /// Returns the time in seconds for which the body has been at rest.
    pub(crate) fn time(&self) -> f64 {
        self.slow_time.max(self.still_time)
    }

    /// Wakes the body up. The time begins again: it has to be at rest again before it sleeps.
    pub(crate) fn wake(&mut self) {
        (self.slow_time, self.is_asleep) = (0.0, false);
        self.leave();
    }

    /// Adds a step of `dt` seconds, in which the body `is_slow` or not.
    pub(super) fn add(&mut self, dt: f64, is_slow: bool) {
        self.slow_time = if is_slow { self.slow_time + dt } else { 0.0 };
    }

    /// Adds a step of `dt` seconds of a body that can stay in a place. `stays`: whether it is still in the place, in the
    /// steps in which this is checked. If not, the place becomes the present one.
    pub(super) fn stay(&mut self, present: (&Lanes<3>, [f64; 3]), dt: f64, stays: Option<bool>) {
        self.unchecked_time += dt;
        let Some(stays) = stays else { return };
        if stays {
            self.still_time += self.unchecked_time;
        } else {
            self.place.store(present);
            self.still_time = 0.0;
        }
        self.unchecked_time = 0.0;
    }

    /// Returns the place in which the body has stayed.
    pub(super) fn place(&self) -> &Place {
        &self.place
    }

    /// Forgets the place: the body cannot stay in one.
    pub(super) fn leave(&mut self) {
        (self.still_time, self.unchecked_time) = (0.0, 0.0);
        self.place.forget();
    }

    /// Returns whether the data fit a body with this number of blocks of positions.
    pub(super) fn is_valid(&self, blocks: usize) -> bool {
        [self.slow_time, self.still_time, self.unchecked_time]
            .iter()
            .all(|time| time.is_finite() && *time >= 0.0)
            && self.place.is_valid(blocks)
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.place.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_stays_until_a_vertex_is_beyond_the_limit_of_its_first_place() {
        let mut rest = Rest::default();
        let mut stay = |x: f32, shift: f64, is_checked: bool| {
            let mut positions = Lanes::zeros(1);
            positions.set(0, [x, 0.0, 0.0]);
            let present = (&positions, [shift, 0.0, 0.0]);
            let distance = rest.place().greatest_distance(present, &[1]);
            rest.stay(present, 0.25, is_checked.then(|| distance.is_some_and(|distance| distance <= 0.01)));
            rest.time()
        };
        assert_eq!(stay(0.0, 0.0, true), 0.0);
        // Time counts when it is checked.
        assert_eq!(stay(5.0, 0.0, false), 0.0);
        assert_eq!(stay(0.007, 0.0, true), 0.5);
        // It counts from the first place, however slowly the body goes on.
        assert_eq!(stay(0.014, 0.0, true), 0.0);
        assert_eq!(stay(0.02, 0.0, true), 0.25);
        assert_eq!(stay(0.02, 0.1, true), 0.0);
        // A NaN does not stay.
        assert_eq!(stay(f32::NAN, 0.1, true), 0.0);
    }
}
