//! Prints the progress of a job or a study, for users or for other programs: see [`ProgressForm`].
//!
//! A job is the run of one scene: see [`supple_io::run::Job`].

use std::io::{self, IsTerminal};
use std::path::Path;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use supple_io::Escaped;
use supple_io::run::{self, Flow, Note, Outcome, RunError, RunReport};
use supple_study as study;

use crate::args::ProgressForm;
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
    /// Index of the input of a job, and the number of inputs.
    place: (usize, usize),
}

/// Form of the progress output.
enum Output {
    Nothing,
    Bar(ProgressBar),
    /// Lines in a pipe. The value is the number of tenths of the work that have been reported.
    Lines(u32),
    /// Objects of the job of an input.
    Json {
        input: String,
    },
    /// Lines of Open Job Description. The value is the last printed percentage.
    OpenJd(Option<u32>),
}

/// Number of positions of the bar.
const STEPS: f64 = 10_000.0;

impl Reporter {
    /// Creates a reporter for a study. If `quiet`, it prints nothing.
    pub(crate) fn of_study(quiet: bool) -> Self {
        Self::new("study", if quiet { Output::Nothing } else { terminal_output("study") })
    }

    /// Creates a reporter for the job with this name, of the file `input`.
    pub(crate) fn of_job(form: ProgressForm, name: &str, input: &Path) -> Self {
        let output = match form {
            ProgressForm::None => Output::Nothing,
            ProgressForm::Bar => terminal_output(name),
            ProgressForm::Json => Output::Json { input: input.display().to_string() },
            ProgressForm::OpenJd => Output::OpenJd(None),
        };
        Self::new(name, output)
    }

    fn new(name: &str, output: Output) -> Self {
        let name = Escaped(name).to_string();
        Self { name, output, start: Instant::now(), first: 0, start_frame: 0, place: (0, 1) }
    }

    /// Sets the number of frame 0 of the job, from which the printed numbers of frames count.
    pub(crate) fn starting_at(self, start_frame: u32) -> Self {
        Self { start_frame, ..self }
    }

    /// Sets the index of the input of the job, and the number of inputs.
    pub(crate) fn at_place(self, index: usize, inputs: usize) -> Self {
        Self { place: (index, inputs), ..self }
    }

    /// Prints that the job begins, if other programs read the output.
    pub(crate) fn begin(&mut self) {
        match &self.output {
            Output::Json { input } => terminal::print_event(&json!({
                "event": "begin",
                "input": input,
                "version": env!("CARGO_PKG_VERSION"),
            })),
            Output::OpenJd(_) => {
                self.print_openjd(0.0, &format!("{}: building the bodies", self.name));
            }
            _ => {}
        }
    }

    /// Removes the bar from the terminal, or prints how the job ended, if other programs read the output.
    pub(crate) fn end(&mut self, result: &Result<RunReport, RunError>) {
        self.finish();
        match (&self.output, result) {
            (Output::Json { input }, Ok(report)) => terminal::print_event(&json!({
                "event": "end",
                "input": input,
                "outcome": report.outcome.name(),
                "frame": self.number(report.last),
                "written": report.written,
                "elapsed": report.elapsed.as_secs_f64(),
                "directory": report.directory.display().to_string(),
            })),
            (Output::Json { input }, Err(error)) => terminal::print_event(&json!({
                "event": "end",
                "input": input,
                "outcome": "failed",
                "error": error.to_string(),
            })),
            (Output::OpenJd(_), Ok(report)) if report.outcome == Outcome::Stopped => {
                let status = format!("{}: stopped after frame {}", self.name, self.number(report.last));
                terminal::print(format_args!("openjd_status: {status}"));
            }
            (Output::OpenJd(_), Ok(report)) => {
                let (outcome, frame) = (report.outcome.name(), self.number(report.last));
                let status = format!("{}: {outcome}, frame {frame}", self.name);
                if !self.print_openjd(1.0, &status) {
                    terminal::print(format_args!("openjd_status: {status}"));
                }
            }
            (Output::OpenJd(_), Err(error)) => {
                let message = error.to_string().replace('\n', " ");
                terminal::print(format_args!("openjd_fail: {}: {message}", self.name));
            }
            _ => {}
        }
    }

    /// Removes the bar from the terminal.
    pub(crate) fn finish(&self) {
        if let Output::Bar(bar) = &self.output {
            bar.finish_and_clear();
        }
    }

