//! `supple study --stability`: a row a case, a JSON file, and the exit code.

mod support;

use support::Stage;

#[test]
fn a_study_that_is_killed_leaves_the_earlier_report() {
    let stage = Stage::new();
    std::fs::create_dir(stage.path("out")).unwrap();
    std::fs::write(stage.path("out/stability.json"), "earlier").unwrap();
    let mut study = stage.command(&["study", "--stability", "-o", "out", "--quiet"]).spawn().unwrap();
    let begun = std::time::Instant::now();
    while !stage.path("out/stability.part").exists() {
        assert!(begun.elapsed().as_secs() < 60, "waited in vain");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    study.kill().unwrap();
    assert!(!study.wait().unwrap().success());
    assert_eq!(std::fs::read(stage.path("out/stability.json")).unwrap(), b"earlier");
}

#[test]
#[ignore = "takes a minute; the cases themselves are tests of their own crate"]
fn the_quick_cases_are_written_and_pass() {
    let stage = Stage::new();
    let ended = stage.supple(&["study", "--stability", "--quick", "-o", "out"]);
    ended.expect(0, &[]);
    let text = std::fs::read(stage.path("out/stability.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert!(rows.len() > 50 && report["passed"] == true && report["complete"] == true);
    for row in rows {
        let case = row["case"].as_str().unwrap();
        assert!(ended.out.contains(case), "{case}");
        assert_eq!(row["figures"]["values"]["not_numbers"], 0.0, "{case}");
    }
}
