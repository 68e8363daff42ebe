//! All cases on several threads, and the report on them: a table for people, JSON for programs.

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::available_parallelism;

use serde::Serialize;
use supple_io::run::Flow;

use super::case::{Bound, Case, Measure, Row, Suite};
use super::cases::cases;
use crate::error::StudyError;
use crate::machine::Machine;
use crate::observer::{Observer, Progress};
use crate::output::{open_folder, write_json};

/// The study of stiff and extreme cases.
#[derive(Clone, Debug)]
pub struct StabilityStudy {
    /// Where `stability.json` goes; made if it is not there.
    pub directory: PathBuf,
    /// The quick cases alone.
    pub quick: bool,
}

/// The cases that were run.
#[derive(Clone, Debug, Serialize)]
pub struct StabilityReport {
    /// Where they were run.
    pub machine: Machine,
    /// Whether all cases were run that were asked for.
    pub complete: bool,
    /// Whether all bounds hold of all cases.
    pub passed: bool,
    /// One for each case that was run, in the order of the cases.
    pub rows: Vec<Row>,
    /// How many cases were asked for.
    #[serde(skip)]
    pub asked: usize,
}

impl StabilityStudy {
    /// Runs the cases on all processors. An earlier report stays until there is a new one.
    ///
    /// # Errors
    ///
    /// A folder that cannot be written; that is found before any case is run.
    pub fn run(&self, observer: &mut (dyn Observer + Send)) -> Result<StabilityReport, StudyError> {
        open_folder(&self.directory)?;
        let (path, part) = (self.path(), self.path().with_extension("part"));
        fs::write(&part, "").map_err(|error| StudyError::file("write", &path, error))?;
        let mut cases = cases();
        cases.retain(|case| !self.quick || case.suite == Suite::Quick);
        let report = StabilityReport::of(&cases, observer);
        write_json(&path, &report)?;
        Ok(report)
    }

    /// The report.
    pub fn path(&self) -> PathBuf {
        self.directory.join("stability.json")
    }
}

/// The columns of figures of the table.
const COLUMNS: [(&str, Measure); 8] = [
    ("NaN", Measure::NotNumbers),
    ("speed", Measure::LargestSpeed),
    ("energy", Measure::EnergyGain),
    ("shape", Measure::Shape),
    ("place", Measure::Place),
    ("angular", Measure::Angular),
    ("capped", Measure::Capped),
    ("robust", Measure::Unsettled),
];

impl StabilityReport {
    /// Runs cases on all processors, long ones first. Once the observer asks to stop, no further case is begun.
    pub fn of(cases: &[Case], observer: &mut (dyn Observer + Send)) -> Self {
        let threads = available_parallelism().map_or(1, usize::from);
        let rows: Vec<Row> = run_all(cases, threads, observer).into_iter().flatten().collect();
        Self {
            machine: Machine::here(threads),
            complete: rows.len() == cases.len(),
            passed: rows.iter().all(|row| row.passed),
            rows,
            asked: cases.len(),
        }
    }

    /// A row for each case, under the name of its family, with the bounds that it breaks below it. Ends without a line
    /// break.
    pub fn table(&self) -> String {
        let width = self.rows.iter().map(|row| row.case.chars().count()).max().unwrap_or(0);
        let mut text = format!("      {:width$}", "");
        for (name, _) in COLUMNS {
            let _ = write!(text, " {name:>8}");
        }
        text.push_str("        s");
        let mut family = "";
        for row in &self.rows {
            if row.family != family {
                family = row.family;
                let _ = write!(text, "\n{family}");
            }
            let verdict = if row.passed { "ok" } else { "FAIL" };
            let _ = write!(text, "\n{verdict:>4}  {:width$}", row.case);
            for (_, measure) in COLUMNS {
                let _ = write!(text, " {:>8}", row.figures.get(measure).map_or_else(|| "-".into(), short));
            }
            let _ = write!(text, " {:>8.1}", row.seconds);
            for Bound { measure, limit } in &row.broken {
                let value = row.figures.get(*measure).map_or_else(|| "not reached".into(), short);
                let _ = write!(text, "\n      {}: {value}, the bound is {}", measure.label(), short(*limit));
            }
            if let Some(error) = &row.error {
                let _ = write!(text, "\n      {error}");
            }
        }
        text
    }
}

