//! `supple study --stability`: one row per case, a JSON file, and the exit code.

mod support;

use support::Stage;

#[test]
fn a_killed_study_leaves_the_earlier_report() {
    let stage = Stage::new();
    std::fs::create_dir(stage.path("out")).unwrap();
    std::fs::write(stage.path("out/stability.json"), "earlier").unwrap();
    let mut study = stage.command(&["study", "--stability", "-o", "out", "--quiet"]).spawn().unwrap();
    let start_time = std::time::Instant::now();
    while !stage.path("out/stability.part").exists() {
        assert!(start_time.elapsed().as_secs() < 60, "timed out");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    study.kill().unwrap();
    assert!(!study.wait().unwrap().success());
    assert_eq!(std::fs::read(stage.path("out/stability.json")).unwrap(), b"earlier");
}

#[test]
#[ignore = "takes a minute; the cases are tested in supple-study"]
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
