//! `supple run` writes the expected files under the expected names, and prints progress and a summary.

mod support;

use support::{SCENE, Workspace};

#[test]
fn frames_are_numbered_from_the_rest_pose() {
    let workspace = Workspace::new();
    let output = workspace.supple(&["run", "scene.toml"]);
    output.expect(0, &[]);
    let frames = workspace.frames("out");
    let names: Vec<String> = (0..=20).map(|frame| format!("block_{frame:04}.obj")).collect();
    assert!(frames.keys().eq(&names), "{:?}", frames.keys());
    // Frame 0 is the rest pose after `translate`: y is higher by 1 than in the file.
    let rest = String::from_utf8(frames["block_0000.obj"].clone()).unwrap();
    let vertices = |text: &str| -> Vec<Vec<f64>> {
        text.lines()
            .filter_map(|line| line.strip_prefix("v "))
            .map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect())
            .collect()
    };
    let mut expected = vertices(support::BLOCK);
    expected.iter_mut().for_each(|vertex| vertex[1] += 1.0);
    for (found, expected) in vertices(&rest).iter().zip(&expected) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?} {expected:?}");
    }
    // All other lines are equal to the lines of the input.
    let others = |text: &str| -> Vec<String> {
        text.lines().filter(|line| !line.starts_with("v ")).map(str::to_owned).collect()
    };
    assert_eq!(others(&rest), others(support::BLOCK));
}

#[test]
fn options_select_frames_numbers_and_formats() {
    let workspace = Workspace::new();
    let run = |options: &[&str], directory: &str| {
        let mut arguments = vec!["run", "scene.toml", "-o", directory];
        arguments.extend(options);
        workspace.supple(&arguments).expect(0, &[]);
        workspace.frames(directory)
    };
    let all = run(&["--frames", "7"], "all");
    assert_eq!(all.len(), 8);
    let third = run(&["--frames", "7", "--every", "3"], "third");
    assert!(third.keys().eq(&["block_0000.obj", "block_0003.obj", "block_0006.obj"]));
    assert!(third.iter().all(|(name, bytes)| all[name] == *bytes));
    let shot = run(&["--frames", "7", "--start-frame", "1001"], "shot");
    assert!(
        shot.keys().eq((1001..=1008).map(|frame| format!("block_{frame}.obj")).collect::<Vec<_>>().iter())
    );
    assert!(shot.values().eq(all.values()));
    let wide = run(&["--frames", "1", "--start-frame", "9999"], "wide");
    assert!(wide.keys().eq(&["block_09999.obj", "block_10000.obj"]));
    assert!(run(&["--frames", "2", "--format", "ply"], "ply").keys().all(|name| name.ends_with(".ply")));
    assert!(run(&["--frames", "2", "--format", "pc2"], "pc2").keys().eq(&["block.pc2"]));
    assert!(run(&["--set", "simulation.frames=1", "--set", "output.format=ply"], "set").len() == 2);
    assert!(run(&["--frames", "2", "--format", "html"], "html").keys().eq(&["supple.html"]));
    let several = run(&["--frames", "1", "--format", "obj,html,pc2"], "several");
    assert!(several.keys().eq(&["block.pc2", "block_0000.obj", "block_0001.obj", "supple.html"]));
    let list = "output.format=[\"obj\", \"html\", \"pc2\"]";
    assert!(run(&["--set", "simulation.frames=1", "--set", list], "list") == several);
}

#[test]
fn a_run_replaces_only_the_existing_sequence() {
    let workspace = Workspace::new();
    workspace.supple(&["run", "scene.toml", "--frames", "9"]).expect(0, &[]);
    for name in ["out/block_notes.txt", "out/other_0000.obj", "out/block_0000.ply"] {
        workspace.write(name, "mine");
    }
    workspace.supple(&["run", "scene.toml", "--frames", "3"]).expect(0, &[]);
    let frames = workspace.frames("out");
    assert_eq!(frames.keys().filter(|name| name.starts_with("block_") && name.ends_with(".obj")).count(), 4);
    assert_eq!(frames.values().filter(|bytes| bytes.as_slice() == b"mine").count(), 3);
}

#[test]
fn frames_do_not_depend_on_threads_or_frame_interval() {
    let workspace = Workspace::new();
    for (directory, options) in
        [("one", ["--threads", "1", "--every", "1"]), ("two", ["--threads", "2", "--every", "5"])]
    {
        let mut arguments = vec!["run", "scene.toml", "-o", directory];
        arguments.extend(options);
        workspace.supple(&arguments).expect(0, &[]);
    }
    let (one, two) = (workspace.frames("one"), workspace.frames("two"));
    assert_eq!(two.len(), 5);
    assert!(two.iter().all(|(name, bytes)| one[name] == *bytes));
}

