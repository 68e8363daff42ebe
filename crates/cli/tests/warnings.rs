//! `supple run` ends with a warning about each body whose volume was not kept or that is softer than
//! specified.

mod support;

use support::{SCENE, Workspace};

/// A cap of almost zero allows no correction, and the impact on the ground changes the volume.
const CAP: [&str; 2] = ["--set", "body.block.volume.max_correction=1e-9"];

fn warnings(text: &str) -> Vec<&str> {
    text.lines().filter(|line| line.starts_with("warning: ")).collect()
}

#[test]
fn a_volume_that_was_not_kept_is_reported_once_with_the_worst_frame() {
    let workspace = Workspace::new();
    let run = |options: &[&str]| {
        let mut arguments = vec!["run", "scene.toml", "--quiet", "--stats", "s.csv", "--start-frame", "1001"];
        arguments.extend(CAP);
        arguments.extend(options);
        let output = workspace.supple(&arguments);
        output.expect(0, &[]);
        // (number, residual) of each frame, from the statistics.
        let text = std::fs::read_to_string(workspace.path("s.csv")).unwrap();
        let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
        let rows: Vec<(u64, f64)> =
            rows.map(|row| (row[0].parse().unwrap(), row[11].parse().unwrap())).collect();
        (output, rows)
    };
    let (output, rows) = run(&[]);
    let unkept = rows.iter().filter(|row| row.1.abs() > 1e-3).count();
    let worst = rows.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap();
    assert!(unkept > 0 && unkept < 21, "{rows:?}");
    let expected = format!(
        "warning: scene: body block: the volume was not kept in {unkept} of 21 written frames, by up to {:+.2} % \
         in frame {};",
        100.0 * worst.1,
        worst.0
    );
    assert_eq!(warnings(&output.messages()).len(), 1, "{output:?}");
    assert!(output.messages().starts_with(&expected) && output.err.contains("max_correction"), "{output:?}");
    // Without correction no volume is kept on purpose.
    let (output, _) = run(&["--set", "body.block.volume.measure=off"]);
    assert!(output.messages().is_empty(), "{output:?}");
}

#[test]
fn a_frequency_above_a_sixth_of_the_step_rate_is_reported_with_the_steps_that_it_needs() {
    let workspace = Workspace::new();
    let run = |frequency: &str, options: &[&str]| {
        let frequency = format!("body.block.frequency={frequency}");
        let mut arguments = vec!["run", "scene.toml", "--quiet", "--frames", "1", "--set", &frequency];
        arguments.extend(options);
        let output = workspace.supple(&arguments);
        output.expect(0, &[]);
        output.messages()
    };
    let message = "warning: scene: body block: it is softer than specified: `frequency` is 25 Hz, and 2 steps per \
                   frame allow at most 10 Hz; set simulation.substeps to 5 or \"auto\", or lower `frequency`\n";
    assert_eq!(run("25.0", &[]), message);
    for substeps in ["5", "auto"] {
        assert_eq!(run("25.0", &["--set", &format!("simulation.substeps={substeps}")]), "");
    }
    assert_eq!(run("10", &[]), "");
    let inspected = workspace.supple(&["inspect", "scene.toml", "--set", "body.block.frequency=25"]);
    assert!(inspected.out.contains("warning: body block: it is softer than specified"), "{inspected:?}");
    // In a batch each input has its own lines.
    workspace.write("other.toml", SCENE.replace("half_width", "frequency = 25\nhalf_width"));
    let output = workspace.supple(&["run", "scene.toml", "other.toml", "--frames", "1", "-q", "-o", "all"]);
    assert_eq!(warnings(&output.messages()).len(), 1, "{output:?}");
    assert!(output.err.contains("warning: other: body block: it is softer"), "{output:?}");
}

#[test]
fn a_youngs_modulus_that_needs_shorter_steps_is_reported_with_the_steps_that_it_needs() {
    let workspace = Workspace::with_scene(&SCENE.replace("half_width = 1\n", ""));
    let run = |options: &[&str]| {
        let mut arguments = vec!["run", "scene.toml", "--quiet", "--frames", "1"];
        arguments.extend(options);
        let output = workspace.supple(&arguments);
        output.expect(0, &[]);
        output.messages()
    };
    let modulus = ["--set", "body.block.youngs_modulus=1e8"];
    let message = run(&modulus);
    let start = "warning: scene: body block: it is softer than specified: `youngs_modulus` is 1e8, and 2 steps per frame \
                 allow at most ";
    assert!(message.starts_with(start), "{message}");
    let (_, rest) = message.split_once("set simulation.substeps to ").expect(&message);
    let (needed, rest) = rest.split_once(' ').unwrap();
    assert_eq!(rest, "or \"auto\", or lower `youngs_modulus`\n");
    // So many steps are enough, and one less is not.
    let needed: u32 = needed.parse().unwrap();
    for (substeps, warned) in [(needed, false), (needed - 1, true)] {
        let substeps = format!("simulation.substeps={substeps}");
        assert_eq!(
            !run(&[modulus.as_slice(), &["--set", &substeps]].concat()).is_empty(),
            warned,
            "{substeps}"
        );
    }
    assert_eq!(run(&[modulus.as_slice(), &["--set", "simulation.substeps=\"auto\""]].concat()), "");
    let inspected = workspace.supple(&[&["inspect", "scene.toml"], modulus.as_slice()].concat());
    assert!(
        inspected.out.contains("\nwarning: body block: it is softer than specified: `youngs_modulus`"),
        "{inspected:?}"
    );
}
