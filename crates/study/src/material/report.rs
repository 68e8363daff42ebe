//! Runs the cases and reports the results as a table and as JSON.

use std::fmt::Write;
use std::path::PathBuf;
use std::thread::available_parallelism;

use serde::Serialize;

use super::case::{Case, Row};
use super::cases::cases;
use crate::error::StudyError;
use crate::machine::Machine;
use crate::observer::Observer;
use crate::output::{compact, write_json};
use crate::suite::{prepare_report, run_all, select};

/// The study of materials.
#[derive(Clone, Debug)]
pub struct MaterialStudy {
    /// Output directory of `material.json`; created if it does not exist.
    pub directory: PathBuf,
    /// Whether to run only the quick cases, with at most 50,000 lattice vertices.
    pub quick: bool,
    /// Text that the family or the name of a case must contain to be run, in upper or lower case.
    pub filter: Option<String>,
}

/// Results of the cases that were run.
#[derive(Clone, Debug, Serialize)]
pub struct MaterialReport {
    /// Machine that ran the cases.
    pub machine: Machine,
    /// Whether all requested cases were run.
    pub complete: bool,
    /// Whether all targets are met but those that are known to be missed.
    pub passed: bool,
    /// One row per quantity, in the order of the cases.
    pub rows: Vec<Row>,
}

impl MaterialStudy {
    /// Runs the cases on all processors. An earlier report is kept until the new one is complete.
    ///
    /// # Errors
    ///
    /// Returns an error if no case is selected, or if the directory cannot be written. This is checked before any case
    /// runs.
    pub fn run(&self, observer: &mut (dyn Observer + Send)) -> Result<MaterialReport, StudyError> {
        let cases = select(cases(), self.quick, self.filter.as_deref())?;
        prepare_report(&self.directory, &self.path())?;
        let report = MaterialReport::of(&cases, observer);
        write_json(&self.path(), &report)?;
        Ok(report)
    }

    /// Returns the path of the report.
    pub fn path(&self) -> PathBuf {
        self.directory.join("material.json")
    }
}

/// Width of the columns of numbers.
const NUMBER: usize = 9;

impl MaterialReport {
    /// Runs cases on all processors, long ones first, and then the cases that measure run times, one at a time. After
    /// the observer requests a stop, no further case starts.
    pub fn of(cases: &[Case], observer: &mut (dyn Observer + Send)) -> Self {
        let threads = available_parallelism().map_or(1, usize::from);
        let results = run_all(cases, threads, observer);
        let complete = results.iter().all(Option::is_some);
        let rows: Vec<Row> = results.into_iter().flatten().flatten().collect();
        let is_failure = |row: &Row| row.error.is_some() || (!row.met && row.known_miss.is_none());
        let passed = !rows.iter().any(is_failure);
        Self { machine: Machine::here(threads), complete, passed, rows }
    }

    /// Returns the number of rows whose target is met.
    pub fn met(&self) -> usize {
        self.rows.iter().filter(|row| row.met).count()
    }

    /// Formats one row per quantity, grouped by family, with errors and the reasons of known misses below the row. The
    /// text has no final line break.
    pub fn table(&self) -> String {
        let name = |row: &Row| format!("{}: {}", row.case, row.quantity);
        let width = self.rows.iter().map(|row| name(row).chars().count()).max().unwrap_or(0);
        let mut text = format!(
            "      {:width$} {:>NUMBER$} {:>NUMBER$} {:>NUMBER$}  {:<14} {:>5}",
            "", "value", "law", "ratio", "target", "s"
        );
        let mut family = "";
        for row in &self.rows {
            if row.family != family {
                family = row.family;
                let _ = write!(text, "\n{family}");
            }
            let verdict = match (row.met, &row.known_miss) {
                (true, _) => "ok",
                (false, Some(_)) => "miss",
                (false, None) => "FAIL",
            };
            let _ = write!(text, "\n{verdict:>4}  {:width$}", name(row));
            for number in [row.value, row.law, row.ratio] {
                let _ = write!(text, " {:>NUMBER$}", compact(number));
            }
            let _ = write!(text, "  {:<14} {:>5.1}", row.target.to_string(), row.seconds);
            let reason = row.known_miss.as_deref().filter(|_| !row.met);
            for note in [row.error.as_deref(), reason].into_iter().flatten() {
                let _ = write!(text, "\n      {note}");
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::super::case::{Measured, Quantity, Target};
    use super::*;

    #[test]
    fn values_are_compared_with_their_laws_and_targets() {
        let narrow = || Quantity::new("length, m", Target::within(0.9, 1.1));
        let of = |name: &str, quantity: Quantity, measured: Measured| {
            Case::new(name, [quantity], move || Ok(vec![measured]))
        };
        let cases = [
            of("by a law", narrow(), Measured::by_law(2.1, 2.0)),
            of("without a law", narrow(), Measured::from(1.1)),
            of("too long", narrow(), Measured::by_law(3.0, 2.0)),
            of("not a number", narrow(), Measured::from(f64::NAN)),
            of("known", narrow().misses("short of time"), Measured::from(2.0)),
            of("reached", narrow().misses("short of time"), Measured::from(1.0)),
            Case::new("no body", [narrow()], || Err(Box::new(supple::Error::NoBody))),
            Case::new("no value", [narrow()], || Ok(Vec::new())),
            Case::new("no end", [narrow().misses("never")], || panic!("at {}", 1 + 1)),
        ];
        let report = MaterialReport::of(&cases, &mut ());
        let met: Vec<_> = report.rows.iter().map(|row| row.met).collect();
        assert_eq!(met, [true, true, false, false, false, true, false, false, false]);
        assert_eq!((report.passed, report.complete, report.met()), (false, true, 3));
        let table = report.table();
        let verdicts: Vec<_> = table.lines().skip(1).map(|line| line[..4].trim()).collect();
        let expected = ["ok", "ok", "FAIL", "FAIL", "miss", "", "ok", "FAIL", "", "FAIL", "miss", "", ""];
        assert_eq!(verdicts, expected, "{table}");
        assert!(table.contains("panicked: at 2") && table.matches("short of time").count() == 1, "{table}");
        // A known miss does not fail the study, an error does.
        for (index, passed) in [(0, true), (2, false), (4, true), (6, false), (8, false)] {
            assert_eq!(MaterialReport::of(&cases[index..=index], &mut ()).passed, passed, "{index}");
        }
    }
}
