//! What looks on while a study runs.

use supple_io::run::Flow;

use crate::error::Halt;

/// Looks on while a study runs, and may ask it to stop. `()` looks away.
pub trait Observer {
    /// Some work is done. Called at least once a simulated frame.
    fn progress(&mut self, _progress: &Progress<'_>) -> Flow {
        Flow::Continue
    }
}

impl Observer for () {}

/// How far a study is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress<'a> {
    /// The share of the work that is done, by an estimate, in [0, 1].
    pub done: f64,
    /// What is being measured.
    pub point: &'a str,
}

/// How a study ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All points are there.
    Finished,
    /// The observer asked to stop; the points so far are there.
    Stopped,
    /// An earlier study had finished; nothing was written.
    AlreadyFinished,
}

/// Counts the work of a study.
pub(crate) struct Meter<'a> {
    observer: &'a mut dyn Observer,
    all: f64,
    /// What is done with.
    before: f64,
    /// What is under way: its name, its weight, the share of it that is done, and what a tick adds.
    point: String,
    weight: f64,
    share: f64,
    tick: f64,
}

impl<'a> Meter<'a> {
    /// For work of this weight.
    pub(crate) fn new(observer: &'a mut dyn Observer, all: f64) -> Self {
        let all = all.max(f64::MIN_POSITIVE);
        Self { observer, all, before: 0.0, point: String::new(), weight: 0.0, share: 0.0, tick: 0.0 }
    }

    /// What was under way is done; what comes now has this weight and about so many ticks.
    pub(crate) fn begin(&mut self, point: impl Into<String>, weight: f64, ticks: f64) -> Result<(), Halt> {
        self.before += self.weight;
        (self.point, self.weight, self.share, self.tick) = (point.into(), weight, 0.0, 1.0 / ticks.max(1.0));
        self.tell()
    }

    /// A frame is done.
    pub(crate) fn tick(&mut self) -> Result<(), Halt> {
        self.share = (self.share + self.tick).min(1.0);
        self.tell()
    }

    fn tell(&mut self) -> Result<(), Halt> {
        let done = ((self.before + self.weight * self.share) / self.all).min(1.0);
        match self.observer.progress(&Progress { done, point: &self.point }) {
            Flow::Continue => Ok(()),
            Flow::Stop => Err(Halt::Stopped),
        }
    }
}
