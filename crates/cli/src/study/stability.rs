//! `supple study --stability`: stiff and extreme cases, each against a bound.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;

use serde::Serialize;
use supple::run::Flow;
use supple_stability::{Effort, Report, cases, run_all};
use supple_study::{Machine, Observer, Progress, StudyError};

use super::progress::Watch;
use crate::args::StudyArgs;
use crate::{Exit, interrupt, say};

/// What stability.json holds.
#[derive(Serialize)]
struct Document<'a> {
    machine: &'a Machine,
    /// Whether all cases were run that were asked for.
    complete: bool,
    #[serde(flatten)]
    report: &'a Report,
}

/// Runs the cases, on all processors; the quick ones alone if so asked.
pub(super) fn study(args: &StudyArgs) -> Result<Exit, StudyError> {
    interrupt::listen();
    let path = args.output.join("stability.json");
    let failed =
        |action| move |path: &Path, source| StudyError::File { action, path: path.to_owned(), source };
    fs::create_dir_all(&args.output).map_err(|error| failed("create")(&args.output, error))?;
    // Before the work, so that it is not lost.
    let file = File::create(&path).map_err(|error| failed("create")(&path, error))?;

    let mut cases = cases();
    cases.retain(|case| !args.quick || case.effort == Effort::Quick);
    let threads = available_parallelism().map_or(1, usize::from);
    let watch = Mutex::new((Watch::new(args.quiet), 0.0));
    let ran = run_all(&cases, threads, |index, _| {
        let (watch, done) = &mut *watch.lock().unwrap_or_else(PoisonError::into_inner);
        *done += 1.0 / cases.len() as f64;
        watch.progress(&Progress { done: *done, point: &cases[index].name }) == Flow::Continue
    });
    watch.into_inner().unwrap_or_else(PoisonError::into_inner).0.finish();

    let (report, machine) = (Report::new(&cases, &ran), Machine::here(threads));
    let complete = report.rows.len() == cases.len();
    let document = Document { machine: &machine, complete, report: &report };
    let mut file = BufWriter::new(file);
    let written = serde_json::to_writer_pretty(&mut file, &document).map_err(std::io::Error::from);
    written.and_then(|()| file.flush()).map_err(|error| failed("write")(&path, error))?;

    let passed = report.rows.iter().filter(|row| row.passed).count();
    say::out(format_args!("{}\n\n{}\n", machine.line(), report.table()));
    say::out(format_args!("{passed} of {} cases passed; written to {}", cases.len(), path.display()));
    Ok(match (complete, report.passed) {
        (false, _) => Exit::Interrupted,
        (true, false) => Exit::Failed,
        (true, true) => Exit::Done,
    })
}
