//! What stands on the terminal when a job, or a batch of them, has ended.

use supple_io::run::{Outcome, RunError, RunReport};

use crate::say;

/// One line about one job.
pub(crate) fn line(name: &str, report: &RunReport) -> String {
    let folder = report.directory.display();
    match report.outcome {
        Outcome::AlreadyFinished => {
            format!("{name}: finished before, frame {} is in {folder}; nothing written", report.last)
        }
        Outcome::Finished | Outcome::Stopped => {
            let ended = if report.outcome == Outcome::Stopped { "stopped after" } else { "done, up to" };
            format!(
                "{name}: {ended} frame {}, {} frames written to {folder} in {}",
                report.last,
                report.written,
                say::duration(report.elapsed.as_secs_f64())
            )
        }
    }
}

/// The table that ends a batch of `inputs` jobs, of which the last may not have begun.
pub(crate) fn table(results: &[(String, Result<RunReport, RunError>)], inputs: usize) -> String {
    let width = results.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max("input".len());
    let row = |cells: [&str; 5]| {
        let [name, outcome, frames, time, folder] = cells;
        format!("{name:width$}  {outcome:8}  {frames:>7}  {time:>12}  {folder}").trim_end().to_owned()
    };
    let mut lines = vec![row(["input", "outcome", "frames", "time", "folder"])];
    for (name, result) in results {
        lines.push(match result {
            Ok(report) => {
                let outcome = match report.outcome {
                    Outcome::Finished => "done",
                    Outcome::Stopped => "stopped",
                    Outcome::AlreadyFinished => "was done",
                };
                let time = say::duration(report.elapsed.as_secs_f64());
                let folder = report.directory.display().to_string();
                row([name, outcome, &report.written.to_string(), &time, &folder])
            }
            Err(error) => row([name, "failed", "", "", &error.to_string()]),
        });
    }
    if results.len() < inputs {
        lines.push(format!("{} of {inputs} not begun", inputs - results.len()));
    }
    lines.join("\n")
}
