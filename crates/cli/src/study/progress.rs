//! What is shown while a study runs: a bar on a terminal, a line every 10 % in a pipe, or nothing.

use std::io::{self, IsTerminal};
use std::time::Instant;

use indicatif::ProgressBar;
use supple_io::run::Flow;
use supple_study::{Observer, Progress};

use crate::progress::bar;
use crate::{interrupt, say};

/// Looks on at a study.
pub(super) struct Watch {
    view: View,
    begun: Instant,
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
    /// Shows nothing if `quiet`.
    pub(super) fn new(quiet: bool) -> Self {
        let view = match (quiet, io::stderr().is_terminal()) {
            (true, _) => View::Nothing,
            (false, true) => {
                let bar = bar();
                bar.set_length(STEPS as u64);
                bar.set_prefix("study");
                View::Bar(bar)
            }
            (false, false) => View::Lines(0),
        };
        Self { view, begun: Instant::now() }
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        if let View::Bar(bar) = &self.view {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Watch {
    fn progress(&mut self, progress: &Progress<'_>) -> Flow {
        match &mut self.view {
            View::Nothing => {}
            View::Bar(bar) => {
                bar.set_position((progress.done * STEPS) as u64);
                bar.set_message(progress.point.to_owned());
            }
            View::Lines(printed) => {
                let tenths = (progress.done * 10.0) as u32;
                if tenths > *printed {
                    *printed = tenths;
                    let left = self.begun.elapsed().as_secs_f64() * (1.0 / progress.done - 1.0);
                    let (percent, left) = (tenths * 10, say::duration(left));
                    say::err(format_args!("study: {percent} %, {}, {left} left", progress.point));
                }
            }
        }
        if interrupt::asked() { Flow::Stop } else { Flow::Continue }
    }
}
