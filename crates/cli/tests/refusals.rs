//! Invalid input is rejected with exit code 2 and a message that helps to correct it, and nothing is written.
//! A second run in a directory is rejected with exit code 1 while the first one runs.

mod support;

use support::{SCENE, Workspace};

/// Runs an invalid scene with `options`. Checks that the message contains all `words` and that the output
/// directory is not created.
#[track_caller]
fn check_rejected(scene: &str, options: &[&str], words: &[&str]) {
    let workspace = Workspace::with_scene(scene);
    let mut arguments = vec!["run", "scene.toml"];
    arguments.extend(options);
    workspace.supple(&arguments).expect(2, words);
    assert!(!workspace.path("out").exists(), "the output directory was created");
}

#[test]
fn invalid_arguments_are_rejected() {
    let workspace = Workspace::new();
    workspace.supple(&["run"]).expect(2, &["INPUT"]);
    workspace.supple(&["run", "scene.toml", "--every", "0"]).expect(2, &["--every"]);
    workspace.supple(&["run", "scene.toml", "--format", "abc"]).expect(2, &["--format", "pc2"]);
    workspace.supple(&["run", "scene.toml", "--format", "obj,abc"]).expect(2, &["--format", "abc", "html"]);
    workspace
        .supple(&["run", "scene.toml", "--vat-encoding", "exr"])
        .expect(2, &["format obj", "--format vat"]);
    let jpg = ["run", "scene.toml", "--format", "vat", "--vat-encoding", "jpg"];
    workspace.supple(&jpg).expect(2, &["--vat-encoding", "png", "exr"]);
    workspace.supple(&["run", "scene.toml", "--frames", "-3"]).expect(2, &[]);
    workspace.supple(&["run", "scene.toml", "--no-such-thing"]).expect(2, &["--no-such-thing"]);
    workspace.supple(&["run", "none.toml"]).expect(2, &["none.toml"]);
    workspace.supple(&["run", "none.obj"]).expect(2, &["none.obj"]);
    workspace.supple(&["run", "block.xyz"]).expect(2, &["block.xyz", ".toml", ".obj"]);
    workspace.supple(&["run", "scene.toml", "--stats", "s.txt"]).expect(2, &["s.txt", ".csv", ".json"]);
    workspace.supple(&["run", "scene.toml", "-o", "block.obj"]).expect(2, &["block.obj", "is a file"]);
    assert!(!workspace.path("out").exists());
}

#[test]
fn invalid_scenes_are_rejected() {
    for (from, to, words) in [
        ("half_width", "half_widht", ["scene.toml:15", "body.block.half_widht", "`half_width`"].as_slice()),
        ("fps = 30", "fps = 0", &["scene.toml:4", "simulation.fps", "> 0"]),
        ("region_damping = 0.1", "region_damping = 2", &["body.block.region_damping", "is 2", "[0, 1]"]),
        (
            "region_damping = 0.1",
            "region_damping = \"soft\"",
            &["body.block.region_damping", "a number", "soft"],
        ),
        ("half_width = 1", "half_width = 1\nstiffness_radius = 0.3", &["half_width", "stiffness_radius"]),
        ("mesh = \"block.obj\"", "", &["body.block.mesh", "missing"]),
        ("mesh = \"block.obj\"", "mesh = \"none.obj\"", &["none.obj"]),
        ("mesh = \"block.obj\"", "mesh = \"block.obj\"\nobject = \"Blok\"", &["Blok", "Block"]),
        (
            "min = [-2, 0, -1], max = [-0.9",
            "min = [-9, 0, -1], max = [-8",
            &["body.block.pin.0", "nearest", "7.0"],
        ),
        ("fps = 30", "fps = ", &["scene.toml:4", "TOML"]),
    ] {
        assert!(SCENE.contains(from), "{from}");
        check_rejected(&SCENE.replacen(from, to, 1), &[], words);
    }
}

#[test]
fn invalid_overrides_are_rejected() {
    check_rejected(
        SCENE,
        &["--set", "body.block.half_widht=3"],
        &["--set body.block.half_widht=3", "`half_width`"],
    );
    check_rejected(SCENE, &["--set", "body.blok.half_width=3"], &["blok", "`block`"]);
    check_rejected(SCENE, &["--set", "body.block.stiffness=3"], &["body.block.stiffness", "(0, 1]"]);
    check_rejected(SCENE, &["--set", "simulation.frames"], &["KEY=VALUE"]);
}

