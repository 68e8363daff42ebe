//! Selects the cases of a study and runs them on several threads.

use std::any::Any;
use std::fmt::Display;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use supple_io::run::Flow;

use crate::error::StudyError;
use crate::observer::{Observer, Progress};
use crate::output::create_directory;

/// Run-time class of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suite {
    /// Part of a quick run.
    Quick,
    /// Takes longer; not part of a quick run.
    Long,
}

/// A case of a study.
pub(crate) trait Runnable: Sync {
    /// Result of a case.
    type Row: Send;
    /// Returns the family of the case.
    fn family(&self) -> &str;
    /// Returns the name of the case.
    fn name(&self) -> &str;
    /// Returns the run-time class.
    fn suite(&self) -> Suite;
    /// Returns whether the case measures run times. Such cases run alone, after all others.
    fn is_timed(&self) -> bool {
        false
    }
    /// Runs the case.
    fn run(&self) -> Self::Row;
}

/// Keeps the cases of a study that are requested: with `quick` only the quick cases, and with a `filter` only those
/// whose family or name contains it, in upper or lower case.
///
/// # Errors
///
/// Returns an error if no case is left.
pub(crate) fn select<C: Runnable>(
    mut cases: Vec<C>,
    quick: bool,
    filter: Option<&str>,
) -> Result<Vec<C>, StudyError> {
    let Some(filter) = filter else {
        cases.retain(|case| !quick || case.suite() == Suite::Quick);
        return Ok(cases);
    };
    let mut families: Vec<String> = cases.iter().map(|case| case.family().to_owned()).collect();
    families.dedup();
    let text = filter.to_lowercase();
    let has_text =
        |case: &C| [case.family(), case.name()].iter().any(|name| name.to_lowercase().contains(&text));
    cases.retain(|case| (!quick || case.suite() == Suite::Quick) && has_text(case));
    if cases.is_empty() {
        return Err(StudyError::NoCase { filter: filter.to_owned(), quick, families });
    }
    Ok(cases)
}

/// Creates the directory of a report, and checks that the report can be written. An earlier report is unchanged.
pub(crate) fn prepare_report(directory: &Path, report: &Path) -> Result<(), StudyError> {
    create_directory(directory)?;
    fs::write(report.with_extension("part"), "").map_err(|error| StudyError::file("write", report, error))
}

/// Runs cases on `threads` threads, one case per thread at a time and long ones first; then the timed cases, one after
/// the other. Returns the row of each case, or `None` for cases that did not start before the observer requested a
/// stop.
pub(crate) fn run_all<C: Runnable>(
    cases: &[C],
    threads: usize,
    observer: &mut (dyn Observer + Send),
) -> Vec<Option<C::Row>> {
    let (timed, mut others): (Vec<usize>, Vec<usize>) =
        (0..cases.len()).partition(|&index| cases[index].is_timed());
    others.sort_by_key(|&index| cases[index].suite() == Suite::Quick);
    let rows = cases.iter().map(|_| None).collect();
    let results = Mutex::new(Results { rows, count: 0, stopped: false, observer });
    for (order, threads) in [(others, threads), (timed, 1)] {
        let next = AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                        if results.lock().is_ok_and(|results| results.stopped) {
                            return;
                        }
                        let row = cases[index].run();
                        let Ok(mut results) = results.lock() else { return };
                        results.add(index, row, cases[index].name());
                    }
                });
            }
        });
    }
    results.into_inner().map_or_else(|_| Vec::new(), |results| results.rows)
}

/// The rows of the cases that ended.
struct Results<'a, R> {
    rows: Vec<Option<R>>,
    count: u32,
    stopped: bool,
    observer: &'a mut (dyn Observer + Send),
}

impl<R> Results<'_, R> {
    /// Adds the row of a case and reports the progress.
    fn add(&mut self, index: usize, row: R, name: &str) {
        self.rows[index] = Some(row);
        self.count += 1;
        let done = f64::from(self.count) / self.rows.len() as f64;
        self.stopped |= self.observer.progress(&Progress { done, point: name }) == Flow::Stop;
    }
}

/// Calls `run` and returns its result, or the text of its error or panic.
pub(crate) fn caught<T, E: Display>(run: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    // A case builds its own bodies, so state that a panic left inconsistent is not used again.
    let result = catch_unwind(AssertUnwindSafe(|| run().map_err(|error| error.to_string())));
    result.unwrap_or_else(|panic| Err(format!("panicked: {}", message(&*panic))))
}

/// Returns the message of a panic.
fn message(panic: &(dyn Any + Send)) -> &str {
    let literal = panic.downcast_ref::<&str>().copied();
    literal.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Named(&'static str, Suite, bool);

    impl Runnable for Named {
        type Row = &'static str;
        fn family(&self) -> &str {
            "Letters"
        }
        fn name(&self) -> &str {
            self.0
        }
        fn suite(&self) -> Suite {
            self.1
        }
        fn is_timed(&self) -> bool {
            self.2
        }
        fn run(&self) -> &'static str {
            self.0
        }
    }

    fn letters() -> Vec<Named> {
        vec![Named("a", Suite::Quick, true), Named("b", Suite::Quick, false), Named("c", Suite::Long, false)]
    }

    /// Records the order of the cases, and stops after a number of them.
    struct Order(Vec<String>, usize);

    impl Observer for Order {
        fn progress(&mut self, progress: &Progress<'_>) -> Flow {
            self.0.push(progress.point.to_owned());
            if self.0.len() < self.1 { Flow::Continue } else { Flow::Stop }
        }
    }

    #[test]
    fn long_cases_run_first_and_timed_cases_last() {
        let mut order = Order(Vec::new(), 9);
        let rows = run_all(&letters(), 1, &mut order);
        assert_eq!(rows, [Some("a"), Some("b"), Some("c")]);
        assert_eq!(order.0, ["c", "b", "a"]);
    }

    #[test]
    fn no_case_starts_after_a_stop() {
        for (count, rows) in [(1, [None, None, Some("c")]), (2, [None, Some("b"), Some("c")])] {
            assert_eq!(run_all(&letters(), 1, &mut Order(Vec::new(), count)), rows);
        }
    }

    #[test]
    fn a_filter_selects_by_family_and_name_and_an_empty_selection_is_an_error() {
        let names = |quick, filter| -> Vec<&str> {
            select(letters(), quick, filter).unwrap().iter().map(|case| case.0).collect()
        };
        assert_eq!(names(false, None), ["a", "b", "c"]);
        assert_eq!(names(true, None), ["a", "b"]);
        assert_eq!(names(true, Some("letTERS")), ["a", "b"]);
        assert_eq!(names(false, Some("C")), ["c"]);
        let error = select(letters(), true, Some("c")).err().unwrap();
        assert!(error.is_input());
        assert_eq!(
            error.to_string(),
            "--filter \"c\": no quick case has this text in its name or family; the families are: Letters"
        );
    }
}