/// A number in at most eight characters.
fn short(value: f64) -> String {
    if value == 0.0 || (value.fract() == 0.0 && value.abs() < 1e5) {
        format!("{value}")
    } else {
        format!("{value:.1e}")
    }
}

/// Runs cases on `threads` threads, each simulation on one of them. `None` for cases that were not begun when the observer
/// asked to stop.
fn run_all(cases: &[Case], threads: usize, observer: &mut (dyn Observer + Send)) -> Vec<Option<Row>> {
    let mut order: Vec<usize> = (0..cases.len()).collect();
    order.sort_by_key(|&index| cases[index].suite == Suite::Quick);
    let next = AtomicUsize::new(0);
    let results = Mutex::new((vec![None; cases.len()], 0_u32, observer));
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let row = cases[index].run();
                    let Ok(mut results) = results.lock() else { return };
                    let (rows, count, observer) = &mut *results;
                    rows[index] = Some(row);
                    *count += 1;
                    let done = f64::from(*count) / cases.len() as f64;
                    if observer.progress(&Progress { done, point: &cases[index].name }) == Flow::Stop {
                        next.store(cases.len(), Ordering::Relaxed);
                    }
                }
            });
        }
    });
    results.into_inner().map_or_else(|_| Vec::new(), |(rows, ..)| rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::case::Figures;

    #[test]
    fn a_case_fails_by_a_bound_by_a_figure_that_is_not_there_by_an_error_and_by_a_panic() {
        let figures = || {
            let mut figures = Figures::default();
            figures.set(Measure::NotNumbers, 0.0);
            figures.set(Measure::Shape, f64::NAN);
            figures.raise(Measure::LargestSpeed, 2.0);
            figures.raise(Measure::LargestSpeed, 1.0);
            Ok(figures)
        };
        let cases = [
            Case::new("good", "", figures).bound(Measure::LargestSpeed, 2.0),
            Case::new("too fast", "", figures).bound(Measure::LargestSpeed, 1.5),
            Case::new("no number", "", figures).bound(Measure::Shape, 1e9),
            Case::new("no figure", "", figures).bound(Measure::Place, 1e9),
            Case::new("no body", "", || Err(supple::Error::NoBody)),
            Case::new("no end", "", || panic!("at {}", 1 + 1)),
            Case::new("no reason", "", || panic!("never")),
        ];
        let report = StabilityReport::of(&cases, &mut ());
        assert_eq!(
            report.rows.iter().map(|row| row.passed).collect::<Vec<_>>(),
            [true, false, false, false, false, false, false]
        );
        assert!(!report.passed);
        let table = report.table();
        assert!(table.contains("largest speed, cells/step: 2, the bound is 1.5e0"), "{table}");
        assert!(table.contains("place, cells: not reached"), "{table}");
        assert_eq!(table.lines().filter(|line| line.starts_with("FAIL")).count(), 6, "{table}");
        assert!(table.contains("panicked: at 2") && table.contains("panicked: never"), "{table}");
        assert!(report.rows.iter().all(|row| row.seconds < 1.0));
    }

    struct Stops;

    impl Observer for Stops {
        fn progress(&mut self, _progress: &Progress<'_>) -> Flow {
            Flow::Stop
        }
    }

    #[test]
    fn cases_after_a_stop_are_not_run() {
        let cases = ["a", "b", "c"].map(|name| Case::new(name, "", || Ok(Figures::default())));
        assert_eq!(run_all(&cases, 1, &mut Stops).iter().flatten().count(), 1);
    }
}
