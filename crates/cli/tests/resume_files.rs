//! `--resume` accepts only files of the earlier run: it rejects other settings, and detects frames and
//! statistics that are missing or have changed.

mod support;

use std::path::Path;

use support::{ProgramOutput, Workspace, files};

/// Runs the scene with `options`, separated by blanks.
fn run(workspace: &Workspace, options: &str) -> ProgramOutput {
    let mut arguments = vec!["run", "scene.toml"];
    arguments.extend(options.split_whitespace());
    workspace.supple(&arguments)
}

/// Checks that the directory `out` has the frames of an uninterrupted run with `options`.
#[track_caller]
fn check_frames(workspace: &Workspace, options: &str) {
    run(workspace, &format!("-o whole {options}")).expect(0, &[]);
    let (out, whole) = (workspace.frames("out"), workspace.frames("whole"));
    assert!(out == whole, "{:?} instead of {:?}", out.keys(), whole.keys());
}

#[test]
fn frames_of_another_motion_and_format_are_never_kept() {
    let workspace = Workspace::new();
    let other = "--set body.block.half_width=3";
    run(&workspace, "--frames 6").expect(0, &[]);
    run(&workspace, &format!("--frames 6 --format ply {other}")).expect(0, &[]);
    let before = files(&workspace.path("out"));
    run(&workspace, &format!("--frames 9 --resume {other}"))
        .expect(2, &["supple.checkpoint", "format changed from ply to obj", "without resuming"]);
    assert!(files(&workspace.path("out")) == before, "a rejected run changes no file");
    run(&workspace, &format!("--frames 9 {other}")).expect(0, &[]);
    let frames = workspace.frames("out");
    run(&workspace, &format!("--frames 9 -o whole {other}")).expect(0, &[]);
    let whole = workspace.frames("whole");
    assert_eq!(whole.len(), 10);
    assert!(whole.iter().all(|(name, bytes)| frames[name] == *bytes));
}

#[test]
fn resuming_with_other_numbers_or_without_statistics_is_rejected() {
    for format in ["obj", "pc2", "html"] {
        let workspace = Workspace::new();
        run(&workspace, &format!("--frames 4 --format {format} --stats s.csv")).expect(0, &[]);
        let before = files(&workspace.path("out"));
        for (options, words) in [
            ("--stats s.csv --start-frame 7", ["number of the first frame", "from 0 to 7"]),
            ("--stats s.csv --every 2", ["interval between written frames", "from 1 to 2"]),
            ("", ["wrote statistics to", "s.csv, and this run writes none"]),
        ] {
            for frames in [4, 8] {
                let options = format!("--resume --format {format} --frames {frames} {options}");
                run(&workspace, &options).expect(2, &words);
            }
        }
        let without = format!("-o two --format {format} --frames");
        run(&workspace, &format!("{without} 4")).expect(0, &[]);
        run(&workspace, &format!("{without} 8 --resume --stats t.csv"))
            .expect(2, &["wrote no statistics", "t.csv"]);
        assert!(files(&workspace.path("out")) == before && !workspace.path("t.csv").exists());
    }
}

#[test]
fn a_missing_or_shorter_frame_restarts_the_run() {
    for format in ["obj", "ply", "pc2", "usd", "html"] {
        let workspace = Workspace::new();
        let options = format!("--frames 8 --format {format}");
        let name = match format {
            "pc2" => "block.pc2",
            "html" | "usd" => &format!("supple.{format}"),
            _ => &format!("block_0002.{format}"),
        };
        for length in [None, Some(0), Some(100)] {
            run(&workspace, &format!("--frames 5 --format {format}")).expect(0, &[]);
            let path = workspace.path(&format!("out/{name}"));
            match length {
                Some(length) => std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_len(length),
                None => std::fs::remove_file(&path),
            }
            .unwrap();
            // A finished run is repaired as well.
            for frames in [5, 8] {
                let output = run(&workspace, &format!("--resume --frames {frames} --format {format}"));
                let words: &[&str] = if frames == 5 { &[name, "starting again"] } else { &[] };
                output.expect(0, words);
            }
            check_frames(&workspace, &options);
        }
    }
}

