//! `supple study --stability`: stiff and extreme cases, each against a bound.

use std::fs;
use std::sync::{Mutex, PoisonError};
use std::thread::available_parallelism;

use serde::Serialize;
use supple_io::run::Flow;
use supple_study::stability::{Effort, Report, cases, run_all};
use supple_study::{Machine, Observer, Progress, StudyError, open_folder, replace};

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
    let failed = |source| StudyError::File { action: "write", path: path.clone(), source };
    open_folder(&args.output)?;
    // A folder that cannot be written is found before the work; an earlier report stays until there is a new one.
    fs::write(path.with_extension("part"), "").map_err(failed)?;

    let mut cases = cases();
    cases.retain(|case| !args.quick || case.effort == Effort::Quick);
    let threads = available_parallelism().map_or(1, usize::from);
    let watch = Mutex::new((Watch::new(args.quiet), 0_u32));
    let ran = run_all(&cases, threads, |index, _| {
        let (watch, count) = &mut *watch.lock().unwrap_or_else(PoisonError::into_inner);
        *count += 1;
        let done = f64::from(*count) / cases.len() as f64;
        watch.progress(&Progress { done, point: &cases[index].name }) == Flow::Continue
    });
    watch.into_inner().unwrap_or_else(PoisonError::into_inner).0.finish();

    let (report, machine) = (Report::new(&cases, &ran), Machine::here(threads));
    let complete = report.rows.len() == cases.len();
    let document = Document { machine: &machine, complete, report: &report };
    let text = serde_json::to_string_pretty(&document).map_err(|error| failed(error.into()))?;
    replace(&path, text.as_bytes())?;

    let passed = report.rows.iter().filter(|row| row.passed).count();
    say::out(format_args!("{}\n\n{}\n", machine.line(), report.table()));
    say::out(format_args!("{passed} of {} cases passed; written to {}", cases.len(), path.display()));
    Ok(match (complete, report.passed) {
        (false, _) => Exit::Interrupted,
        (true, false) => Exit::Failed,
        (true, true) => Exit::Done,
    })
}
