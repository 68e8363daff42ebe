//! Prints the progress of a job or a study: a bar on a terminal, a line every 10 % in a pipe, or nothing.
//!
//! A job is the run of one scene: see [`supple_io::run::Job`].

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use supple_io::Escaped;
use supple_io::run::{self, Flow, Note};
use supple_study as study;

use crate::{interrupt, terminal};

/// Prints the progress of a job or a study, and stops it after Ctrl-C or SIGTERM.
pub(crate) struct Reporter {
    name: String,
    output: Output,
    start: Instant,
    /// First frame of this run of a job, from 0.
    first: u32,
    /// Number of frame 0 of a job in file names.
    start_frame: u32,
}

/// Form of the progress output.
enum Output {
    Nothing,
    Bar(ProgressBar),
    /// Lines in a pipe. The value is the number of tenths of the work that have been reported.
    Lines(u32),
}

/// Number of positions of the bar.
const STEPS: f64 = 10_000.0;

impl Reporter {
    /// Creates a reporter for the job or study `name`. If `quiet`, it prints only notes, except
    /// [`Note::Resumed`].
    pub(crate) fn new(name: &str, quiet: bool) -> Self {
        let name = Escaped(name).to_string();
        let output = match (quiet, io::stderr().is_terminal()) {
            (true, _) => Output::Nothing,
            (false, true) => Output::Bar(bar(&name)),
            (false, false) => Output::Lines(0),
        };
        Self { name, output, start: Instant::now(), first: 0, start_frame: 0 }
    }

    /// Sets the number of frame 0 of the job, from which the printed numbers of frames count.
    pub(crate) fn starting_at(self, start_frame: u32) -> Self {
        Self { start_frame, ..self }
    }

    /// Removes the bar from the terminal.
    pub(crate) fn finish(&self) {
        if let Output::Bar(bar) = &self.output {
            bar.finish_and_clear();
        }
    }

    /// Prints that the fraction `done` of the work took `elapsed`. `position` names the current frame or
    /// study point. Returns [`Flow::Stop`] after Ctrl-C or SIGTERM.
    fn update(&mut self, done: f64, elapsed: Duration, position: &str) -> Flow {
        match &mut self.output {
            Output::Nothing => {}
            Output::Bar(bar) => {
                bar.set_position((done * STEPS) as u64);
                bar.set_message(position.to_owned());
            }
            Output::Lines(printed) => {
                let tenths = (done * 10.0) as u32;
                if tenths > *printed {
                    *printed = tenths;
                    let left = terminal::duration(elapsed.as_secs_f64() * (1.0 / done - 1.0));
                    terminal::print_to_stderr(format_args!(
                        "{}: {} %, {position}, {left} left",
                        self.name,
                        tenths * 10
                    ));
                }
            }
        }
        if interrupt::requested().is_some() { Flow::Stop } else { Flow::Continue }
    }
}

impl run::Observer for Reporter {
    fn started(&mut self, first: u32, _last: u32) {
        self.first = first;
        if let Output::Bar(bar) = &self.output {
            bar.reset();
        }
    }

    fn frame(&mut self, progress: &run::Progress) -> Flow {
        let run::Progress { frame, last, elapsed, .. } = *progress;
        let done = f64::from(frame - self.first + 1) / f64::from(last - self.first + 1);
        let [frame, last] = [frame, last].map(|frame| u64::from(self.start_frame) + u64::from(frame));
        self.update(done, elapsed, &format!("frame {frame} of {last}"))
    }

    fn note(&mut self, note: &Note) {
        let kind =
            if matches!(note, Note::Caution(caution) if caution.is_warning()) { "warning: " } else { "" };
        let line = format!("{kind}{}: {}", self.name, note.message(self.start_frame));
        match &self.output {
            Output::Bar(bar) => bar.suspend(|| terminal::print_to_stderr(line)),
            Output::Nothing if matches!(note, Note::Resumed { .. }) => {}
            _ => terminal::print_to_stderr(line),
        }
    }
}

impl study::Observer for Reporter {
    fn progress(&mut self, progress: &study::Progress<'_>) -> Flow {
        self.update(progress.done, self.start.elapsed(), progress.point)
    }
}

/// Creates a progress bar with the name, the percentage, a message and the remaining time.
fn bar(name: &str) -> ProgressBar {
    let bar = ProgressBar::new(STEPS as u64).with_prefix(name.to_owned());
    // The template is constant and valid; if parsing failed, the bar would keep its default style.
    if let Ok(style) = ProgressStyle::with_template("{prefix} {wide_bar} {percent} % {msg}, {eta} left") {
        bar.set_style(style);
    }
    bar
}
