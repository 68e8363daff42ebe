//! Runs the cases on several threads and reports the results as a table and as JSON.

use std::fmt::Write;
use std::path::PathBuf;
use std::thread::available_parallelism;

use serde::Serialize;

use super::case::{Bound, Case, Measure, Row};
use super::cases::cases;
use crate::error::StudyError;
use crate::machine::Machine;
use crate::observer::Observer;
use crate::output::write_json;
use crate::suite::{prepare_report, run_all, select};

/// The study of stiff and extreme cases.
#[derive(Clone, Debug)]
pub struct StabilityStudy {
    /// Output directory of `stability.json`; created if it does not exist.
    pub directory: PathBuf,
    /// Whether to run only the quick cases.
    pub quick: bool,
    /// Text that the family or the name of a case must contain to be run, in upper or lower case.
    pub filter: Option<String>,
}

/// Results of the cases that were run.
#[derive(Clone, Debug, Serialize)]
pub struct StabilityReport {
    /// Machine that ran the cases.
    pub machine: Machine,
    /// Whether all requested cases were run.
    pub complete: bool,
    /// Whether all cases passed.
    pub passed: bool,
    /// One row per case that was run, in the order of the cases.
    pub rows: Vec<Row>,
    /// Number of requested cases.
    #[serde(skip)]
    pub requested: usize,
}

impl StabilityStudy {
    /// Runs the cases on all processors. An earlier report is kept until the new one is complete.
    ///
    /// # Errors
    ///
    /// Returns an error if no case is selected, or if the directory cannot be written. This is checked before any case
    /// runs.
    pub fn run(&self, observer: &mut (dyn Observer + Send)) -> Result<StabilityReport, StudyError> {
        let cases = select(cases(), self.quick, self.filter.as_deref())?;
        prepare_report(&self.directory, &self.path())?;
        let report = StabilityReport::of(&cases, observer);
        write_json(&self.path(), &report)?;
        Ok(report)
    }

    /// Returns the path of the report.
    pub fn path(&self) -> PathBuf {
        self.directory.join("stability.json")
    }
}

/// The figures in the columns of the table.
const COLUMNS: [(&str, Measure); 8] = [
    ("NaN", Measure::NotNumbers),
    ("speed", Measure::LargestSpeed),
    ("energy", Measure::EnergyGain),
    ("shape", Measure::Shape),
    ("place", Measure::Place),
    ("angular", Measure::Angular),
    ("capped", Measure::Capped),
    ("fallback", Measure::Unsettled),
];

impl StabilityReport {
    /// Runs cases on all processors, long ones first. After the observer requests a stop, no further case
    /// starts.
    pub fn of(cases: &[Case], observer: &mut (dyn Observer + Send)) -> Self {
        let threads = available_parallelism().map_or(1, usize::from);
        let rows: Vec<Row> = run_all(cases, threads, observer).into_iter().flatten().collect();
        Self {
            machine: Machine::here(threads),
            complete: rows.len() == cases.len(),
            passed: rows.iter().all(|row| row.passed),
            rows,
            requested: cases.len(),
        }
    }

    /// Formats one row per case, grouped by family, with the violated bounds below the row. The text has no
    /// final line break.
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
                let value = row.figures.get(*measure).map_or_else(|| "not measured".into(), short);
                let _ = write!(text, "\n      {}: {value}, the bound is {}", measure.label(), short(*limit));
            }
            if let Some(error) = &row.error {
                let _ = write!(text, "\n      {error}");
            }
        }
        text
    }
}

/// Formats a number in at most eight characters.
fn short(value: f64) -> String {
    if value == 0.0 || (value.fract() == 0.0 && value.abs() < 1e5) {
        format!("{value}")
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::case::Figures;

    #[test]
    fn violated_bounds_missing_figures_errors_and_panics_fail_a_case() {
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
        assert!(table.contains("place, cells: not measured"), "{table}");
        assert_eq!(table.lines().filter(|line| line.starts_with("FAIL")).count(), 6, "{table}");
        assert!(table.contains("panicked: at 2") && table.contains("panicked: never"), "{table}");
        assert!(report.rows.iter().all(|row| row.seconds < 1.0));
    }
}
