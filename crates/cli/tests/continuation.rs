//! `--from` continues a run after a kept state, with a scene that may have changed.

mod support;

use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use support::{SCENE, Workspace};

/// Moves the handle of [`workspace`] to another place in the end.
const OTHER_KEYS: &str = "body.block.handle.0.keys=[{ time = 0 }, { time = 0.3, translate = [0, 0, 0.5] }]";

/// Returns a workspace with a scene that has a handle and keeps states after frames 6, 12 and 18.
fn workspace() -> Workspace {
    let handle = "[[body.handle]]\nbox = { min = [0.9, 0, -1], max = [2, 5, 1] }\n\
                  keys = [{ time = 0 }, { time = 0.3, translate = [0, 0.5, 0] }]\n\n[[collider]]";
    let scene = SCENE.replace("[[collider]]", handle);
    Workspace::with_scene(&scene.replace("directory = \"out\"", "directory = \"out\"\nstates = 6"))
}

/// Runs the scene of a workspace, and returns the messages.
fn run(workspace: &Workspace, arguments: &[&str]) -> String {
    let output = workspace.supple(&[&["run", "scene.toml"][..], arguments].concat());
    output.expect(0, &[]);
    output.err
}

/// Returns the names and modification times of the files in the output directory.
fn times(directory: &Path) -> Vec<(std::ffi::OsString, std::time::SystemTime)> {
    let entries = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap());
    let entries = entries.map(|entry| (entry.file_name(), entry.metadata().unwrap().modified().unwrap()));
    let mut times: Vec<_> =
        entries.filter(|(name, _)| name != ".supple.lock" && name != "supple.lock").collect();
    times.sort();
    times
}

#[test]
fn continuing_an_unchanged_scene_gives_the_frames_of_an_uninterrupted_run() {
    for format in ["obj", "ply", "pc2", "html", "vtu", "obj,pc2,html"] {
        let workspace = workspace();
        let stats = |name: &str| -> Vec<serde_json::Map<String, serde_json::Value>> {
            let text = std::fs::read_to_string(workspace.path(name)).unwrap();
            let mut rows: Vec<serde_json::Map<String, serde_json::Value>> =
                serde_json::from_str(&text).unwrap();
            rows.iter_mut().for_each(|row| row.retain(|key, _| !key.starts_with("ms_")));
            rows
        };
        run(&workspace, &["--format", format, "-o", "whole"]);
        run(&workspace, &["--format", format, "-o", "with_stats", "--stats", "whole.json"]);
        run(&workspace, &["--format", format]);
        let before = times(&workspace.path("out"));
        // The number of frames may change, also so that frame numbers would have other digits.
        let messages = run(&workspace, &["--format", format, "--from", "14"]);
        assert!(messages.contains("resuming after frame 12"), "{messages}");
        assert!(workspace.frames("out") == workspace.frames("whole"), "{format}");
        let is_kept = |name: &str| before.iter().any(|(kept, _)| kept.to_str() == Some(name));
        assert!(is_kept("supple_0006.state") && is_kept("supple_0018.state"));
        if format == "obj" {
            let after = times(&workspace.path("out"));
            let written = after.iter().filter(|entry| !before.contains(entry));
            let written: Vec<&str> = written.filter_map(|(name, _)| name.to_str()).collect();
            assert!(
                written.contains(&"block_0013.obj") && written.contains(&"supple_0018.state"),
                "{written:?}"
            );
            assert!(
                !written.iter().any(|name| *name < "block_0013.obj" && name.starts_with("block")),
                "{written:?}"
            );
            assert!(!written.contains(&"supple_0012.state"), "{written:?}");
        }
        run(&workspace, &["--format", format, "-o", "with_stats", "--stats", "whole.json", "--from=7"]);
        run(&workspace, &["--format", format, "-o", "again", "--stats", "again.json"]);
        assert_eq!(stats("whole.json"), stats("again.json"));
    }
}

#[test]
fn usd_stages_and_stopped_clips_continue_and_complete_clips_are_refused() {
    let workspace = workspace();
    run(&workspace, &["--format", "usd", "-o", "whole"]);
    run(&workspace, &["--format", "usd"]);
    run(&workspace, &["--format", "usd", "--from", "6", "--set", OTHER_KEYS]);
    run(&workspace, &["--format", "usd", "--from", "6"]);
    let [whole, out] =
        ["whole", "out"].map(|name| std::fs::metadata(workspace.path(name).join("supple.usd")));
    assert_eq!(whole.unwrap().len(), out.unwrap().len());
    for format in ["glb", "vat", "film"] {
        run(&workspace, &["--format", format, "-o", format]);
        let before = times(&workspace.path(format));
        let refused =
            workspace.supple(&["run", "scene.toml", "--format", format, "-o", format, "--from", "12"]);
        refused.expect(2, &[&format!("`{format}`"), "run from frame 0", "write obj"]);
        assert_eq!(times(&workspace.path(format)), before);
    }
}

