//! `--progress json` and `--progress openjd` print the progress for other programs.

mod support;

use serde_json::Value;
use support::{SCENE, Workspace};

#[test]
fn progress_as_json_has_an_object_per_line_of_standard_error() {
    let workspace = Workspace::new();
    workspace.write("missing.toml", SCENE.replace("block.obj", "none.obj"));
    let run = |code: i32, arguments: &[&str]| {
        let mut all = vec!["run", "--progress", "json", "--start-frame", "1001"];
        all.extend(arguments);
        let output = workspace.supple(&all);
        output.expect(code, &[]);
        output.err.lines().map(|line| serde_json::from_str(line).unwrap()).collect::<Vec<Value>>()
    };
    let of = |events: &[Value], kind: &str| -> Vec<Value> {
        events.iter().filter(|event| event["event"] == kind).cloned().collect()
    };
    let events = run(0, &["scene.toml"]);
    assert_eq!((&events[0]["event"], &events[0]["input"]), (&"begin".into(), &"scene.toml".into()));
    let frames = of(&events, "frame");
    assert_eq!(frames.len(), 21);
    for (index, frame) in frames.iter().enumerate() {
        assert_eq!((&frame["frame"], &frame["last"]), (&(1001 + index).into(), &1021.into()));
        assert!((frame["time"].as_f64().unwrap() - index as f64 / 30.0).abs() < 1e-12);
        assert!(frame["elapsed"].as_f64().unwrap() > 0.0 && frame["seconds_left"].as_f64().unwrap() >= 0.0);
    }
    assert_eq!(frames[20]["seconds_left"], 0.0);
    // The faces of the block are larger than its cells.
    assert_eq!(of(&events, "warning").len() + of(&events, "note").len(), 1);
    let end = events.last().unwrap();
    assert_eq!((&end["event"], &end["outcome"]), (&"end".into(), &"finished".into()));
    assert_eq!(
        (&end["frame"], &end["written"], &end["directory"]),
        (&1021.into(), &21.into(), &"out".into())
    );

    let resumed = run(0, &["scene.toml", "--resume", "--frames", "25"]);
    assert!(of(&resumed, "note")[0]["message"].as_str().unwrap().contains("resuming after frame 1021"));
    assert_eq!(of(&resumed, "frame").len(), 5);
    let again = run(0, &["scene.toml", "--resume", "--frames", "25"]);
    assert_eq!(again.last().unwrap()["outcome"], "already finished");

    let several = run(1, &["missing.toml", "scene.toml", "-o", "several"]);
    let ends = of(&several, "end");
    assert_eq!((&ends[0]["input"], &ends[0]["outcome"]), (&"missing.toml".into(), &"failed".into()));
    assert!(ends[0]["error"].as_str().unwrap().contains("none.obj"));
    assert_eq!((&ends[1]["input"], &ends[1]["outcome"]), (&"scene.toml".into(), &"finished".into()));
    assert!(of(&several, "error")[0]["message"].as_str().unwrap().contains("none.obj"));
}

#[test]
fn progress_for_open_job_description_has_percentages_and_the_status() {
    let workspace = Workspace::new();
    workspace.write("missing.toml", SCENE.replace("block.obj", "none.obj"));
    let run = |code: i32, inputs: &[&str]| {
        let mut all = vec!["run", "--progress", "openjd", "-o", "out"];
        all.extend(inputs);
        let output = workspace.supple(&all);
        output.expect(code, &[]);
        let percentages = output.out.lines().filter_map(|line| line.strip_prefix("openjd_progress: "));
        (percentages.map(|text| text.parse().unwrap()).collect::<Vec<u32>>(), output)
    };
    let (percentages, output) = run(0, &["scene.toml"]);
    assert_eq!(percentages, [vec![0], (1..=21).map(|frame| 100 * frame / 21).collect()].concat());
    assert!(output.out.contains("openjd_status: scene: frame 10 of 20, "), "{}", output.out);
    assert!(output.out.contains("openjd_status: scene: finished, frame 20\n"), "{}", output.out);
    assert!(!output.err.contains('%'), "{}", output.err);
    let (percentages, output) = run(1, &["scene.toml", "missing.toml"]);
    assert!(percentages.is_sorted() && percentages.last() == Some(&50), "{percentages:?}");
    let failures: Vec<_> = output.out.lines().filter(|line| line.starts_with("openjd_fail: ")).collect();
    assert!(failures.len() == 1 && failures[0].contains("none.obj"), "{failures:?}");
}

#[test]
fn progress_can_be_left_out() {
    let workspace = Workspace::new();
    let none = workspace.supple(&["run", "scene.toml", "--progress", "none"]);
    none.expect(0, &[]);
    assert_eq!(none.messages(), "");
    workspace
        .supple(&["run", "scene.toml", "--progress", "bar"])
        .expect(0, &["scene: 100 %, frame 20 of 20"]);
    workspace.supple(&["run", "scene.toml", "-q", "--progress", "json"]).expect(2, &["cannot be used with"]);
}