    /// Returns the number in file names of a frame, counted from 0.
    fn number(&self, frame: u32) -> u64 {
        u64::from(self.start_frame) + u64::from(frame)
    }

    /// Prints that the fraction `done` of the work took `elapsed`. `position` names the current frame or
    /// study point. Returns [`Flow::Stop`] after Ctrl-C or SIGTERM.
    fn update(&mut self, done: f64, elapsed: Duration, position: &str) -> Flow {
        let left = || terminal::duration(seconds_left(done, elapsed));
        match &mut self.output {
            Output::Nothing | Output::Json { .. } => {}
            Output::Bar(bar) => {
                bar.set_position((done * STEPS) as u64);
                bar.set_message(position.to_owned());
            }
            Output::Lines(printed) => {
                let tenths = (done * 10.0) as u32;
                if tenths > *printed {
                    *printed = tenths;
                    let (name, percent, left) = (&self.name, tenths * 10, left());
                    terminal::print_to_stderr(format_args!("{name}: {percent} %, {position}, {left} left"));
                }
            }
            Output::OpenJd(_) => {
                self.print_openjd(done, &format!("{}: {position}, {} left", self.name, left()));
            }
        }
        if interrupt::requested().is_some() { Flow::Stop } else { Flow::Continue }
    }

    /// Prints the percentage and the status for Open Job Description, if the percentage of all inputs has changed.
    /// `done`: the fraction of the work of this input. Returns whether it has changed.
    fn print_openjd(&mut self, done: f64, status: &str) -> bool {
        let (index, inputs) = self.place;
        let percent = (100.0 * (index as f64 + done) / inputs as f64) as u32;
        if let Output::OpenJd(printed) = &mut self.output
            && *printed != Some(percent)
        {
            *printed = Some(percent);
            terminal::print(format_args!("openjd_progress: {percent}\nopenjd_status: {status}"));
            return true;
        }
        false
    }
}

impl run::Observer for Reporter {
    fn preroll(&mut self, done: f64) -> Flow {
        if let Output::Bar(bar) = &mut self.output {
            bar.set_position((done * STEPS) as u64);
            bar.set_message("pre-roll");
        }
        if interrupt::requested().is_some() { Flow::Stop } else { Flow::Continue }
    }

    fn started(&mut self, first: u32, _last: u32) {
        self.first = first;
        if let Output::Bar(bar) = &self.output {
            bar.reset();
        }
    }

    fn frame(&mut self, progress: &run::Progress) -> Flow {
        let run::Progress { frame, last, time, elapsed } = *progress;
        let done = f64::from(frame - self.first + 1) / f64::from(last - self.first + 1);
        let [frame, last] = [frame, last].map(|frame| self.number(frame));
        if let Output::Json { input } = &self.output {
            terminal::print_event(&json!({
                "event": "frame",
                "input": input,
                "frame": frame,
                "last": last,
                "time": time,
                "elapsed": elapsed.as_secs_f64(),
                "seconds_left": seconds_left(done, elapsed),
            }));
        }
        self.update(done, elapsed, &format!("frame {frame} of {last}"))
    }

    fn note(&mut self, note: &Note) {
        let line = format!("{}: {}", self.name, note.message(self.start_frame));
        let print = || match note {
            Note::Caution(caution) if caution.is_warning() => terminal::print_warning(line),
            _ => terminal::print_to_stderr(line),
        };
        match &self.output {
            Output::Bar(bar) => bar.suspend(print),
            Output::Nothing if matches!(note, Note::Resumed { .. }) => {}
            _ => print(),
        }
    }
}

impl study::Observer for Reporter {
    fn progress(&mut self, progress: &study::Progress<'_>) -> Flow {
        self.update(progress.done, self.start.elapsed(), progress.point)
    }
}

/// Returns the seconds that the rest of the work takes if the fraction `done` took `elapsed`.
fn seconds_left(done: f64, elapsed: Duration) -> f64 {
    elapsed.as_secs_f64() * (1.0 / done - 1.0)
}

/// Returns a bar on a terminal, and lines in a pipe.
fn terminal_output(name: &str) -> Output {
    if io::stderr().is_terminal() { Output::Bar(bar(&Escaped(name).to_string())) } else { Output::Lines(0) }
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