#[test]
fn a_changed_scene_keeps_earlier_frames_and_states_and_replaces_later_ones() {
    let workspace = workspace();
    run(&workspace, &["-o", "whole"]);
    run(&workspace, &[]);
    let messages = run(&workspace, &["--from", "12", "--set", OTHER_KEYS, "--frames", "15"]);
    assert!(messages.contains("resuming after frame 12"), "{messages}");
    let (out, whole) = (workspace.frames("out"), workspace.frames("whole"));
    let names: Vec<&str> = out.keys().map(String::as_str).collect();
    assert!(names.contains(&"block_0015.obj") && !names.contains(&"block_0016.obj"), "{names:?}");
    assert!(names.contains(&"supple_0012.state") && !names.contains(&"supple_0018.state"), "{names:?}");
    for frame in 0..=15 {
        let name = format!("block_{frame:04}.obj");
        assert_eq!(out[&name] == whole[&name], frame <= 12, "{name}");
    }
    // The checkpoint is that of the changed scene.
    run(&workspace, &["--resume", "--set", OTHER_KEYS]);
    workspace.supple(&["run", "scene.toml", "--resume"]).expect(2, &["[[body.handle]]"]);
    // Back to the first scene, from a state before the change.
    run(&workspace, &["--from", "12"]);
    assert!(workspace.frames("out") == whole);
}

#[test]
fn all_settings_that_a_state_can_take_over_change_the_next_frames() {
    for change in [
        "simulation.gravity=[0, -2, 0]",
        "simulation.substeps=3",
        "body.block.half_width=2",
        "body.block.material=jelly",
        "body.block.poisson_ratio=0.3",
        "body.block.region_damping=0.5",
        "body.block.plastic.creep=1",
        "body.block.volume=off",
        "body.block.inflate=1.5",
        "body.block.zone=[{ box = { min = [-3, 0, -3], max = [3, 2, 3] }, factor = 0.1 }]",
        "body.block.handle=[]",
        "body.block.pin.0.end=0.6",
        "body.block.handle.0.end=0.25",
        "collider.0.plane={ point = [0, 1.5, 0], normal = [0, 1, 0] }",
        "collider.0={ sphere = { center = [0, 1, 0], radius = 1 } }",
        "field=[{ wind = { velocity = [0, 0, 9], drag = 5 } }]",
    ] {
        let workspace = workspace();
        run(&workspace, &["-o", "whole", "--frames", "9"]);
        run(&workspace, &["--frames", "9"]);
        run(&workspace, &["--frames", "9", "--from", "6", "--set", change]);
        let (out, whole) = (workspace.frames("out"), workspace.frames("whole"));
        assert!(out["block_0006.obj"] == whole["block_0006.obj"], "{change}");
        assert!(out["block_0009.obj"] != whole["block_0009.obj"], "{change}");
    }
}

