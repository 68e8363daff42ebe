//! `supple study`: files, exit codes and refused input.

mod support;

use support::{SCENE, Stage, files};

/// Creates the common scene with fewer frames and lattice vertices.
fn stage() -> Stage {
    Stage::of(&SCENE.replace("frames = 20", "frames = 6").replace("= 200", "= 60"))
}

#[test]
fn a_study_of_a_scene_writes_its_three_files_and_a_table() {
    let stage = stage();
    let ended = stage.supple(&["study", "scene.toml", "--quick", "-o", "out"]);
    ended.expect(0, &["%", "left"]);
    assert_eq!(
        files(&stage.path("out")).keys().collect::<Vec<_>>(),
        ["study.csv", "study.json", "study.svg"]
    );
    for words in ["mesh global", "naive", "breadth-first", "best", "written to out"] {
        assert!(ended.out.contains(words), "{words:?} is not in {}", ended.out);
    }
    assert!(ended.out.lines().all(|line| line.chars().count() <= 80), "{}", ended.out);
    let before = files(&stage.path("out"));
    let again = stage.supple(&["study", "scene.toml", "--quick", "-o", "out", "--resume", "--quiet"]);
    again.expect(0, &[]);
    assert!(again.err.is_empty() && again.out.contains("already finished"), "{again:?}");
    assert_eq!(files(&stage.path("out")), before);
    stage.supple(&["study", "scene.toml", "-o", "out", "--resume"]).expect(2, &["quick", "--resume"]);
    let other = ["study", "scene.toml", "--quick", "-o", "out", "--resume", "--set", "simulation.fps=31"];
    stage.supple(&other).expect(2, &["fps", "31", "--resume"]);
    assert_eq!(files(&stage.path("out")), before);
}

#[test]
fn a_study_of_the_sums_needs_no_scene() {
    let stage = stage();
    let ended = stage.supple(&["study", "--sums", "--quick", "-o", "sums", "--quiet"]);
    ended.expect(0, &[]);
    assert_eq!(files(&stage.path("sums")).keys().collect::<Vec<_>>(), ["sums.csv", "sums.json"]);
    assert!(ended.out.contains("global running f32") && ended.out.contains("supple"), "{}", ended.out);
}

#[test]
fn wrong_arguments_write_nothing() {
    let stage = stage();
    let before = files(&stage.path("."));
    stage.supple(&["study"]).expect(2, &["SCENE", "--sums"]);
    stage.supple(&["study", "scene.toml", "--sums"]).expect(2, &["--sums"]);
    stage.supple(&["study", "--sums", "--resume"]).expect(2, &["--resume"]);
    stage.supple(&["study", "--sums", "--stability"]).expect(2, &["--stability"]);
    stage.supple(&["study", "none.toml", "-o", "out"]).expect(2, &["none.toml"]);
    stage
        .supple(&["study", "scene.toml", "--set", "simulation.frames=0", "-o", "out"])
        .expect(2, &["frames", "at least 1"]);
    stage.supple(&["study", "scene.toml", "--set", "body.block.mesh=\"none.obj\""]).expect(2, &["none.obj"]);
    assert!(!stage.path("out").exists());
    assert_eq!(files(&stage.path(".")), before);
    for subject in ["scene.toml", "--sums", "--stability"] {
        stage.supple(&["study", subject, "-o", "block.obj"]).expect(2, &["block.obj", "directory"]);
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_the_measured_points() {
    use std::process::Stdio;
    use support::Ended;

    let stage = stage();
    let arguments = ["study", "scene.toml", "-o", "out", "--set", "simulation.frames=400"];
    let mut command = stage.command(&arguments);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let study = || std::fs::read_to_string(stage.path("out/study.json")).unwrap_or_default();
    let start_time = std::time::Instant::now();
    while !study().contains("\"timing\"") {
        assert!(start_time.elapsed().as_secs() < 60, "timed out");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.unwrap().success());
    let ended = Ended::of(child.wait_with_output().unwrap());
    ended.expect(130, &[]);
    assert!(ended.out.contains("--resume") && ended.out.contains("mesh global"), "{ended:?}");
    assert!(study().contains("\"complete\": false"));
    assert!(stage.path("out/study.csv").exists() && stage.path("out/study.svg").exists());
}