#[test]
fn statistics_have_one_row_per_frame_and_body() {
    let workspace = Workspace::new();
    workspace.supple(&["run", "scene.toml", "--frames", "4", "--stats", "s.csv"]).expect(0, &[]);
    let text = std::fs::read_to_string(workspace.path("s.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "frame,time,body,ms_step,ms_volume,ms_embed,ms_write,volume_rest,volume_before,volume_after,\
         lambda,residual,capped,energy_kinetic,max_speed,contacts,overlap"
    );
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 5);
    for (frame, row) in rows.iter().enumerate() {
        assert_eq!((row[0].parse(), row[2], row.len()), (Ok(frame), "block", 17));
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        assert!((number(1) - frame as f64 / 30.0).abs() < 1e-12);
        assert!((number(9) / number(7) - 1.0).abs() < 1e-5, "the volume is not preserved: {row:?}");
    }

    workspace.supple(&["run", "scene.toml", "--frames", "4", "--stats", "s.json"]).expect(0, &[]);
    let text = std::fs::read_to_string(workspace.path("s.json")).unwrap();
    let rows: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(rows.len(), 5);
    assert_eq!((&rows[3]["frame"], &rows[3]["body"]), (&3.into(), &"block".into()));
}

#[test]
fn a_pipe_gets_a_line_per_tenth_and_a_summary() {
    let workspace = Workspace::new();
    let output = workspace.supple(&["run", "scene.toml"]);
    let lines: Vec<&str> = output.err.lines().filter(|line| line.contains(" %")).collect();
    assert_eq!(lines.len(), 10, "{output:?}");
    assert!(lines.iter().all(|line| line.contains("left")), "{lines:?}");
    assert!(output.out.contains("21 frames written") && output.out.lines().count() == 1, "{output:?}");
    let quiet = workspace.supple(&["run", "scene.toml", "--quiet"]);
    assert_eq!((quiet.messages().as_str(), quiet.out.lines().count()), ("", 1));
}

#[test]
fn a_model_without_a_scene_falls_on_the_ground() {
    let workspace = Workspace::new();
    workspace.supple(&["run", "block.obj", "-o", "fall"]).expect(0, &[]);
    let frames = workspace.frames("fall");
    let lowest = |name: &str| {
        let text = String::from_utf8(frames[name].clone()).unwrap();
        let heights =
            text.lines().filter_map(|line| line.strip_prefix("v ")?.split(' ').nth(1)?.parse().ok());
        heights.fold(f64::INFINITY, f64::min)
    };
    assert!(lowest("block_0000.obj").abs() < 1e-6);
    // The ground is 0.3, a tenth of the height, below the block. The block comes to rest on the ground.
    let last = lowest("block_0090.obj");
    assert!((last + 0.3).abs() < 0.02, "{last}");
    let printed = workspace.supple(&["run", "block.obj", "--print-scene", "--up", "z"]);
    printed.expect(0, &[]);
    workspace.write("printed.toml", &printed.out);
    assert!(printed.out.contains("gravity = [0.0, 0.0, -8.0]"), "{}", printed.out);
    workspace.supple(&["run", "printed.toml", "--frames", "1", "-o", "again"]).expect(0, &[]);
}

#[test]
fn a_batch_continues_after_a_failure() {
    let workspace = Workspace::new();
    workspace.write("bad.toml", SCENE.replace("half_width", "half_widht"));
    workspace.write("last.toml", SCENE);
    let output = workspace.supple(&[
        "run",
        "scene.toml",
        "bad.toml",
        "last.toml",
        "--frames",
        "2",
        "-o",
        "all",
        "--stats",
        "s.csv",
    ]);
    output.expect(1, &["bad", "half_width"]);
    assert_eq!(workspace.frames("all/scene").len(), 3);
    assert_eq!(workspace.frames("all/last").len(), 3);
    assert!(!workspace.path("all/bad").exists());
    assert!(workspace.path("s_scene.csv").is_file() && workspace.path("s_last.csv").is_file());
    let table: Vec<&str> = output.out.lines().skip_while(|line| !line.starts_with("input")).collect();
    assert_eq!(table.len(), 4, "{}", output.out);
    assert!(table[2].starts_with("bad") && table[2].contains("failed"));
    let same = workspace.supple(&["run", "scene.toml", "scene.toml"]);
    same.expect(2, &["scene.toml", "one at a time"]);
}
