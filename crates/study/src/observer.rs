//! Reports the progress of a study to an observer, which can stop the study.

use supple_io::run::Flow;

use crate::error::Halt;

/// Receives the progress of a study and can stop it. `()` ignores progress.
pub trait Observer {
    /// Receives the current progress. Called at least once per simulated frame.
    fn progress(&mut self, _progress: &Progress<'_>) -> Flow {
        Flow::Continue
    }
}

impl Observer for () {}

/// Progress of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// Estimated completed fraction of the work, in [0, 1].
    pub done: f64,
    /// Name of the point being measured.
    pub point: &'a str,
}

/// Outcome of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All points are measured.
    Finished,
    /// The observer requested a stop; the points measured so far are kept.
    Stopped,
    /// The earlier study is complete; nothing was written.
    AlreadyFinished,
}

/// Adds up the completed work of a study and reports it to the observer. The weight of a point is its
/// estimated run time in any unit.
pub(crate) struct Meter<'a> {
    observer: &'a mut dyn Observer,
    /// Sum of the weights of all points.
    total: f64,
    /// Sum of the weights of the completed points.
    completed: f64,
    /// Name of the current point.
    point: String,
    /// Weight of the current point.
    weight: f64,
    /// Completed fraction of the current point.
    fraction: f64,
    /// Fraction of the current point that a tick adds.
    tick: f64,
}

impl<'a> Meter<'a> {
    /// Creates a meter for points with the total weight `total`.
    pub(crate) fn new(observer: &'a mut dyn Observer, total: f64) -> Self {
        let total = total.max(f64::MIN_POSITIVE);
        Self { observer, total, completed: 0.0, point: String::new(), weight: 0.0, fraction: 0.0, tick: 0.0 }
    }

    /// Completes the current point and begins `point`, which has the given weight and approximately `ticks`
    /// ticks.
    pub(crate) fn begin(&mut self, point: impl Into<String>, weight: f64, ticks: f64) -> Result<(), Halt> {
        self.completed += self.weight;
        (self.point, self.weight) = (point.into(), weight);
        (self.fraction, self.tick) = (0.0, 1.0 / ticks.max(1.0));
        self.report()
    }

    /// Adds a tick (a frame or a similar unit) to the current point.
    pub(crate) fn tick(&mut self) -> Result<(), Halt> {
        self.fraction = (self.fraction + self.tick).min(1.0);
        self.report()
    }

    /// Reports the progress; fails with [`Halt::Stopped`] if the observer requests a stop.
    fn report(&mut self) -> Result<(), Halt> {
        let done = ((self.completed + self.weight * self.fraction) / self.total).min(1.0);
        match self.observer.progress(&Progress { done, point: &self.point }) {
            Flow::Continue => Ok(()),
            Flow::Stop => Err(Halt::Stopped),
        }
    }
}
