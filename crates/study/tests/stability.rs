//! All cases as tests: the quick ones in each run, all of them with `--ignored`.

use supple_study::stability::{Case, StabilityReport, Suite, cases};

/// Runs cases on all processors; none may fail.
fn pass(cases: &[Case]) {
    let report = StabilityReport::of(cases, &mut ());
    assert_eq!(report.rows.len(), cases.len());
    assert!(report.passed, "{}", report.table());
}

#[test]
fn the_quick_cases_pass() {
    let mut cases = cases();
    cases.retain(|case| case.suite == Suite::Quick);
    pass(&cases);
}

#[test]
#[ignore = "takes several minutes"]
fn all_cases_pass() {
    pass(&cases());
}

#[test]
fn each_case_has_its_own_name_says_what_it_expects_and_has_a_bound_beyond_not_being_nan() {
    let cases = cases();
    let mut names: Vec<_> = cases.iter().map(|case| (case.family, case.name.as_str())).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), cases.len());
    for case in &cases {
        assert!(!case.shows.is_empty() && case.bounds.len() > 1, "{}", case.name);
    }
}
