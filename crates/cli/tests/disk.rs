//! On a full disk `supple run` prints a message and returns exit code 1, and every file with a final name is
//! complete.

#![cfg(target_os = "linux")]

mod support;

use std::process::Command;

use support::{ProgramOutput, Workspace, program};

/// Shell script that mounts a new file system of 128 kB at `out`, runs the program until the file system is
/// full, and copies the files to `copy`. Exits with 77 if mounting is not permitted.
const TMPFS: &str = r#"
mkdir -p out && mount -t tmpfs -o size=128k none out || exit 77
"$0" run scene.toml --frames 2000 --format "$1" --quiet
code=$?
cp -a out copy
exit $code
"#;

#[test]
fn frames_on_a_full_disk_are_complete() {
    for format in ["obj", "ply", "pc2", "usd", "html"] {
        let workspace = Workspace::new();
        let output = Command::new("unshare")
            .args(["--user", "--map-root-user", "--mount", "sh", "-c", TMPFS, program(), format])
            .current_dir(workspace.path(""))
            .output();
        let output = match output {
            Ok(output) if output.status.code() != Some(77) && workspace.path("copy").is_dir() => {
                ProgramOutput::new(output)
            }
            // `unshare` is missing or fails, or mounting is not permitted. The next test covers such
            // systems, because it needs no mount.
            _ => return,
        };
        output.expect(1, &["cannot write", "out/"]);
        check_frames(&workspace, "copy", format);
    }
}

#[test]
fn a_file_size_limit_stops_the_run() {
    let workspace = Workspace::new();
    // `ulimit -f` counts blocks of 512 bytes. While SIGXFSZ is ignored, a write beyond the limit returns an
    // error, as on a full disk.
    let script = "trap '' XFSZ; ulimit -f 8; exec \"$0\" run scene.toml --frames 2000 --format pc2 --quiet";
    let output =
        Command::new("sh").args(["-c", script, program()]).current_dir(workspace.path("")).output().unwrap();
    ProgramOutput::new(output).expect(1, &["cannot write", "block.pc2"]);
    assert!(!workspace.path("out/block.pc2").exists());
}

#[test]
fn statistics_on_a_full_disk_stay_valid() {
    for name in ["s.json", "s.csv"] {
        let workspace = Workspace::new();
        // The frames are smaller than the limit of 4,096 bytes, the statistics are larger.
        let script =
            "trap '' XFSZ; ulimit -f 8; exec \"$0\" run scene.toml --frames 200 --stats \"$1\" --quiet";
        let output = Command::new("sh")
            .args(["-c", script, program(), name])
            .current_dir(workspace.path(""))
            .output()
            .unwrap();
        ProgramOutput::new(output).expect(1, &["cannot write", name]);
        let text = std::fs::read_to_string(workspace.path(name)).unwrap();
        let rows = if name == "s.json" {
            serde_json::from_str::<Vec<serde_json::Value>>(&text).unwrap().len()
        } else {
            assert!(text.ends_with('\n'));
            assert!(text.lines().all(|line| line.split(',').count() == 17));
            text.lines().count() - 1
        };
        // The row of the last frame did not fit.
        assert!(rows > 5 && rows + 1 == workspace.frames("out").len(), "{rows}");
    }
}

/// Checks that every file with a final name equals the same file of a run with enough space.
fn check_frames(workspace: &Workspace, directory: &str, format: &str) {
    workspace
        .supple(&["run", "scene.toml", "--frames", "2000", "--format", format, "--quiet", "-o", "whole"])
        .expect(0, &[]);
    let whole = workspace.frames("whole");
    let limited = workspace.frames(directory);
    let finals: Vec<_> = limited.iter().filter(|(name, _)| name.ends_with(&format!(".{format}"))).collect();
    assert!(["pc2", "usd", "html"].contains(&format) || finals.len() > 10, "{:?}", limited.keys());
    assert!(finals.iter().all(|(name, bytes)| whole[*name] == **bytes), "{format}");
}