#[test]
fn invalid_meshes_are_rejected() {
    for (mesh, words) in [
        ("", ["block.obj"].as_slice()),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", &["block.obj", "face"]),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", &["block.obj:4", "4"]),
        ("v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", &["block.obj:2", "nan"]),
        ("v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", &["block.obj", "extent"]),
        ("\u{0}\u{1}\u{2}ELF", &["block.obj", "OBJ"]),
    ] {
        let workspace = Workspace::new();
        workspace.write("block.obj", mesh);
        workspace.supple(&["run", "scene.toml"]).expect(2, words);
        workspace.supple(&["run", "block.obj"]).expect(2, words);
        workspace.supple(&["inspect", "scene.toml"]).expect(2, words);
        assert!(!workspace.path("out").exists() && !workspace.path("frames").exists());
    }
}

#[test]
fn a_lattice_larger_than_the_memory_is_rejected_with_a_suggested_cell_size() {
    check_rejected(SCENE, &["--set", "body.block.cell_size=1e-5"], &["memory", "cell size"]);
}

#[test]
fn output_that_would_overwrite_an_input_is_rejected() {
    let workspace = Workspace::with_scene(&SCENE.replace("block.obj", "block_0003.obj"));
    workspace.write("block_0003.obj", support::BLOCK);
    workspace
        .supple(&["run", "scene.toml", "-o", "."])
        .expect(2, &["block_0003.obj is an input", "choose another output directory"]);
    assert_eq!(std::fs::read_to_string(workspace.path("block_0003.obj")).unwrap(), support::BLOCK);
}

#[test]
fn point_caches_of_bodies_that_can_break_are_rejected() {
    const PC2: &str = "pc2 has the same faces in all frames";
    const FRACTURE: &str = "body.block.fracture.strain=0.1";
    let with_table = SCENE.replacen("region_damping", "fracture.strain = 0.1\nregion_damping", 1);
    check_rejected(
        &with_table,
        &["--format", "pc2"],
        &["`block` can break", PC2, "obj, ply, usd, usdz, html, vtu, lattice, film or gif"],
    );
    check_rejected(SCENE, &["--format", "pc2", "--set", FRACTURE], &[PC2]);
    check_rejected(SCENE, &["--set", "output.format=[\"obj\", \"pc2\"]", "--set", FRACTURE], &[PC2]);

    // The frames of an earlier run stay as they are.
    let workspace = Workspace::new();
    workspace.supple(&["run", "scene.toml", "--frames", "3", "--format", "obj,pc2"]).expect(0, &[]);
    let before = support::files(&workspace.path("out"));
    assert!(before.contains_key("block.pc2") && before.contains_key("block_0003.obj"));
    for formats in ["pc2", "obj,pc2"] {
        let run = ["run", "scene.toml", "--frames", "5", "--format", formats, "--set", FRACTURE];
        workspace.supple(&run).expect(2, &[PC2]);
        assert!(support::files(&workspace.path("out")) == before);
        workspace.supple(&[&run[..], &["--resume"]].concat()).expect(2, &[]);
        assert!(support::files(&workspace.path("out")) == before);
    }
}

#[test]
fn statistics_and_checkpoints_never_replace_an_input() {
    let workspace = Workspace::with_scene(&SCENE.replace("block.obj", "mesh.csv"));
    workspace.write("mesh.csv", support::BLOCK);
    workspace
        .supple(&["run", "scene.toml", "--stats", "mesh.csv"])
        .expect(2, &["the statistics file mesh.csv is the input", "choose another name"]);
    assert_eq!(std::fs::read_to_string(workspace.path("mesh.csv")).unwrap(), support::BLOCK);
    for name in ["supple.checkpoint", "supple.checkpoint.part", "supple.lock", "manifest.json"] {
        let workspace = Workspace::with_scene(&SCENE.replace("block.obj", &format!("out/{name}")));
        std::fs::create_dir(workspace.path("out")).unwrap();
        workspace.write(&format!("out/{name}"), support::BLOCK);
        workspace.supple(&["run", "scene.toml"]).expect(2, &[name, "is an input"]);
        let text = std::fs::read_to_string(workspace.path(&format!("out/{name}"))).unwrap();
        assert_eq!(text, support::BLOCK);
    }
}

