//! What is shown while a job or a study runs: a bar on a terminal, a line every 10 % in a pipe, or nothing.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use supple_io::run::{self, Flow, Note};
use supple_study as study;

use crate::{interrupt, say};

/// Shows the progress of a job or a study, and asks it to stop after Ctrl-C.
pub(crate) struct Watch {
    name: String,
    view: View,
    begun: Instant,
    /// First frame of a job.
    first: u32,
}

enum View {
    Nothing,
    Bar(ProgressBar),
    /// The tenths that were printed.
    Lines(u32),
}

/// Steps of the bar.
const STEPS: f64 = 10_000.0;

impl Watch {
    /// Shows the progress of what has this name; nothing but notes if `quiet`.
    pub(crate) fn new(name: &str, quiet: bool) -> Self {
        let view = match (quiet, io::stderr().is_terminal()) {
            (true, _) => View::Nothing,
            (false, true) => View::Bar(bar(name)),
            (false, false) => View::Lines(0),
        };
        Self { name: name.to_owned(), view, begun: Instant::now(), first: 0 }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        if let View::Bar(bar) = &self.view {
            bar.finish_and_clear();
        }
    }

    /// Shows that a share of the work is done after this time.
    fn show(&mut self, done: f64, elapsed: Duration, at: &str) -> Flow {
        match &mut self.view {
            View::Nothing => {}
            View::Bar(bar) => {
                bar.set_position((done * STEPS) as u64);
                bar.set_message(at.to_owned());
            }
            View::Lines(printed) => {
                let tenths = (done * 10.0) as u32;
                if tenths > *printed {
                    *printed = tenths;
                    let left = say::duration(elapsed.as_secs_f64() * (1.0 / done - 1.0));
                    say::err(format_args!("{}: {} %, {at}, {left} left", self.name, tenths * 10));
                }
            }
        }
        if interrupt::asked() { Flow::Stop } else { Flow::Continue }
    }
}

impl run::Observer for Watch {
    fn started(&mut self, first: u32, _last: u32) {
        self.first = first;
        if let View::Bar(bar) = &self.view {
            bar.reset();
        }
    }

    fn frame(&mut self, progress: &run::Progress) -> Flow {
        let run::Progress { frame, last, elapsed, .. } = *progress;
        let done = f64::from(frame - self.first + 1) / f64::from(last - self.first + 1);
        self.show(done, elapsed, &format!("frame {frame} of {last}"))
    }

    fn note(&mut self, note: &Note) {
        let line = format!("{}: {note}", self.name);
        match &self.view {
            View::Bar(bar) => bar.suspend(|| say::err(line)),
            View::Nothing if matches!(note, Note::Resumed { .. }) => {}
            _ => say::err(line),
        }
    }
}

impl study::Observer for Watch {
    fn progress(&mut self, progress: &study::Progress<'_>) -> Flow {
        self.show(progress.done, self.begun.elapsed(), progress.point)
    }
}

/// A bar with a name, a message and the time left.
fn bar(name: &str) -> ProgressBar {
    let bar = ProgressBar::new(STEPS as u64).with_prefix(name.to_owned());
    // The template is a constant; if it did not parse, the plain bar would do.
    if let Ok(style) = ProgressStyle::with_template("{prefix} {wide_bar} {percent} % {msg}, {eta} left") {
        bar.set_style(style);
    }
    bar
}
