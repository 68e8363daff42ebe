//! `--resume` continues a finished, stopped or killed run, with the same frames as an uninterrupted run. It
//! rejects damaged checkpoints, and changes of the scene that change the motion of the bodies.

mod support;

use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use support::{ProgramOutput, SCENE, Workspace};

/// Arguments of a run that takes long enough to be killed, and writes a checkpoint after every frame.
const LONG: [&str; 6] = ["run", "scene.toml", "--frames", "300", "--checkpoint", "0"];

#[test]
fn resuming_a_finished_run_writes_only_additional_frames() {
    for format in ["obj", "ply", "pc2", "usd", "html", "obj,usd,html"] {
        let workspace = Workspace::new();
        let run = |frames: &str, more: &[&str]| {
            let mut arguments = vec!["run", "scene.toml", "--format", format, "--frames", frames];
            arguments.extend(more);
            let output = workspace.supple(&arguments);
            output.expect(0, &[]);
            output
        };
        run("12", &["-o", "whole", "--stats", "whole.csv"]);
        run("5", &["--resume", "--stats", "s.csv"]);
        let before: Vec<_> = times(&workspace, "out");
        let again = run("5", &["--resume", "--stats", "s.csv"]);
        assert!(again.out.contains("nothing written"), "{}", again.out);
        run("3", &["--resume", "--stats", "s.csv"]);
        assert_eq!(times(&workspace, "out"), before);
        run("12", &["--resume", "--stats", "s.csv"]);
        assert!(workspace.frames("out") == workspace.frames("whole"), "{format}");
        let rows = std::fs::read_to_string(workspace.path("s.csv")).unwrap();
        let frames: Vec<&str> = rows.lines().skip(1).map(|row| row.split(',').next().unwrap()).collect();
        assert!(
            frames.iter().enumerate().all(|(index, frame)| frame.parse() == Ok(index)) && frames.len() == 13
        );
    }
}

/// Returns the names and modification times of the files in a directory.
fn times(workspace: &Workspace, directory: &str) -> Vec<(std::ffi::OsString, std::time::SystemTime)> {
    let entries = std::fs::read_dir(workspace.path(directory)).unwrap().map(|entry| entry.unwrap());
    let mut times: Vec<_> =
        entries.map(|entry| (entry.file_name(), entry.metadata().unwrap().modified().unwrap())).collect();
    times.sort();
    times
}

#[test]
fn resuming_is_rejected_only_if_the_scene_changes_the_motion() {
    let workspace = Workspace::new();
    workspace.supple(&["run", "scene.toml", "--frames", "4"]).expect(0, &[]);
    let resume = |more: &[&str]| {
        let mut arguments = vec!["run", "scene.toml", "--frames", "6", "--resume"];
        arguments.extend(more);
        workspace.supple(&arguments)
    };
    for (change, words) in [
        ("body.block.half_width=2", ["half_width = 1", "half_width = 2"]),
        ("simulation.substeps=3", ["substeps = 2", "substeps = 3"]),
        ("simulation.gravity=[0, -1, 0]", ["gravity", "-1.0"]),
        ("collider.0.friction=0", ["[[collider]]", "friction"]),
    ] {
        resume(&["--set", change]).expect(2, &words);
    }
    workspace.write("block.obj", support::BLOCK.replace("1 3 0.5", "1.5 3 0.5"));
    resume(&[]).expect(2, &["mesh file has changed", "without resuming"]);
    workspace.write("block.obj", support::BLOCK);
    assert_eq!(workspace.frames("out").len(), 5);
    // The number of threads and the directory of the scene do not affect the result.
    std::fs::create_dir(workspace.path("moved")).unwrap();
    workspace.write("moved/scene.toml", SCENE.replace("\"block.obj\"", "\"../block.obj\""));
    workspace
        .supple(&["run", "moved/scene.toml", "-o", "out", "--frames", "6", "--threads", "1", "--resume"])
        .expect(0, &[]);
    assert_eq!(workspace.frames("out").len(), 7);
}