#[test]
fn changes_that_a_state_cannot_take_over_are_refused_with_the_key_and_nothing_is_written() {
    let workspace = workspace();
    let arguments = ["run", "scene.toml", "--stats", "s.csv"];
    workspace.supple(&arguments).expect(0, &[]);
    let before = times(&workspace.path("out"));
    let continued = |more: &[&str]| workspace.supple(&[&arguments[..], more].concat());
    for (change, words) in [
        ("body.block.lattice_vertices=300", "`body.block.lattice_vertices` changed from 200 to 300"),
        ("body.block.cell_size=0.4", "`body.block.lattice_vertices = 200` was removed"),
        ("body.block.scale=2", "`body.block.scale` changed from 1.0 to 2.0"),
        ("body.block.translate=[0, 2, 0]", "`body.block.translate`"),
        ("body.block.velocity=[0, 2, 0]", "`body.block.velocity`"),
        ("body.block.skin=smooth", "`body.block.skin`"),
        ("body.block.fracture={ strain = 0.5 }", "`body.block.fracture"),
        ("body.block.name=other", "`body.0.name` changed from \"block\" to \"other\""),
        ("simulation.fps=25", "`simulation.fps` changed from 30.0 to 25.0"),
        ("collider=[]", "the number of `[[collider]]` changed from 1 to 0"),
        ("output.format=ply", "the format changed from obj to ply"),
        ("output.scale=2", "`output.scale` of the files changed"),
    ] {
        continued(&["--from", "12", "--set", change]).expect(2, &[words, "run from frame 0"]);
    }
    continued(&["--from", "12", "--every", "2"]).expect(2, &["`every`"]);
    continued(&["--from", "5"])
        .expect(2, &["no state at or before frame 5", "is of frame 6", "output.states = 30"]);
    continued(&["--from", "20"])
        .expect(2, &["`from` is 20", "the last frame is 20", "less than the last frame"]);
    continued(&["--from", "12", "--resume"]).expect(2, &["--from", "--resume", "cannot be used with"]);
    continued(&["--from", "1012", "--start-frame", "1001"])
        .expect(2, &["number of the first frame changed from 0 to 1001"]);
    continued(&["--from", "5", "--start-frame", "6"]).expect(2, &["`from` is 5", "start_frame"]);
    continued(&["--from", "-1"]).expect(2, &["a whole number"]);
    for value in ["0", "1.5", "-2", "\"many\""] {
        continued(&["--set", &format!("output.states={value}")]).expect(2, &["output.states"]);
    }
    workspace.supple(&["run", "scene.toml", "--from", "12"]).expect(2, &["statistics"]);
    workspace.supple(&["run", "scene.toml", "-o", "none", "--from", "12"]).expect(2, &["none has none"]);
    workspace.write("block.obj", support::BLOCK.replace("1 3 0.5", "1.5 3 0.5"));
    continued(&["--from", "12"]).expect(2, &["`body.block.mesh`: the mesh file has changed"]);
    workspace.write("block.obj", support::BLOCK);
    assert_eq!(times(&workspace.path("out")), before);

    std::fs::write(workspace.path("out/supple_0012.state"), "not a state, but long enough for one").unwrap();
    continued(&["--from", "12"]).expect(2, &["supple_0012.state", "not a checkpoint"]);
    std::fs::copy(workspace.path("out/supple_0006.state"), workspace.path("out/supple_0012.state")).unwrap();
    continued(&["--from", "12"]).expect(2, &["supple_0012.state", "the frame in its name"]);
    std::fs::remove_file(workspace.path("out/supple_0012.state")).unwrap();
    std::fs::remove_file(workspace.path("out/block_0003.obj")).unwrap();
    continued(&["--from", "12"]).expect(2, &["block_0003.obj is missing"]);
}

#[test]
fn states_are_in_the_manifest_and_removed_with_an_earlier_sequence() {
    let workspace = workspace();
    let listed = || -> Vec<String> {
        let text = std::fs::read_to_string(workspace.path("out/manifest.json")).unwrap();
        let manifest: serde_json::Value = serde_json::from_str(&text).unwrap();
        let files = manifest["files"].as_array().unwrap().iter();
        let states = files.filter(|file| file["name"].as_str().unwrap().ends_with(".state"));
        states
            .filter(|file| file["xxh3"].is_string())
            .map(|file| file["name"].as_str().unwrap().to_owned())
            .collect()
    };
    run(&workspace, &["--start-frame", "1001"]);
    assert_eq!(listed(), ["supple_1007.state", "supple_1013.state", "supple_1019.state"]);
    let messages = run(&workspace, &["--start-frame", "1001", "--from", "1010"]);
    assert!(messages.contains("resuming after frame 1007"), "{messages}");
    run(&workspace, &["--set", "output.states=9", "--frames", "9"]);
    assert_eq!(listed(), ["supple_0009.state"]);
    // The first frame needs no state.
    run(
        &workspace,
        &["--from", "0", "--set", "body.block.lattice_vertices=300", "--set", "output.states=20"],
    );
    assert_eq!(listed(), ["supple_0020.state"]);
    // Without states, the checkpoint of a run that was extended.
    run(&workspace, &["--frames", "24", "--from", "22", "--set", "body.block.lattice_vertices=300"]);
    workspace.write("supple_0001.state", support::BLOCK);
    let input = ["run", "scene.toml", "-o", ".", "--set", "body.block.mesh=supple_0001.state"];
    workspace.supple(&input).expect(2, &["supple_0001.state"]);
}

#[test]
fn a_continued_run_that_is_killed_resumes_with_the_changed_scene() {
    let workspace = workspace();
    let changed =
        ["--frames", "150", "--checkpoint", "0", "--set", OTHER_KEYS, "--set", "simulation.substeps=40"];
    for directory in ["whole", "out"] {
        run(&workspace, &["--frames", "20", "-o", directory]);
    }
    run(&workspace, &[&changed[..], &["-o", "whole", "--from", "12"]].concat());
    let arguments = [&["run", "scene.toml", "--from", "12"][..], &changed].concat();
    let mut child =
        workspace.command(&arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let start = Instant::now();
    while !workspace.path("out/block_0030.obj").exists() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    run(&workspace, &[&changed[..], &["--resume"]].concat());
    assert!(workspace.frames("out") == workspace.frames("whole"));
}