#[test]
fn verify_detects_changes_that_keep_the_size() {
    for format in ["obj", "ply", "pc2"] {
        let workspace = Workspace::new();
        run(&workspace, &format!("--frames 5 --format {format}")).expect(0, &[]);
        let name = if format == "pc2" { "block.pc2" } else { &format!("block_0002.{format}") };
        let path = workspace.path(&format!("out/{name}"));
        let mut bytes = std::fs::read(&path).unwrap();
        let at = if format == "pc2" { 32 + 2 * 120 + 7 } else { bytes.len() - 2 };
        bytes[at] ^= 1;
        std::fs::write(&path, &bytes).unwrap();
        let resume = format!("--resume --frames 5 --format {format}");
        assert!(run(&workspace, &resume).out.contains("nothing written"));
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
        run(&workspace, &format!("{resume} --verify"))
            .expect(0, &[name, "has changed since it was written", "starting again"]);
        check_frames(&workspace, &format!("--frames 5 --format {format}"));
        assert!(run(&workspace, &format!("{resume} --verify")).out.contains("nothing written"));
        run(&workspace, "--verify").expect(2, &["--resume"]);
    }
}

#[test]
fn lost_or_changed_statistics_are_an_error_before_any_file_changes() {
    for (format, name) in [("obj", "s.csv"), ("pc2", "s.json")] {
        let workspace = Workspace::new();
        run(&workspace, &format!("--frames 5 --start-frame 10 --format {format} --stats {name}"))
            .expect(0, &[]);
        let text = std::fs::read_to_string(workspace.path(name)).unwrap();
        let before = files(&workspace.path("out"));
        let resume = format!("--resume --frames 9 --start-frame 10 --format {format} --stats {name} --quiet");
        for (changed, problem) in [
            (None, "the file is missing"),
            (Some(text[..text.len() / 2].to_owned()), "shorter"),
            (Some(text.replacen("block", "bl0ck", 1)), "does not start with the rows"),
            (Some("my notes\n".repeat(1000)), "does not start with the rows"),
        ] {
            match &changed {
                Some(text) => workspace.write(name, text),
                None => std::fs::remove_file(workspace.path(name)).unwrap(),
            }
            run(&workspace, &resume).expect(2, &[name, problem, "frames 10 to 15", "restore the file"]);
            let found = std::fs::read_to_string(workspace.path(name)).ok();
            assert_eq!(found, changed, "a rejected run changes no file");
            assert!(files(&workspace.path("out")) == before, "a rejected run changes no file");
        }
        // The file can be moved.
        workspace.write(&format!("moved_{name}"), &text);
        run(&workspace, &resume.replace(name, &format!("moved_{name}"))).expect(0, &[]);
        let moved = std::fs::read_to_string(workspace.path(&format!("moved_{name}"))).unwrap();
        assert!(moved.starts_with(text.trim_end_matches(['\n', ']'])) && moved.len() > text.len());
    }
}

#[test]
fn frames_are_renamed_if_their_numbers_get_another_digit() {
    let workspace = Workspace::new();
    let start = "--start-frame 9990 --every 2 --format ply";
    run(&workspace, &format!("{start} --frames 6")).expect(0, &[]);
    let first = workspace.path("out/block_9990.ply");
    let written = |path: &Path| std::fs::metadata(path).unwrap().modified().unwrap();
    let time = written(&first);
    // An earlier renaming was interrupted.
    std::fs::rename(workspace.path("out/block_9992.ply"), workspace.path("out/block_09992.ply")).unwrap();
    let output = run(&workspace, &format!("{start} --frames 15 --resume"));
    output.expect(0, &[]);
    assert!(!output.err.contains("starting again"), "{output:?}");
    assert_eq!(written(&workspace.path("out/block_09990.ply")), time);
    check_frames(&workspace, &format!("{start} --frames 15"));

    // Fewer frames: a finished run keeps its files.
    let before = files(&workspace.path("out"));
    let output = run(&workspace, &format!("{start} --frames 4 --resume"));
    assert!(output.out.contains("nothing written"), "{output:?}");
    assert!(files(&workspace.path("out")) == before);
    run(&workspace, &format!("{start} --frames 21 --resume")).expect(0, &[]);
    check_frames(&workspace, &format!("{start} --frames 21"));
}
