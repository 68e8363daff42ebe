//! A full disk: exit code 1, a message, and whatever has a final name is whole.

#![cfg(target_os = "linux")]

mod support;

use std::process::Command;

use support::{Ended, Stage, program};

/// A script that fills a file system of 64 kB of its own with frames, and copies them out.
const TMPFS: &str = r#"
mkdir -p out && mount -t tmpfs -o size=128k none out || exit 77
"$0" run scene.toml --frames 2000 --format "$1" --quiet
code=$?
cp -a out copy
exit $code
"#;

#[test]
fn frames_on_a_full_disk_are_whole() {
    for format in ["obj", "ply", "pc2"] {
        let stage = Stage::new();
        let ended = Command::new("unshare")
            .args(["--user", "--map-root-user", "--mount", "sh", "-c", TMPFS, program(), format])
            .current_dir(stage.path(""))
            .output();
        let ended = match ended {
            Ok(output) if output.status.code() != Some(77) && stage.path("copy").is_dir() => {
                Ended::of(output)
            }
            // File systems of its own are not permitted here: the other test does without.
            _ => return,
        };
        ended.expect(1, &["cannot write", "out/"]);
        check_frames(&stage, "copy", format);
    }
}

#[test]
fn a_file_that_may_not_grow_stops_the_run() {
    let stage = Stage::new();
    // Blocks of 512 bytes; without the signal, a write beyond them fails as on a full disk.
    let script = "trap '' XFSZ; ulimit -f 8; exec \"$0\" run scene.toml --frames 2000 --format pc2 --quiet";
    let output =
        Command::new("sh").args(["-c", script, program()]).current_dir(stage.path("")).output().unwrap();
    Ended::of(output).expect(1, &["cannot write", "block.pc2"]);
    assert!(!stage.path("out/block.pc2").exists());
}

/// Compares whatever has a final name with a run that had room.
fn check_frames(stage: &Stage, folder: &str, format: &str) {
    stage
        .supple(&["run", "scene.toml", "--frames", "2000", "--format", format, "--quiet", "-o", "whole"])
        .expect(0, &[]);
    let whole = stage.frames("whole");
    let kept = stage.frames(folder);
    let finals: Vec<_> = kept.iter().filter(|(name, _)| name.ends_with(&format!(".{format}"))).collect();
    assert!(format == "pc2" || finals.len() > 10, "{:?}", kept.keys());
    assert!(finals.iter().all(|(name, bytes)| whole[*name] == **bytes), "{format}");
}
