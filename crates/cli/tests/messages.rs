//! Messages of the command line name the cause, the value and the way out.

mod support;

use support::{SCENE, Workspace, is_not_of_large_faces};

#[test]
fn a_file_in_place_of_a_command_gets_the_command() {
    let workspace = Workspace::new();
    for (file, command) in [
        ("block.obj", "supple run block.obj"),
        ("block.stl", "supple run block.stl"),
        ("scene.toml", "supple run scene.toml"),
        ("a b.OBJ", "supple run 'a b.OBJ'"),
    ] {
        workspace.supple(&[file]).expect(2, &[file, "is a file, not a command", command]);
    }
    workspace.supple(&["block.fbx"]).expect(2, &["block.fbx", ".fbx are not read", "(.toml)", "(.obj)"]);
    workspace.supple(&["rnu"]).expect(2, &["rnu", "--help"]);
    workspace.supple(&["--version"]).expect(0, &[]);
}

#[test]
fn broken_models_and_other_formats_are_refused_with_the_problem() {
    let workspace = Workspace::new();
    for (name, bytes, words) in [
        (
            "m.ply",
            b"ply\nformat ascii 1.0\nelement vertex 3\n".as_slice(),
            "the PLY header has no line `end_header`",
        ),
        ("m.stl", b"solid x\nfacet normal 0 0 1\n", "solid `x`, triangle 1: EOF while expecting"),
        ("binary.stl", &[b'x'; 80], "a binary STL file, which has at least 84 bytes, not 80"),
        ("m.glb", b"glTF\x02\0\0\0\0\0\0\0", "the header of the GLB file tells 0 bytes, and it has 12"),
        ("m.obj", b"Kaydara FBX Binary  \0\x1a\0", "is not an OBJ file"),
        ("m.fbx", b"Kaydara FBX Binary  \0\x1a\0", "files with the extension .fbx are not read; give a"),
    ] {
        workspace.write(name, bytes);
        for command in ["run", "inspect"] {
            workspace.supple(&[command, name]).expect(2, &[name, words]);
        }
        let mesh = format!("body.block.mesh=\"{name}\"");
        workspace.supple(&["run", "scene.toml", "--set", &mesh]).expect(2, &[name, words]);
    }
}

#[test]
fn numbers_out_of_range_are_refused_with_the_range() {
    let workspace = Workspace::new();
    for (option, value, range) in [
        ("--start-frame", "-5", "a whole number from 0 to 4294967295"),
        ("--start-frame", "4294967296", "a whole number from 0 to 4294967295"),
        ("--frames", "-3", "a whole number from 0 to 10000000"),
        ("--frames", "1.5", "a whole number from 0 to 10000000"),
        ("--every", "0", "a whole number from 1 to 4294967295"),
        ("--every", "-1", "a whole number from 1 to 4294967295"),
        ("--threads", "-1", "a whole number from 0 to 1024"),
        ("--checkpoint", "-1", "from 0 to 1e19 seconds"),
    ] {
        let output = workspace.supple(&["run", "scene.toml", option, value]);
        output.expect(2, &[option, &format!("'{value}'"), range]);
        assert!(!output.err.contains("-- "), "{output:?}");
    }
}

#[test]
fn both_corners_of_an_empty_box_are_shown() {
    let workspace = Workspace::with_scene(&SCENE.replace("max = [-0.9, 5, 1]", "max = [-0.9, 5, -4]"));
    workspace
        .supple(&["run", "scene.toml"])
        .expect(2, &["body.block.pin.0.box.max", "[-0.9, 5, -4]", "`min`, which is [-2, 0, -1]"]);
}

#[cfg(target_os = "linux")]
#[test]
fn an_output_directory_that_cannot_be_written_is_named() {
    let workspace = Workspace::new();
    // Nobody can create files in these directories, not even root.
    for directory in ["/sys", "/proc"] {
        let output = workspace.supple(&["run", "scene.toml", "-o", directory]);
        output.expect(
            1,
            &[&format!("cannot write to the output directory {directory}: "), "choose another directory"],
        );
        assert!(!output.err.contains("lock"), "{output:?}");
    }
    workspace
        .supple(&["run", "scene.toml", "-o", "/proc/x/y"])
        .expect(1, &["the output directory /proc/x/y"]);
}

