//! `supple study` writes its files, returns its exit codes and rejects invalid input.

mod support;

use support::{SCENE, Workspace, files};

/// Creates a workspace with the common scene, but fewer frames and lattice vertices.
fn small_workspace() -> Workspace {
    Workspace::with_scene(&SCENE.replace("frames = 20", "frames = 6").replace("= 200", "= 60"))
}

#[test]
fn a_study_of_a_scene_writes_its_three_files_and_a_table() {
    let workspace = small_workspace();
    let output = workspace.supple(&["study", "scene.toml", "--quick", "-o", "out"]);
    output.expect(0, &["%", "left"]);
    assert_eq!(
        files(&workspace.path("out")).keys().collect::<Vec<_>>(),
        ["study.csv", "study.json", "study.svg"]
    );
    for words in ["mesh global", "naive", "breadth-first", "best", "written to out"] {
        assert!(output.out.contains(words), "{words:?} is not in {}", output.out);
    }
    assert!(output.out.lines().all(|line| line.chars().count() <= 80), "{}", output.out);
    let before = files(&workspace.path("out"));
    let again = workspace.supple(&["study", "scene.toml", "--quick", "-o", "out", "--resume", "--quiet"]);
    again.expect(0, &[]);
    assert!(again.err.is_empty() && again.out.contains("already finished"), "{again:?}");
    assert_eq!(files(&workspace.path("out")), before);
    workspace.supple(&["study", "scene.toml", "-o", "out", "--resume"]).expect(2, &["quick", "--resume"]);
    let other = ["study", "scene.toml", "--quick", "-o", "out", "--resume", "--set", "simulation.fps=31"];
    workspace.supple(&other).expect(2, &["fps", "31", "--resume"]);
    assert_eq!(files(&workspace.path("out")), before);
}

#[test]
fn a_study_of_the_sums_needs_no_scene() {
    let workspace = small_workspace();
    let output = workspace.supple(&["study", "--sums", "--quick", "-o", "sums", "--quiet"]);
    output.expect(0, &[]);
    assert_eq!(files(&workspace.path("sums")).keys().collect::<Vec<_>>(), ["sums.csv", "sums.json"]);
    assert!(output.out.contains("global running f32") && output.out.contains("supple"), "{}", output.out);
}

#[test]
fn a_study_of_materials_prints_and_writes_its_figures() {
    let workspace = small_workspace();
    let arguments = ["study", "--material", "--quick", "--filter", "325 vertices", "-o", "out", "--quiet"];
    let output = workspace.supple(&arguments);
    output.expect(0, &[]);
    for words in ["hanging bar", "elongation, m", "0.95 to 1.1", "4 of 4 figures meet", "material.json"] {
        assert!(output.out.contains(words), "{words:?} is not in {}", output.out);
    }
    assert_eq!(files(&workspace.path("out")).keys().collect::<Vec<_>>(), ["material.json"]);
    let text = std::fs::read(workspace.path("out/material.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&text).unwrap();
    assert!(report["complete"] == true && report["passed"] == true);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4, "the elongation and the force of two holds");
    for row in rows {
        let ratio = row["value"].as_f64().unwrap() / row["law"].as_f64().unwrap();
        assert!((row["ratio"].as_f64().unwrap() - ratio).abs() < 1e-12, "{row}");
        let [low, high] = ["low", "high"].map(|end| row["target"][end].as_f64().unwrap());
        assert_eq!(row["met"].as_bool().unwrap(), (low..=high).contains(&ratio), "{row}");
    }
    let stability = ["study", "--stability", "--filter", "Rigid Limit", "-o", "out", "--quiet"];
    let output = workspace.supple(&stability);
    output.expect(0, &[]);
    assert!(output.out.contains("1 of 1 case passed"), "{}", output.out);
}

#[test]
fn invalid_arguments_are_rejected_and_nothing_is_written() {
    let workspace = small_workspace();
    let before = files(&workspace.path("."));
    workspace.supple(&["study"]).expect(2, &["SCENE", "--sums"]);
    workspace.supple(&["study", "scene.toml", "--sums"]).expect(2, &["--sums"]);
    workspace.supple(&["study", "--sums", "--resume"]).expect(2, &["--resume"]);
    workspace.supple(&["study", "--sums", "--stability"]).expect(2, &["--stability"]);
    workspace.supple(&["study", "--stability", "--material"]).expect(2, &["--material"]);
    workspace.supple(&["study", "--material", "--resume"]).expect(2, &["--resume"]);
    workspace.supple(&["study", "--sums", "--filter", "bar"]).expect(2, &["--filter"]);
    for subject in ["--stability", "--material"] {
        let none = ["study", subject, "--filter", "no such case", "-o", "out"];
        workspace.supple(&none).expect(2, &["--filter", "no such case", "families"]);
    }
    workspace.supple(&["study", "none.toml", "-o", "out"]).expect(2, &["none.toml"]);
    workspace
        .supple(&["study", "scene.toml", "--set", "simulation.frames=0", "-o", "out"])
        .expect(2, &["frames", "at least 1"]);
    workspace
        .supple(&["study", "scene.toml", "--set", "body.block.mesh=\"none.obj\""])
        .expect(2, &["none.obj"]);
    assert!(!workspace.path("out").exists());
    assert_eq!(files(&workspace.path(".")), before);
    for subject in ["scene.toml", "--sums", "--stability", "--material"] {
        workspace.supple(&["study", subject, "-o", "block.obj"]).expect(2, &["block.obj", "directory"]);
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_measured_points() {
    use std::process::Stdio;
    use support::ProgramOutput;

    let workspace = small_workspace();
    let arguments = ["study", "scene.toml", "-o", "out", "--set", "simulation.frames=400"];
    let mut command = workspace.command(&arguments);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let study = || std::fs::read_to_string(workspace.path("out/study.json")).unwrap_or_default();
    let start_time = std::time::Instant::now();
    while !study().contains("\"timing\"") {
        assert!(start_time.elapsed().as_secs() < 60, "timed out");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.unwrap().success());
    let output = ProgramOutput::new(child.wait_with_output().unwrap());
    output.expect(130, &[]);
    assert!(output.out.contains("--resume") && output.out.contains("mesh global"), "{output:?}");
    assert!(study().contains("\"complete\": false"));
    assert!(workspace.path("out/study.csv").exists() && workspace.path("out/study.svg").exists());
}
