//! Computes the simulation time from a step count, so that rounding does not accumulate.

use crate::state::Interval;

/// A step counter and the time `since + (steps - first) * dt`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Clock {
    /// Number of steps so far.
    steps: u64,
    /// Length of a step in seconds.
    dt: f64,
    /// Number of steps when `dt` or the time was last set.
    first: u64,
    /// Time in seconds after `first` steps.
    since: f64,
    /// Number of steps when the number of steps per frame was last set. A frame began there.
    frames_from: u64,
}

impl Clock {
    /// Creates a clock at time zero with steps of `dt` seconds.
    pub(super) fn new(dt: f64) -> Self {
        Self { steps: 0, dt, first: 0, since: 0.0, frames_from: 0 }
    }

    pub(super) fn dt(&self) -> f64 {
        self.dt
    }

    pub(super) fn steps(&self) -> u64 {
        self.steps
    }

    pub(super) fn time(&self) -> f64 {
        self.time_after(self.steps)
    }

    /// Returns the time interval of the next step.
    pub(super) fn interval(&self) -> Interval {
        Interval { start: self.time(), end: self.time_after(self.steps + 1), dt: self.dt }
    }

    pub(super) fn tick(&mut self, steps: u64) {
        self.steps += steps;
    }

    /// Sets the step length; the time stays the same.
    pub(super) fn set_dt(&mut self, dt: f64) {
        *self = Self { dt, first: self.steps, since: self.time(), ..*self };
    }

    /// Sets the time; the step count stays the same.
    pub(super) fn set_time(&mut self, time: f64) {
        *self = Self { first: self.steps, since: time, ..*self };
    }

    /// Begins a frame with the next step. Called when the number of steps per frame was set.
    pub(super) fn begin_frame(&mut self) {
        self.frames_from = self.steps;
    }

    /// Returns whether the next step is the first one of a frame of `substeps` steps.
    pub(super) fn is_frame_start(&self, substeps: u64) -> bool {
        (self.steps - self.frames_from).is_multiple_of(substeps)
    }

    /// Returns the time in seconds after `steps` steps, counted from the start of the simulation.
    fn time_after(&self, steps: u64) -> f64 {
        self.since + (steps - self.first) as f64 * self.dt
    }

    /// Returns whether the values are valid; deserialized values may not be.
    pub(super) fn is_valid(&self) -> bool {
        self.first <= self.steps
            && self.frames_from <= self.steps
            && self.dt > 0.0
            && self.dt.is_finite()
            && self.since.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_exactly_steps_times_dt_and_continuous_when_dt_changes() {
        let mut clock = Clock::new(0.1);
        (0..1000).for_each(|_| clock.tick(1));
        assert_eq!(clock.time(), 1000.0 * 0.1);
        assert_eq!(clock.interval(), Interval::of_step(1000, 0.1));
        clock.set_dt(0.25);
        assert_eq!(clock.time(), 1000.0 * 0.1);
        clock.tick(1);
        assert_eq!((clock.time(), clock.steps()), (100.25, 1001));
        clock.set_time(2.0);
        clock.tick(1);
        assert_eq!((clock.time(), clock.steps()), (2.25, 1002));
    }

    #[test]
    fn frames_are_counted_from_the_last_change_of_the_steps_per_frame() {
        let mut clock = Clock::new(0.1);
        let starts = |clock: &mut Clock, substeps| -> Vec<bool> {
            (0..7).map(|_| (clock.is_frame_start(substeps), clock.tick(1)).0).collect()
        };
        assert_eq!(starts(&mut clock, 3), [true, false, false, true, false, false, true]);
        clock.begin_frame();
        clock.set_dt(0.2);
        clock.set_time(5.0);
        assert_eq!(starts(&mut clock, 4), [true, false, false, false, true, false, false]);
    }
}
