//! `supple study --stability` prints one row per case, writes `stability.json`, and exits with code 0 if all
//! cases pass. If it is killed, the earlier `stability.json` stays unchanged.

mod support;

use support::Workspace;

#[test]
fn a_killed_study_leaves_the_earlier_report() {
    let workspace = Workspace::new();
    std::fs::create_dir(workspace.path("out")).unwrap();
    std::fs::write(workspace.path("out/stability.json"), "earlier").unwrap();
    let mut study = workspace.command(&["study", "--stability", "-o", "out", "--quiet"]).spawn().unwrap();
    let start_time = std::time::Instant::now();
    while !workspace.path("out/stability.part").exists() {
        assert!(start_time.elapsed().as_secs() < 60, "timed out");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    study.kill().unwrap();
    assert!(!study.wait().unwrap().success());
    assert_eq!(std::fs::read(workspace.path("out/stability.json")).unwrap(), b"earlier");
}

#[test]
#[ignore = "takes a minute; the cases are tested in supple-study"]
fn the_quick_cases_are_written_and_pass() {
    let workspace = Workspace::new();
    let output = workspace.supple(&["study", "--stability", "--quick", "-o", "out"]);
    output.expect(0, &[]);
    let text = std::fs::read(workspace.path("out/stability.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let rows = report["rows"].as_array().unwrap();
    assert!(rows.len() > 50 && report["passed"] == true && report["complete"] == true);
    for row in rows {
        let case = row["case"].as_str().unwrap();
        assert!(output.out.contains(case), "{case}");
        assert_eq!(row["figures"]["values"]["not_numbers"], 0.0, "{case}");
    }
}