#[cfg(unix)]
#[test]
fn links_are_not_followed_to_the_files_that_they_lead_to() {
    use std::os::unix::fs::symlink;
    let workspace = Workspace::new();
    std::fs::create_dir(workspace.path("out")).unwrap();
    workspace.write("mine", "mine");
    let is_unchanged = || std::fs::read_to_string(workspace.path("mine")).unwrap() == "mine";
    let link = |name: &str| {
        let _ = std::fs::remove_file(workspace.path(name));
        symlink(workspace.path("mine"), workspace.path(name)).unwrap();
    };
    for name in ["supple.checkpoint", "supple.checkpoint.part", "block_0001.obj", "block_0002.obj.part"] {
        link(&format!("out/{name}"));
    }
    workspace.supple(&["run", "scene.toml", "--frames", "3"]).expect(0, &[]);
    assert!(is_unchanged());
    for name in ["block.pc2", "block.pc2.part"] {
        link(&format!("out/{name}"));
    }
    workspace.supple(&["run", "scene.toml", "--frames", "3", "--format", "pc2"]).expect(0, &[]);
    assert!(is_unchanged());
    // A finished cache that is a link can be kept, but not continued.
    std::fs::rename(workspace.path("out/block.pc2"), workspace.path("moved.pc2")).unwrap();
    symlink(workspace.path("moved.pc2"), workspace.path("out/block.pc2")).unwrap();
    let resume = |frames: &str| {
        workspace.supple(&["run", "scene.toml", "--frames", frames, "--format", "pc2", "--resume"])
    };
    assert!(resume("3").out.contains("nothing written"));
    resume("5").expect(2, &["block.pc2 is a symbolic link"]);
    for options in [["run", "scene.toml"].as_slice(), &["run", "scene.toml", "--resume"]] {
        link("out/supple.lock");
        workspace.supple(options).expect(2, &["supple.lock is a symbolic link", "remove it"]);
        std::fs::remove_file(workspace.path("out/supple.lock")).unwrap();
        symlink(workspace.path("none"), workspace.path("out/supple.lock")).unwrap();
        workspace.supple(options).expect(2, &["supple.lock is a symbolic link"]);
        std::fs::remove_file(workspace.path("out/supple.lock")).unwrap();
    }
    assert!(is_unchanged() && !workspace.path("none").exists());
    // Statistics through a link to the scene would replace the scene.
    symlink(workspace.path("scene.toml"), workspace.path("s.csv")).unwrap();
    workspace.supple(&["run", "scene.toml", "--stats", "s.csv"]).expect(2, &["s.csv is the input"]);
    assert_eq!(std::fs::read_to_string(workspace.path("scene.toml")).unwrap(), SCENE);
}

#[test]
fn names_longer_than_200_bytes_are_rejected() {
    let named = |length: usize| SCENE.replace("\"block\"", &format!("\"{}\"", "n".repeat(length)));
    check_rejected(&named(201), &[], &["body.0.name", "at most 200 bytes"]);
    let workspace = Workspace::with_scene(&named(200));
    workspace.supple(&["run", "scene.toml", "--frames", "1"]).expect(0, &[]);
    assert_eq!(workspace.frames("out").len(), 2);
}

/// A pipe has no end, so a run that read it would wait forever.
#[cfg(unix)]
#[test]
fn pipes_are_rejected_and_never_read() {
    let make_pipe = |path: std::path::PathBuf| {
        assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
    };
    let workspace = Workspace::with_scene(&SCENE.replace("block.obj", "pipe.obj"));
    make_pipe(workspace.path("pipe.obj"));
    workspace.supple(&["run", "scene.toml"]).expect(2, &["pipe.obj", "it is a pipe", "regular file"]);
    let workspace = Workspace::new();
    std::fs::create_dir(workspace.path("out")).unwrap();
    make_pipe(workspace.path("out/supple.checkpoint"));
    workspace.supple(&["run", "scene.toml", "--resume"]).expect(1, &["supple.checkpoint", "it is a pipe"]);
}

#[test]
fn a_second_run_in_one_directory_is_rejected() {
    let workspace = Workspace::new();
    std::fs::create_dir(workspace.path("out")).unwrap();
    let lock = std::fs::File::create(workspace.path("out/supple.lock")).unwrap();
    lock.lock().unwrap();
    for options in [["run", "scene.toml"].as_slice(), &["run", "scene.toml", "--resume"]] {
        workspace.supple(options).expect(1, &["supple.lock", "another run"]);
    }
    assert!(workspace.frames("out").is_empty());
    // A killed run leaves the lock file behind, but the operating system has released the lock.
    drop(lock);
    workspace.supple(&["run", "scene.toml", "--frames", "1"]).expect(0, &[]);
    assert!(!workspace.path("out/supple.lock").exists());
}

#[test]
fn an_unavailable_simd_level_is_rejected() {
    let workspace = Workspace::new();
    let mut command = workspace.command(&["run", "scene.toml"]);
    let output = support::ProgramOutput::new(command.env("SUPPLE_SIMD", "avx9").output().unwrap());
    output.expect(2, &["SUPPLE_SIMD is \"avx9\"", "it has"]);
    assert!(!workspace.path("out").exists());
    // An empty value counts as unset.
    let mut command = workspace.command(&["run", "scene.toml", "--frames", "1"]);
    support::ProgramOutput::new(command.env("SUPPLE_SIMD", "").output().unwrap()).expect(0, &[]);
}
