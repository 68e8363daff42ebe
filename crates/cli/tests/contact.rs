//! Contact between bodies on the command line: the warning about bodies that overlap, `inspect`, the statistics, and
//! resumed runs.

mod support;

use support::{ProgramOutput, Workspace, is_not_of_large_faces};

/// Two blocks of height 3 with a gap of 0.01, one above the other, on a ground.
const STACK: &str = r#"
[simulation]
frames = 12
fps = 30
substeps = 4

[output]
directory = "out"

[[body]]
name = "lower"
mesh = "block.obj"
lattice_vertices = 100

[[body]]
name = "upper"
mesh = "block.obj"
translate = [0, 3.01, 0]
lattice_vertices = 100

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }
"#;

/// Moves the upper block 0.4 into the lower one.
const OVERLAPPING: [&str; 2] = ["--set", "body.upper.translate=[0, 2.6, 0]"];

fn inspect(workspace: &Workspace, options: &[&str]) -> serde_json::Value {
    let output = workspace.supple(&[&["inspect", "scene.toml", "--json"], options].concat());
    output.expect(0, &[]);
    serde_json::from_str(&output.out).unwrap()
}

#[test]
fn run_and_inspect_warn_about_bodies_that_overlap() {
    let workspace = Workspace::with_scene(STACK);
    let run_to = |frames: &str, options: &[&str]| -> ProgramOutput {
        let arguments = ["run", "scene.toml", "--quiet", "--frames", frames];
        let output = workspace.supple(&[&arguments[..], options].concat());
        output.expect(0, &[]);
        output
    };
    let run = |options: &[&str]| run_to("1", options);
    let start = "the bodies lower and upper overlap at the start, up to 0.4 deep; ";
    let output = run(&OVERLAPPING);
    assert!(output.messages().starts_with(&format!("warning: scene: {start}")), "{output:?}");
    assert!(output.err.ends_with("`ignore = [\"upper\"]` of lower\n"), "{output:?}");
    let text = workspace.supple(&[&["inspect", "scene.toml"], &OVERLAPPING[..]].concat()).out;
    assert!(text.contains(&format!("\nwarning: {start}")), "{text}");
    assert!(text.contains("lower and upper overlap at the start, up to 0.4000 deep\n"), "{text}");
    let facts = inspect(&workspace, &OVERLAPPING);
    let pair = &facts["contact"]["overlapping"][0];
    assert_eq!(pair["bodies"], serde_json::json!(["lower", "upper"]));
    assert!((pair["depth"].as_f64().unwrap() - 0.4).abs() < 1e-3, "{pair}");
    // The cause can be removed in each of these ways.
    for option in
        ["body.upper.translate=[0, 3, 0]", "body.upper.ignore=[\"lower\"]", "simulation.contact=false"]
    {
        let options = [&OVERLAPPING[..], &["--set", option]].concat();
        assert_eq!(run(&options).messages(), "", "{option}");
        let warnings: Vec<String> =
            serde_json::from_value(inspect(&workspace, &options)["warnings"].clone()).unwrap();
        assert!(!warnings.iter().any(|line| is_not_of_large_faces(line)), "{option}: {warnings:?}");
    }
    // A resumed run does not begin at the start.
    run(&OVERLAPPING);
    let resumed = run_to("2", &[&OVERLAPPING[..], &["--resume"]].concat());
    assert_eq!(resumed.messages(), "");
}