#[test]
fn resuming_automatically_starts_again_where_the_checkpoint_does_not_fit() {
    let workspace = Workspace::new();
    let run = |more: &[&str]| {
        let mut arguments = vec!["run", "scene.toml", "--resume=auto", "--stats", "s.csv"];
        arguments.extend(more);
        let output = workspace.supple(&arguments);
        output.expect(0, &[]);
        output
    };
    let expect = |output: &ProgramOutput, words: &[&str]| {
        output.expect(0, &["starting again from frame 0"]);
        output.expect(0, words);
        assert!(output.out.contains("7 frames written"), "{output:?}");
    };
    assert!(!run(&["--frames", "4"]).err.contains("starting again"));
    let continued = run(&["--frames", "6"]);
    continued.expect(0, &["resuming after frame 4"]);
    assert!(continued.out.contains("2 frames written"), "{continued:?}");
    assert!(run(&["--frames", "6"]).out.contains("nothing written"));

    let changed = ["--frames", "6", "--set", "body.block.half_width=2"];
    expect(&run(&changed), &["cannot resume from", "`half_width = 1` changed to `half_width = 2`"]);
    workspace
        .supple(&[
            "run",
            "scene.toml",
            "--quiet",
            "-o",
            "whole",
            changed[0],
            changed[1],
            changed[2],
            changed[3],
        ])
        .expect(0, &[]);
    assert!(workspace.frames("out") == workspace.frames("whole"));

    workspace.write("out/supple.checkpoint", "not a checkpoint, but long enough");
    expect(&run(&changed), &["it is not a checkpoint of supple"]);
    std::fs::remove_file(workspace.path("s.csv")).unwrap();
    expect(&run(&changed), &["cannot continue the statistics", "the file is missing"]);
    workspace.supple(&["run", "scene.toml", "--resume=always"]).expect(2, &["always", "it must be `auto`"]);
}

#[test]
fn a_damaged_checkpoint_is_rejected_with_a_message() {
    let workspace = Workspace::new();
    workspace.supple(&["run", "scene.toml", "--frames", "4"]).expect(0, &[]);
    let path = workspace.path("out/supple.checkpoint");
    let whole = std::fs::read(&path).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    for bytes in
        [&[][..], &whole[..7], &whole[..whole.len() - 1], &flipped, b"not a checkpoint, but long enough"]
    {
        std::fs::write(&path, bytes).unwrap();
        let output = workspace.supple(&["run", "scene.toml", "--frames", "6", "--resume"]);
        output.expect(2, &["supple.checkpoint", "start again"]);
        assert!(!output.err.contains("panicked"));
    }
    workspace.supple(&["run", "scene.toml", "--frames", "6"]).expect(0, &[]);
    assert_eq!(workspace.frames("out").len(), 7);
}

#[test]
fn resuming_after_kills_at_random_times_gives_the_same_frames() {
    for (format, seed) in [("obj", 1), ("ply", 2), ("pc2", 3), ("html", 4), ("pc2,html", 5)] {
        let workspace = Workspace::new();
        let mut whole = LONG.to_vec();
        whole.extend(["--format", format, "--quiet", "-o", "whole", "--stats", "whole.json"]);
        let start_time = Instant::now();
        workspace.supple(&whole).expect(0, &[]);
        let length = start_time.elapsed();

        let mut arguments = LONG.to_vec();
        arguments.extend(["--format", format, "--quiet", "--resume", "--stats", "s.json"]);
        let mut random = Random(seed);
        for _ in 0..6 {
            let mut child = start(&workspace, &arguments);
            std::thread::sleep(length.mul_f64(random.next() / 3.0));
            child.kill().unwrap();
            child.wait().unwrap();
            // Every file with a final name is complete.
            let expected = workspace.frames("whole");
            for (name, bytes) in workspace.frames("out") {
                let is_final = format.split(',').any(|format| name.ends_with(&format!(".{format}")));
                assert!(!is_final || expected[&name] == bytes, "{name} is not complete");
            }
        }
        workspace.supple(&arguments).expect(0, &[]);
        assert!(
            workspace.frames("out") == workspace.frames("whole"),
            "{format}: {:?}",
            workspace.frames("out").keys()
        );
        let rows = |name: &str| {
            let text = std::fs::read_to_string(workspace.path(name)).unwrap();
            let mut rows: Vec<serde_json::Map<String, serde_json::Value>> =
                serde_json::from_str(&text).unwrap();
            rows.iter_mut().for_each(|row| row.retain(|key, _| !key.starts_with("ms_")));
            rows
        };
        assert_eq!(rows("s.json"), rows("whole.json"), "{format}");
    }
}

