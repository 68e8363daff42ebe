//! A full disk gives exit code 1 and a message; every file with a final name is complete.

#![cfg(target_os = "linux")]

mod support;

use std::process::Command;

use support::{Ended, Stage, program};

/// A script that fills a new file system of 128 kB with frames and copies them to `copy`.
const TMPFS: &str = r#"
mkdir -p out && mount -t tmpfs -o size=128k none out || exit 77
"$0" run scene.toml --frames 2000 --format "$1" --quiet
code=$?
cp -a out copy
exit $code
"#;

#[test]
fn frames_on_a_full_disk_are_complete() {
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
            // Mounting is not permitted here; the other test needs no mount.
            _ => return,
        };
        ended.expect(1, &["cannot write", "out/"]);
        check_frames(&stage, "copy", format);
    }
}

#[test]
fn a_file_size_limit_stops_the_run() {
    let stage = Stage::new();
    // The unit is 512 bytes. With SIGXFSZ ignored, a write beyond the limit fails as on a full disk.
    let script = "trap '' XFSZ; ulimit -f 8; exec \"$0\" run scene.toml --frames 2000 --format pc2 --quiet";
    let output =
        Command::new("sh").args(["-c", script, program()]).current_dir(stage.path("")).output().unwrap();
    Ended::of(output).expect(1, &["cannot write", "block.pc2"]);
    assert!(!stage.path("out/block.pc2").exists());
}

/// Compares every file with a final name to the file of a run with enough space.
fn check_frames(stage: &Stage, folder: &str, format: &str) {
    stage
        .supple(&["run", "scene.toml", "--frames", "2000", "--format", format, "--quiet", "-o", "whole"])
        .expect(0, &[]);
    let whole = stage.frames("whole");
    let limited = stage.frames(folder);
    let finals: Vec<_> = limited.iter().filter(|(name, _)| name.ends_with(&format!(".{format}"))).collect();
    assert!(format == "pc2" || finals.len() > 10, "{:?}", limited.keys());
    assert!(finals.iter().all(|(name, bytes)| whole[*name] == **bytes), "{format}");
}
