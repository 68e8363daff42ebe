//! `supple inspect` prints facts about a scene and does not run it.

mod support;

use support::{SCENE, Workspace};

#[test]
fn text_and_json_describe_the_scene() {
    let workspace = Workspace::new();
    let text = workspace.supple(&["inspect", "scene.toml"]);
    text.expect(0, &[]);
    for words in [
        "block",
        "10 vertices",
        "7 faces",
        "closed",
        "lattice",
        "cells",
        "memory",
        "SIMD",
        "threads",
        "PC2",
        "on disk",
    ] {
        assert!(text.out.contains(words), "{words}: {}", text.out);
    }
    let json = workspace.supple(&["inspect", "scene.toml", "--json"]);
    json.expect(0, &[]);
    let value: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    let body = &value["bodies"][0];
    assert_eq!(body["name"], "block");
    assert_eq!((&body["mesh"]["vertices"], &body["mesh"]["faces"]), (&10.into(), &7.into()));
    assert_eq!(body["mesh"]["closed"], true);
    assert!((body["mesh"]["volume"].as_f64().unwrap() - 6.0).abs() < 1e-6);
    assert_eq!(body["lattice"]["components"], 1);
    assert!(body["lattice"]["vertices"].as_u64().unwrap() >= 190);
    assert!(value["plan"].as_str().is_some_and(|plan| !plan.is_empty()));
    assert!(value["bytes_on_disk"].as_u64().unwrap() > 0);
    assert!(body["memory_bytes"].as_u64().unwrap() > body["lattice"]["bytes"].as_u64().unwrap());
    assert!(!workspace.path("out").exists());
}

#[test]
fn text_contains_the_plan_only_with_the_flag() {
    let workspace = Workspace::new();
    let json = workspace.supple(&["inspect", "scene.toml", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    let plan: Vec<String> = value["plan"].as_str().unwrap().lines().map(|line| format!("  {line}")).collect();
    assert!(plan.len() > 2, "{plan:?}");
    let without = workspace.supple(&["inspect", "scene.toml"]);
    without.expect(0, &[]);
    let with = workspace.supple(&["inspect", "scene.toml", "--plan"]);
    with.expect(0, &[]);
    for line in &plan {
        assert!(with.out.lines().any(|other| other == line.trim_end()), "{line}: {}", with.out);
        assert!(!without.out.lines().any(|other| other == line.trim_end()), "{line}: {}", without.out);
    }
    assert!(with.out.starts_with(without.out.trim_end()), "{}", with.out);
    assert!(!workspace.path("out").exists());
}

#[test]
fn output_states_that_contact_between_bodies_is_not_simulated() {
    let second = "\n[[body]]\nname = \"other\"\nmesh = \"block.obj\"\ntranslate = [9, 1, 0]\n";
    let workspace = Workspace::with_scene(&format!("{SCENE}{second}"));
    let words = "contact between bodies is not simulated";
    assert!(workspace.supple(&["inspect", "scene.toml"]).out.contains(words));
    assert!(!Workspace::new().supple(&["inspect", "scene.toml"]).out.contains(words));
}

#[test]
fn inspecting_a_model_uses_its_default_scene() {
    let workspace = Workspace::new();
    let output = workspace.supple(&["inspect", "block.obj", "--json", "--set", "body.block.cell_size=0.5"]);
    output.expect(0, &[]);
    let value: serde_json::Value = serde_json::from_str(&output.out).unwrap();
    assert_eq!(value["bodies"][0]["lattice"]["cells"], 4 * 6 * 2);
}
