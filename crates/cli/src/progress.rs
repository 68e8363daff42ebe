//! What is shown while a job runs: a bar on a terminal, a line every 10 % in a pipe, or nothing.

use std::io::{self, IsTerminal};

use indicatif::{ProgressBar, ProgressStyle};
use supple_io::run::{Flow, Note, Observer, Progress};

use crate::{interrupt, say};

/// Looks on at one job.
pub(crate) struct Watch {
    name: String,
    view: View,
    first: u32,
}

enum View {
    Nothing,
    Bar(ProgressBar),
    /// The tenths that were printed.
    Lines(u32),
}

impl Watch {
    /// Shows the progress of a job of this name.
    pub(crate) fn new(name: &str, quiet: bool) -> Self {
        let view = match (quiet, io::stderr().is_terminal()) {
            (true, _) => View::Nothing,
            (false, true) => View::Bar(bar()),
            (false, false) => View::Lines(0),
        };
        Self { name: name.to_owned(), view, first: 0 }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let View::Bar(bar) = &self.view {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Watch {
    fn started(&mut self, first: u32, last: u32) {
        self.first = first;
        if let View::Bar(bar) = &self.view {
            bar.set_length(u64::from(last - first + 1));
            bar.set_prefix(self.name.clone());
            bar.reset();
        }
    }

    fn frame(&mut self, progress: &Progress) -> Flow {
        let done = progress.frame - self.first + 1;
        let all = progress.last - self.first + 1;
        match &mut self.view {
            View::Nothing => {}
            View::Bar(bar) => {
                bar.set_position(u64::from(done));
                bar.set_message(format!("frame {} of {}", progress.frame, progress.last));
            }
            View::Lines(printed) => {
                let tenths = (u64::from(done) * 10 / u64::from(all)) as u32;
                if tenths > *printed {
                    *printed = tenths;
                    let left = progress.elapsed.as_secs_f64() * f64::from(all - done) / f64::from(done);
                    say::err(format_args!(
                        "{}: {} %, frame {} of {}, {} left",
                        self.name,
                        tenths * 10,
                        progress.frame,
                        progress.last,
                        say::duration(left)
                    ));
                }
            }
        }
        if interrupt::asked() { Flow::Stop } else { Flow::Continue }
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

/// A bar with a prefix, a message and the time left.
pub(crate) fn bar() -> ProgressBar {
    let bar = ProgressBar::no_length();
    // The template is a constant: if it did not parse, the plain bar would do.
    if let Ok(style) = ProgressStyle::with_template("{prefix} {wide_bar} {percent} % {msg}, {eta} left") {
        bar.set_style(style);
    }
    bar
}
