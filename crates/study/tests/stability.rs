//! Runs the stability cases as tests: the quick cases in each run, all cases with `--ignored`.

use supple_study::stability::{Case, StabilityReport, Suite, cases};

/// Runs cases on all processors and asserts that all of them pass.
fn assert_all_pass(cases: &[Case]) {
    let report = StabilityReport::of(cases, &mut ());
    assert_eq!(report.rows.len(), cases.len());
    assert!(report.passed, "{}", report.table());
}

#[test]
fn the_quick_cases_pass() {
    let mut cases = cases();
    cases.retain(|case| case.suite == Suite::Quick);
    assert_all_pass(&cases);
}

#[test]
#[ignore = "takes several minutes"]
fn all_cases_pass() {
    assert_all_pass(&cases());
}

#[test]
fn cases_have_unique_names_expectations_and_bounds() {
    let cases = cases();
    let mut names: Vec<_> = cases.iter().map(|case| (case.family, case.name.as_str())).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), cases.len());
    for case in &cases {
        assert!(!case.expected.is_empty() && case.bounds.len() > 1, "{}", case.name);
    }
}