fn start(workspace: &Workspace, arguments: &[&str]) -> Child {
    workspace.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Random numbers in [0, 1) from a seed and the clock, so that each test run kills the program at other
/// times.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        let clock = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
        self.0 = (self.0 ^ u64::from(clock.subsec_nanos())).wrapping_mul(0x5851_f42d_4c95_7f2d) | 1;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_and_sigterm_keep_frames_and_write_a_checkpoint() {
    for (format, signal, code) in [("obj", "-INT", 130), ("pc2", "-TERM", 143), ("html,obj", "-TERM", 143)] {
        let workspace = Workspace::new();
        // The default checkpoint interval is longer than this run, so only the signal writes a checkpoint.
        let arguments = ["run", "scene.toml", "--frames", "20000", "--format", format, "--stats", "s.json"];
        let child = start(&workspace, &arguments);
        wait_until(|| std::fs::metadata(workspace.path("s.json")).is_ok_and(|file| file.len() > 5000));
        let killed = std::process::Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(killed.unwrap().success());
        let output = ProgramOutput::new(child.wait_with_output().unwrap());
        output.expect(code, &[]);
        assert!(output.out.contains("--resume"), "{output:?}");
        let text = std::fs::read_to_string(workspace.path("s.json")).unwrap();
        let rows: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
        let done = rows.len();
        let frames = workspace.frames("out");
        assert!(
            !frames.keys().any(|name| ["part", "tmp", "data"].iter().any(|word| name.contains(word))),
            "{:?}",
            frames.keys()
        );
        if format == "obj" {
            assert_eq!(frames.len(), done);
        }
        let more = (done + 5).to_string();
        let run = |more_arguments: &[&str]| {
            let mut arguments = vec!["run", "scene.toml", "--frames", &more, "--format", format];
            arguments.extend(more_arguments);
            workspace.supple(&arguments).expect(0, &[]);
        };
        run(&["--resume", "--stats", "s.json"]);
        run(&["-o", "whole"]);
        // The frame count of a run determines the number of digits, so the resumed run renames frames.
        assert!(workspace.frames("out") == workspace.frames("whole"));
    }
}

/// The frame of this run takes so long that all signals arrive in it.
#[cfg(unix)]
#[test]
fn a_second_interrupt_exits_with_the_code_of_the_first_signal() {
    for (first, code) in [("-TERM", 143), ("-INT", 130)] {
        let workspace = Workspace::new();
        let long = ["simulation.substeps=100000", "body.block.lattice_vertices=4000"];
        let arguments = ["run", "scene.toml", "--format", "ply", "--set", long[0], "--set", long[1]];
        let mut child = start(&workspace, &arguments);
        wait_until(|| workspace.path("out/block_0000.ply").is_file());
        // A further SIGTERM changes nothing.
        for signal in [first, "-TERM", "-INT"] {
            assert!(child.try_wait().unwrap().is_none(), "{first}, before {signal}");
            let killed = std::process::Command::new("kill").args([signal, &child.id().to_string()]).status();
            assert!(killed.unwrap().success());
            std::thread::sleep(Duration::from_millis(300));
        }
        let output = ProgramOutput::new(child.wait_with_output().unwrap());
        output.expect(code, &["stopping after the current frame"]);
        assert!(!workspace.path("out/supple.checkpoint").exists() && workspace.frames("out").len() == 1);
    }
}

#[cfg(unix)]
fn wait_until(condition: impl Fn() -> bool) {
    let start_time = Instant::now();
    while !condition() {
        assert!(start_time.elapsed() < Duration::from_secs(60), "timed out");
        std::thread::sleep(Duration::from_millis(5));
    }
}
