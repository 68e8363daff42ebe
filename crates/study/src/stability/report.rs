//! The report on all cases: a table for people, rows for programs.

use std::fmt::Write;

use super::{Bound, Case, Figures, Measure, Ran};

/// What came out of the cases that were run.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// Whether all bounds hold of all cases.
    pub passed: bool,
    /// One for each case that was run, in the order of the cases.
    pub rows: Vec<Row>,
}

/// One case of the report.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// Which cases it belongs to.
    pub family: &'static str,
    /// What was done.
    pub case: String,
    /// What was expected.
    pub expected: &'static str,
    /// Whether all bounds hold.
    pub passed: bool,
    /// What it was held to.
    pub bounds: Vec<Bound>,
    /// The bounds that do not hold.
    pub broken: Vec<Bound>,
    /// What was measured.
    pub figures: Figures,
    /// Why it could not be run to its end.
    pub error: Option<String>,
    /// How long it took on one thread, in seconds.
    pub seconds: f64,
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

impl Report {
    /// On cases, and what came out of those that were run.
    pub fn new(cases: &[Case], ran: &[Option<Ran>]) -> Self {
        let rows = cases.iter().zip(ran).filter_map(|(case, ran)| {
            let Ran { outcome, elapsed } = ran.as_ref()?;
            Some(Row {
                family: case.family,
                case: case.name.clone(),
                expected: case.shows,
                passed: outcome.passed(),
                bounds: case.bounds.clone(),
                broken: outcome.broken.clone(),
                figures: outcome.figures.clone(),
                error: outcome.error.clone(),
                seconds: elapsed.as_secs_f64(),
            })
        });
        let rows: Vec<Row> = rows.collect();
        Self { passed: rows.iter().all(|row| row.passed), rows }
    }

    /// A row for each case, under the name of its family; what fails is said below it. Ends without a line break.
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::stability::run_all;

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
            Case::new("one", "good", "", figures).bound(Measure::LargestSpeed, 2.0),
            Case::new("one", "too fast", "", figures).bound(Measure::LargestSpeed, 1.5),
            Case::new("two", "no number", "", figures).bound(Measure::Shape, 1e9),
            Case::new("two", "no figure", "", figures).bound(Measure::Place, 1e9),
            Case::new("two", "no body", "", || Err(supple::Error::NoBody)),
            Case::new("two", "no end", "", || panic!("at {}", 1 + 1)),
            Case::new("two", "no reason", "", || panic!("never")),
        ];
        let ran = run_all(&cases, 2, |_, _| true);
        let report = Report::new(&cases, &ran);
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
        assert!(ran.iter().flatten().all(|ran| ran.elapsed < Duration::from_secs(1)));
    }

    #[test]
    fn what_was_not_run_is_left_out() {
        let cases = ["a", "b", "c"].map(|name| Case::new("one", name, "", || Ok(Figures::default())));
        let report = Report::new(&cases, &run_all(&cases, 1, |_, _| false));
        assert_eq!(report.rows.len(), 1);
    }
}
