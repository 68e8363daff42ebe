//! `manifest.json` lists the files of a finished or stopped run, with sizes and hashes. A run in progress has none.

mod support;

use serde_json::Value;
use support::{BLOCK, SCENE, Workspace};
use xxhash_rust::xxh3::xxh3_64;

fn manifest(workspace: &Workspace) -> Value {
    serde_json::from_slice(&std::fs::read(workspace.path("out/manifest.json")).unwrap()).unwrap()
}

/// Checks that the manifest lists exactly the files in `out` that are frames, with their sizes and hashes.
#[track_caller]
fn check_files(workspace: &Workspace, format: &str) {
    let manifest = manifest(workspace);
    let files = manifest["files"].as_array().unwrap();
    let mut names: Vec<&str> = files.iter().map(|file| file["name"].as_str().unwrap()).collect();
    names.sort_unstable();
    let found = workspace.frames("out");
    let of_format = |name: &&String| format.split(',').any(|format| name.ends_with(&format!(".{format}")));
    assert_eq!(names, found.keys().filter(of_format).collect::<Vec<_>>());
    for file in files {
        let bytes = std::fs::read(workspace.path("out").join(file["name"].as_str().unwrap())).unwrap();
        assert_eq!(file["bytes"], bytes.len());
        match file.get("xxh3") {
            Some(hash) => assert_eq!(*hash, format!("{:016x}", xxh3_64(&bytes))),
            None => assert!(file["name"].as_str().unwrap().ends_with(".pc2")),
        }
    }
}

#[test]
fn the_manifest_lists_the_files_of_a_run_and_follows_its_changes() {
    let workspace = Workspace::new();
    let options = ["--format", "obj,pc2", "--every", "2", "--start-frame", "1001", "--set", "output.fps=25"];
    let run = |more: &[&str]| {
        let mut arguments = vec!["run", "scene.toml"];
        arguments.extend(options);
        arguments.extend(more);
        workspace.supple(&arguments).expect(0, &[]);
        check_files(&workspace, "obj,pc2");
        manifest(&workspace)
    };
    let first = run(&["--frames", "5"]);
    let text = |key: &str| first[key].as_str().unwrap();
    assert_eq!((text("program"), text("version")), ("supple", env!("CARGO_PKG_VERSION")));
    assert_eq!((text("scene"), text("outcome")), ("scene.toml", "finished"));
    assert_eq!((&first["first"], &first["last"]), (&1001.into(), &1006.into()));
    assert_eq!((&first["every"], &first["fps"]), (&2.into(), &25.0.into()));
    assert_eq!(first["files"].as_array().unwrap().len(), 4);

    let resumed = run(&["--frames", "9", "--resume"]);
    assert_eq!((&resumed["last"], &resumed["fingerprint"]), (&1010.into(), &first["fingerprint"]));
    // A killed run that wrote its last checkpoint lacks only the manifest.
    std::fs::remove_file(workspace.path("out/manifest.json")).unwrap();
    assert_eq!(run(&["--frames", "9", "--resume"]), resumed);
    let changed = run(&["--frames", "3", "--set", "body.block.density=500"]);
    assert!(changed["fingerprint"] != first["fingerprint"] && changed["last"] == 1004);
}

#[test]
fn a_failed_run_has_no_manifest() {
    let workspace = Workspace::new();
    workspace.supple(&["run", "scene.toml", "--frames", "3"]).expect(0, &[]);
    // The second run cannot write its statistics after the first frame.
    std::fs::create_dir(workspace.path("out/block_0002.obj.part")).unwrap();
    workspace.supple(&["run", "scene.toml", "--frames", "3"]).expect(1, &["block_0002.obj"]);
    assert!(!workspace.path("out/manifest.json").exists());
}

#[test]
fn files_of_other_programs_and_statistics_are_not_taken_for_the_manifest() {
    let workspace = Workspace::new();
    std::fs::create_dir(workspace.path("out")).unwrap();
    for text in ["", "{}", r#"{ "name": "page", "program": "supple" }"#] {
        workspace.write("out/manifest.json", text);
        workspace.supple(&["run", "scene.toml"]).expect(2, &["manifest.json is not the manifest of a run"]);
        assert_eq!(std::fs::read_to_string(workspace.path("out/manifest.json")).unwrap(), text);
        assert!(workspace.frames("out").is_empty());
    }
    std::fs::remove_file(workspace.path("out/manifest.json")).unwrap();
    let stats = ["run", "scene.toml", "--stats", "out/manifest.json"];
    workspace.supple(&stats).expect(2, &["out/manifest.json would be the manifest", "another name"]);
    std::fs::remove_dir(workspace.path("out")).unwrap();
    workspace.supple(&stats).expect(2, &["out/manifest.json would be the manifest"]);
    let elsewhere = ["run", "scene.toml", "--frames", "1", "--stats", "manifest.json"];
    workspace.supple(&elsewhere).expect(0, &[]);
}

#[cfg(unix)]
#[test]
fn a_stopped_run_has_a_manifest_of_the_frames_so_far() {
    let workspace = Workspace::with_scene(&SCENE.replace("frames = 20", "frames = 20000"));
    workspace.write("block.obj", BLOCK);
    let mut child = workspace.command(&["run", "scene.toml", "--quiet"]).spawn().unwrap();
    while workspace.frames("out").len() < 5 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(!workspace.path("out/manifest.json").exists());
    let kill = std::process::Command::new("kill").arg(child.id().to_string()).status();
    assert!(kill.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(143));
    check_files(&workspace, "obj");
    let manifest = manifest(&workspace);
    assert_eq!(manifest["outcome"], "stopped");
    assert_eq!(manifest["last"].as_u64().unwrap() + 1, manifest["files"].as_array().unwrap().len() as u64);
}