#[test]
fn inspect_describes_contact_and_the_plan_lists_it() {
    let workspace = Workspace::with_scene(STACK);
    let plan_of = |facts: &serde_json::Value| facts["plan"].as_str().unwrap().to_owned();
    let facts =
        inspect(&workspace, &["--set", "body.upper.friction=0.2", "--set", "body.lower.self_contact=true"]);
    let touching = |name: &str| {
        let bodies = facts["bodies"].as_array().unwrap();
        bodies.iter().find(|body| body["name"] == name).unwrap()["touching"].clone()
    };
    let (lower, upper) = (touching("lower"), touching("upper"));
    assert_eq!((&lower["friction"], &upper["friction"]), (&0.5.into(), &0.2.into()));
    assert_eq!((&lower["self_contact"], &upper["self_contact"]), (&true.into(), &false.into()));
    // The corners of the block, and points between them.
    assert!(lower["samples"].as_u64().unwrap() > 10 && lower["bytes"].as_u64().unwrap() > 1000, "{lower}");
    let plan = plan_of(&facts);
    let stages = plan.lines().filter(|line| line.contains("contact of bodies  ")).count();
    assert_eq!(stages, 2, "{plan}");
    assert!(plan.contains("\ncontact of bodies: "), "{plan}");

    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    assert!(text.contains("contact     between bodies: on; of a body with itself: off"), "{text}");
    assert!(text.contains("contact     friction 0.5, restitution 0, "), "{text}");
    let ignoring = ["--set", "body.upper.ignore=[\"lower\"]", "--set", "body.lower.ignore=[\"upper\"]"];
    let text = workspace.supple(&[&["inspect", "scene.toml"], &ignoring[..]].concat()).out;
    assert_eq!(text.matches("lower and upper pass through each other").count(), 1, "{text}");

    // Without contact no body has the stage, its memory or the data of the simulation.
    let off = inspect(&workspace, &["--set", "simulation.contact=false"]);
    let plan = plan_of(&off);
    assert!(!plan.contains("contact of bodies  ") && !plan.contains("\ncontact of bodies: "), "{plan}");
    assert_eq!(plan.matches(", contact of bodies").count(), 2, "{plan}");
    for (index, body) in off["bodies"].as_array().unwrap().iter().enumerate() {
        assert!(body["touching"].is_null(), "{body}");
        assert!(body["memory_bytes"].as_u64() < facts["bodies"][index]["memory_bytes"].as_u64());
    }
}

#[test]
fn statistics_have_the_contacts_and_the_depth() {
    let workspace = Workspace::with_scene(STACK);
    let rows = |options: &[&str]| -> Vec<serde_json::Value> {
        let arguments = ["run", "scene.toml", "--frames", "6", "--stats", "s.json", "-q", "-o", "stats"];
        workspace.supple(&[&arguments[..], options].concat()).expect(0, &[]);
        serde_json::from_str(&std::fs::read_to_string(workspace.path("s.json")).unwrap()).unwrap()
    };
    let last = |rows: &[serde_json::Value], body: &str| {
        let row = rows.iter().rfind(|row| row["body"] == body).unwrap();
        (row["contacts"].as_u64().unwrap(), row["overlap"].as_f64().unwrap())
    };
    let touching = rows(&[]);
    assert!(touching[..2].iter().all(|row| row["contacts"] == 0 && row["overlap"] == 0.0), "{touching:?}");
    let (lower, upper) = (last(&touching, "lower"), last(&touching, "upper"));
    // The lower block also touches the ground.
    assert!(upper.0 > 0 && lower.0 > upper.0, "{lower:?} {upper:?}");
    assert!(upper.1 >= 0.0 && lower.1 >= upper.1, "{lower:?} {upper:?}");
    // In free fall nothing touches.
    let falling = rows(&["--set", "body.upper.translate=[9, 9, 0]"]);
    assert_eq!(last(&falling, "upper"), (0, 0.0));
}

#[test]
fn a_resumed_run_of_touching_bodies_gives_the_same_frames() {
    let workspace = Workspace::with_scene(STACK);
    let run = |frames: &str, more: &[&str]| {
        let output = workspace.supple(&[&["run", "scene.toml", "-q", "--frames", frames], more].concat());
        output.expect(0, &[]);
    };
    run("12", &["-o", "whole"]);
    // The blocks touch from the second frame on.
    for frames in ["4", "7", "12"] {
        run(frames, &["--resume"]);
    }
    assert!(workspace.frames("out") == workspace.frames("whole"));
    run("12", &["-o", "through", "--set", "simulation.contact=false"]);
    assert!(workspace.frames("through") != workspace.frames("whole"));
}

#[test]
fn resuming_is_rejected_if_contact_changes() {
    let workspace = Workspace::with_scene(STACK);
    workspace.supple(&["run", "scene.toml", "--frames", "2"]).expect(0, &[]);
    for (change, words) in [
        ("simulation.contact=false", "`contact = true` changed to `contact = false`"),
        ("simulation.self_contact=true", "`self_contact = false` changed to `self_contact = true`"),
        ("body.upper.friction=0.4", "\"upper\": `friction = 0.5` changed to `friction = 0.4`"),
        ("body.upper.restitution=0.4", "\"upper\": `restitution = 0.0` changed to `restitution = 0.4`"),
        ("body.upper.ignore=[\"lower\"]", "\"upper\": `ignore = []` changed to `ignore = [\"lower\"]`"),
        ("body.upper.self_contact=true", "\"upper\": `self_contact = true` was added"),
    ] {
        let output = workspace.supple(&["run", "scene.toml", "--frames", "3", "--resume", "--set", change]);
        output.expect(2, &[words]);
    }
    workspace.supple(&["run", "scene.toml", "--frames", "3", "--resume"]).expect(0, &[]);
}
