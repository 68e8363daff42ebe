//! Time: counted steps, never a running sum.

use crate::state::Interval;

/// Steps and the time that they make up: since step `first`, which started at `since`, each took `dt` seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Clock {
    steps: u64,
    dt: f64,
    first: u64,
    since: f64,
}

impl Clock {
    /// Time zero, with steps of `dt` seconds to come.
    pub(crate) fn new(dt: f64) -> Self {
        Self { steps: 0, dt, first: 0, since: 0.0 }
    }

    pub(crate) fn dt(&self) -> f64 {
        self.dt
    }

    pub(crate) fn steps(&self) -> u64 {
        self.steps
    }

    pub(crate) fn time(&self) -> f64 {
        self.after(self.steps)
    }

    /// The step to come.
    pub(crate) fn interval(&self) -> Interval {
        Interval { start: self.time(), end: self.after(self.steps + 1), dt: self.dt }
    }

    pub(crate) fn tick(&mut self) {
        self.steps += 1;
    }

    /// Steps of another length from now on.
    pub(crate) fn set_dt(&mut self, dt: f64) {
        *self = Self { steps: self.steps, dt, first: self.steps, since: self.time() };
    }

    /// Another time from now on.
    pub(crate) fn set_time(&mut self, time: f64) {
        *self = Self { first: self.steps, since: time, ..*self };
    }

    fn after(&self, steps: u64) -> f64 {
        self.since + (steps - self.first) as f64 * self.dt
    }

    /// Whether the numbers make sense, as those read from a file may not.
    pub(crate) fn is_whole(&self) -> bool {
        self.first <= self.steps && self.dt > 0.0 && self.dt.is_finite() && self.since.is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_steps_times_dt_to_the_bit_and_goes_on_when_the_step_changes() {
        let mut clock = Clock::new(0.1);
        (0..1000).for_each(|_| clock.tick());
        assert_eq!(clock.time(), 1000.0 * 0.1);
        assert_eq!(clock.interval(), Interval::of_step(1000, 0.1));
        clock.set_dt(0.25);
        assert_eq!(clock.time(), 1000.0 * 0.1);
        clock.tick();
        assert_eq!((clock.time(), clock.steps()), (100.25, 1001));
        clock.set_time(2.0);
        clock.tick();
        assert_eq!((clock.time(), clock.steps()), (2.25, 1002));
    }
}