#[test]
fn up_is_refused_for_scenes() {
    let workspace = Workspace::new();
    let words = ["--up is for models only", "scene.toml is a scene", "simulation.gravity"];
    workspace.supple(&["run", "scene.toml", "--up", "z"]).expect(2, &words);
    workspace.supple(&["run", "block.obj", "scene.toml", "--up", "y"]).expect(2, &words);
    workspace.supple(&["inspect", "scene.toml", "--up", "z"]).expect(2, &words);
    workspace.supple(&["study", "scene.toml", "--up", "z"]).expect(2, &words);
    assert!(!workspace.path("out").exists());
    workspace.supple(&["inspect", "block.obj", "--up", "z"]).expect(0, &[]);
}

#[test]
fn printed_scenes_have_paths_that_resolve() {
    let workspace = Workspace::new();
    std::fs::create_dir_all(workspace.path("deep/er")).unwrap();
    // To standard output: absolute paths.
    for (input, printed) in [("scene.toml", "deep/a.toml"), ("block.obj", "deep/b.toml")] {
        let output = workspace.supple(&["run", input, "--print-scene"]);
        output.expect(0, &[]);
        workspace.write(printed, &output.out);
        workspace.supple(&["run", printed, "--frames", "1", "-o", "again"]).expect(0, &[]);
    }
    let text = std::fs::read_to_string(workspace.path("deep/a.toml")).unwrap();
    let directory = workspace.path("").canonicalize().unwrap();
    for line in [
        format!("mesh = {:?}", directory.join("block.obj")),
        format!("directory = {:?}", directory.join("out")),
    ] {
        assert!(text.contains(&line), "{line}: {text}");
    }
    // To a file: paths relative to the file.
    let print = |input: &str, file: &str| workspace.supple(&["run", input, "--print-scene", "-o", file]);
    for (input, file, mesh, out) in [
        ("scene.toml", "deep/er/c.toml", "../../block.obj", "../../out"),
        ("deep/er/c.toml", "d.toml", "block.obj", "out"),
        ("block.obj", "deep/e.toml", "../block.obj", "../frames"),
    ] {
        print(input, file).expect(0, &[]);
        let text = std::fs::read_to_string(workspace.path(file)).unwrap();
        assert!(text.contains(&format!("mesh = \"{mesh}\"\n")), "{text}");
        assert!(text.contains(&format!("directory = \"{out}\"\n")), "{text}");
        workspace.supple(&["run", file, "--frames", "1"]).expect(0, &[]);
    }
    assert!(workspace.frames("out").len() == 2 && workspace.frames("frames").len() == 2);
    print("scene.toml", "d.toml").expect(2, &["d.toml", "exists", "choose another name"]);
    print("scene.toml", "frames").expect(2, &["-o frames", "must end in .toml"]);
    print("scene.toml", "none/f.toml").expect(1, &["cannot write none/f.toml"]);
    let several = workspace.supple(&["run", "scene.toml", "block.obj", "--print-scene", "-o", "f.toml"]);
    several.expect(2, &["one scene, not 2", "give one input"]);
}

#[test]
fn progress_has_the_numbers_of_the_files() {
    let workspace = Workspace::new();
    let run = |frames: &str, options: &[&str]| {
        let mut arguments = vec!["run", "scene.toml", "--start-frame", "1001", "--frames", frames];
        arguments.extend(options);
        let output = workspace.supple(&arguments);
        output.expect(0, &[]);
        output
    };
    let output = run("9", &[]);
    let frames = output
        .err
        .lines()
        .filter(|line| is_not_of_large_faces(line))
        .filter_map(|line| line.split(", ").nth(1));
    let expected: Vec<String> = (1001..=1010).map(|frame| format!("frame {frame} of 1010")).collect();
    assert_eq!(frames.collect::<Vec<_>>(), expected);
    assert!(output.out.contains("finished at frame 1010, 10 frames written"), "{output:?}");
    let output = run("12", &["--resume"]);
    assert!(output.err.contains("resuming after frame 1010") && output.err.contains("frame 1013 of 1013"));
    assert!(run("12", &["--resume"]).out.contains("already finished at frame 1013"));
    std::fs::remove_file(workspace.path("out/block_1004.obj")).unwrap();
    assert!(run("12", &["--resume"]).err.contains("starting again from frame 1001"));
}

#[test]
fn one_frame_is_singular() {
    let workspace = Workspace::new();
    let output = workspace.supple(&["run", "scene.toml", "--frames", "0"]);
    assert!(output.out.contains(" 1 frame written to "), "{output:?}");
    let scene = SCENE.replace("frames = 20", "frames = 1").replace("substeps = 2", "substeps = 1");
    workspace.write("one.toml", scene);
    let output = workspace.supple(&["inspect", "one.toml"]);
    assert!(output.out.contains("1 frame at 30 frames/s"), "{output:?}");
}
