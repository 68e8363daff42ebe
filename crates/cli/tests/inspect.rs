//! `supple inspect` prints facts about a scene and does not run it.

mod support;

use support::{SCENE, Workspace, is_not_of_large_faces};

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
    let estimate = |key: &str| value["estimate"][key].as_f64().unwrap();
    assert!(estimate("memory_bytes") >= body["memory_bytes"].as_f64().unwrap());
    assert!(estimate("memory_limit_bytes") > estimate("memory_bytes"));
    assert!(estimate("seconds_per_frame") > 0.0 && estimate("seconds_per_frame") < 10.0);
    assert_eq!(21.0 * estimate("bytes_per_frame"), value["bytes_on_disk"].as_f64().unwrap());
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
    // The plan comes before the warnings.
    let (text, _) = without.out.split_once("\nwarning: ").unwrap();
    assert!(with.out.starts_with(text), "{}", with.out);
    assert!(!workspace.path("out").exists());
}

#[test]
fn maps_are_listed_with_their_ranges() {
    let workspace = Workspace::new();
    let color = |line: &str| match line {
        "v -1 3 0.5" => " 0.75 0.5 0",
        line if line.starts_with("v ") => " 0.25 0.5 0",
        _ => "",
    };
    let painted = support::BLOCK.lines().map(|line| format!("{line}{}\n", color(line)));
    workspace.write("block.obj", painted.collect::<String>());
    for refine in ["off", "auto"] {
        let value = inspect(&workspace, &["--set", &format!("body.block.refine={refine:?}")]);
        let maps: Vec<(&str, f64, f64)> = (value["bodies"][0]["mesh"]["maps"].as_array().unwrap().iter())
            .map(|map| {
                let number = |key: &str| map[key].as_f64().unwrap();
                (map["name"].as_str().unwrap(), number("least"), number("greatest"))
            })
            .collect();
        assert_eq!(maps, [("blue", 0.0, 0.0), ("green", 0.5, 0.5), ("red", 0.25, 0.75)], "{refine}");
    }
    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    assert!(text.contains("map red: 0.2500 to 0.7500\n"), "{text}");
    assert!(inspect(&Workspace::new(), &[])["bodies"][0]["mesh"]["maps"].as_array().unwrap().is_empty());
}

#[test]
fn zones_are_printed_with_their_factors_and_vertices() {
    let zone = "\n[[body.zone]]\nplane = { point = [0, 3, 0], normal = [0, 1, 0] }\nfactor = 0.25\n";
    let workspace = Workspace::with_scene(&SCENE.replace("\n[[collider]]", &format!("{zone}\n[[collider]]")));
    let value: serde_json::Value =
        serde_json::from_str(&workspace.supple(&["inspect", "scene.toml", "--json"]).out).unwrap();
    let (body, zone) = (&value["bodies"][0], &value["bodies"][0]["zones"][0]);
    let [inside, border] = ["lattice_vertices", "border_vertices"].map(|key| zone[key].as_u64().unwrap());
    assert_eq!(zone["factor"], 0.25);
    assert!(inside > 0 && border > 0 && inside + border < body["lattice"]["vertices"].as_u64().unwrap());
    let low = zone["low"][1].as_f64().unwrap();
    assert!(low < 3.0 && low > 3.0 - body["lattice"]["cell_size"].as_f64().unwrap(), "{zone}");
    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    assert!(
        text.contains(&format!("factor 0.25 on {inside} lattice vertices, {border} at its border")),
        "{text}"
    );
    let empty =
        workspace.supple(&["inspect", "scene.toml", "--set", "body.block.zone.0.plane.point=[0, 99, 0]"]);
    empty.expect(2, &["body.block.zone.0", "selects nothing", "outside"]);
    let study = workspace.supple(&["study", "scene.toml"]);
    study.expect(2, &["\"block\" has zones", "remove [[body.zone]]"]);
}

#[test]
fn inspecting_a_model_uses_its_default_scene() {
    let workspace = Workspace::new();
    let output = workspace.supple(&["inspect", "block.obj", "--json", "--set", "body.block.cell_size=0.5"]);
    output.expect(0, &[]);
    let value: serde_json::Value = serde_json::from_str(&output.out).unwrap();
    assert_eq!(value["bodies"][0]["lattice"]["cells"], 4 * 6 * 2);
}

/// Returns the JSON of `supple inspect scene.toml` with options.
fn inspect(workspace: &Workspace, options: &[&str]) -> serde_json::Value {
    let mut arguments = vec!["inspect", "scene.toml", "--json"];
    arguments.extend(options);
    let output = workspace.supple(&arguments);
    output.expect(0, &[]);
    serde_json::from_str(&output.out).unwrap()
}

#[test]
fn the_material_in_force_is_described() {
    let scene = SCENE.replace("half_width = 1\n", "").replace("substeps = 2\n", "");
    let workspace = Workspace::with_scene(&scene);
    let number = |value: &serde_json::Value, key: &str| value["bodies"][0][key].as_f64().unwrap();
    let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-9;

    // Flesh, the default: E = 80 rho L max(g, 8 L), where L is the cube root of the volume 6.
    let value = inspect(&workspace, &[]);
    let size = 6.0_f64.cbrt();
    let modulus = 80.0 * 1000.0 * size * 9.81_f64.max(8.0 * size);
    assert_eq!(value["bodies"][0]["material"], "flesh");
    for key in ["youngs_modulus", "youngs_modulus_in_force"] {
        assert!(near(number(&value, key), modulus), "{key}: {value}");
    }
    assert!(near(number(&value, "wave_speed"), (modulus / 1000.0).sqrt()));
    let frequency = number(&value, "lowest_frequency");
    assert_eq!(number(&value, "damping_ratio"), 0.3);
    assert!(near(number(&value, "damping_rate"), 0.3 * std::f64::consts::TAU * frequency));
    // Waves cross the block, 3 units high, back and forth in a period of its longest mode of stretch; bending and twist
    // of the block are slower, by less than its ratio of height to thickness.
    let stretch = number(&value, "wave_speed") / 6.0;
    assert!((stretch / 3.0..1.1 * stretch).contains(&frequency), "{frequency} Hz, stretch at {stretch} Hz");
    assert_eq!(value["substeps_auto"], true);
    assert_eq!(value["substeps_reason"], "for the stiffness of block");
    let steps = &value["substeps"];
    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    for line in [
        format!("  steps       {steps} per frame (auto: for the stiffness of block)\n"),
        format!("  material    flesh, Young's modulus {modulus:.3e}\n"),
        format!(
            "wave speed {:.2}, lowest frequency {frequency:.3} Hz, damping ratio 0.3000 (",
            (modulus / 1e3).sqrt()
        ),
    ] {
        assert!(text.contains(&line), "{line}: {text}");
    }

    // A modulus that steps of this length cannot reach.
    let options = ["--set", "body.block.youngs_modulus=1e9", "--set", "simulation.substeps=1"];
    let value = inspect(&workspace, &[options.as_slice(), &["--set", "body.block.damping_rate=3"]].concat());
    let body = &value["bodies"][0];
    assert_eq!((&body["material"], &body["youngs_modulus"]), (&serde_json::Value::Null, &1e9.into()));
    let in_force = number(&value, "youngs_modulus_in_force");
    assert!(in_force < 1e9 && near(number(&value, "wave_speed"), (in_force / 1000.0).sqrt()), "{body}");
    assert_eq!(number(&value, "damping_rate"), 3.0);
    let angular_frequency = std::f64::consts::TAU * number(&value, "lowest_frequency");
    assert!(near(number(&value, "damping_ratio"), 3.0 / angular_frequency));
    assert_eq!(
        (&value["substeps_auto"], &value["substeps_reason"]),
        (&false.into(), &serde_json::Value::Null)
    );
    let text = workspace.supple(&[&["inspect", "scene.toml"], options.as_slice()].concat()).out;
    assert!(text.contains("  material    Young's modulus 1.000e9, in force "), "{text}");
    assert!(text.contains("  steps       1 per frame\n"), "{text}");

    // Regions: E = rho (alpha/dt^2) h^2 w (w + 1)/3.
    let options = ["half_width=2", "stiffness=0.5", "damping_ratio=0"].map(|key| format!("body.block.{key}"));
    let options: Vec<&str> = options.iter().flat_map(|option| ["--set", option]).collect();
    let value = inspect(&workspace, &options);
    let body = &value["bodies"][0];
    assert_eq!(
        (&body["material"], &body["youngs_modulus"]),
        (&serde_json::Value::Null, &serde_json::Value::Null)
    );
    let rate = 30.0 * value["substeps"].as_f64().unwrap() * body["lattice"]["cell_size"].as_f64().unwrap();
    assert!(near(number(&value, "youngs_modulus_in_force"), 1000.0 * 0.5 * rate * rate * 2.0), "{body}");
    assert_eq!((number(&value, "damping_ratio"), number(&value, "damping_rate")), (0.0, 0.0));
    let text = workspace.supple(&[&["inspect", "scene.toml"], options.as_slice()].concat()).out;
    assert!(text.contains("  material    by half-width and stiffness, Young's modulus "), "{text}");
    assert!(text.contains(" Hz, no damping\n"), "{text}");
}

#[test]
fn the_reason_of_a_single_automatic_step_names_no_body() {
    let scene = SCENE.replace("substeps = 2\n", "gravity = [0, 0, 0]\n");
    let workspace = Workspace::with_scene(&scene);
    let value = inspect(&workspace, &[]);
    assert_eq!((&value["substeps"], &value["substeps_reason"]), (&1.into(), &"one step is enough".into()));
    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    assert!(text.contains("  steps       1 per frame (auto: one step is enough)\n"), "{text}");
}

fn point(value: &serde_json::Value) -> [f64; 3] {
    serde_json::from_value(value.clone()).unwrap()
}

#[track_caller]
fn assert_near(found: &serde_json::Value, expected: [f64; 3]) {
    let found = point(found);
    let is_near = (0..3).all(|axis| (found[axis] - expected[axis]).abs() < 1e-6);
    assert!(is_near, "{found:?} {expected:?}");
}

#[test]
fn bounds_are_in_the_world() {
    let workspace = Workspace::new();
    let options = ["--set", "body.block.scale=2", "--set", "body.block.rotate=[0, 0, 90]"];
    let no_pin = ["--set", "body.block.pin=[]"];
    let value = inspect(&workspace, &[options.as_slice(), &no_pin].concat());
    let mesh = &value["bodies"][0]["mesh"];
    // The block from (-1, 0, -0.5) to (1, 3, 0.5), scaled.
    assert_near(&mesh["low"], [-2.0, 0.0, -1.0]);
    assert_near(&mesh["high"], [2.0, 6.0, 1.0]);
    // Rotated by 90 degrees about z, and moved by 1 along y.
    assert_near(&mesh["world_low"], [-6.0, -1.0, -1.0]);
    assert_near(&mesh["world_high"], [0.0, 3.0, 1.0]);
    let text = workspace.supple(&["inspect", "scene.toml"]);
    let expected = "in the world from (-1.000, 1.000, -0.5000) to (1.000, 4.000, 0.5000)";
    assert!(text.out.contains(expected), "{}", text.out);
}

#[test]
fn a_handle_names_the_animation_that_it_follows() {
    let workspace = Workspace::new();
    workspace
        .supple(&["run", "scene.toml", "--format", "pc2", "-o", "cache", "--frames", "3", "--quiet"])
        .expect(0, &[]);
    let follow = "\n[[body.handle]]\nplane = { point = [0, 3.9, 0], normal = [0, 1, 0] }\n\
                  follow = \"cache/block.pc2\"\n\n[[collider]]";
    let workspace_scene = SCENE.replace("\n[[collider]]", follow);
    std::fs::write(workspace.path("scene.toml"), workspace_scene).unwrap();
    let value = inspect(&workspace, &[]);
    let handle = &value["bodies"][0]["handles"][0];
    assert_eq!(handle["mesh_vertices"], 6);
    let follow = &handle["follow"];
    assert!(follow["file"].as_str().unwrap().ends_with("block.pc2"));
    assert_eq!(
        (&follow["samples"], &follow["first"], &follow["last"]),
        (&4.into(), &0.0.into(), &0.1.into())
    );
    // The frames are in world space, and the placement of the body moves them again.
    let distance = follow["distance_at_start"].as_f64().unwrap();
    assert!((distance - 1.0).abs() < 1e-6, "{distance}");
    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    assert!(text.contains("block.pc2: 4 samples from 0.000000 to 0.1000 s"), "{text}");
    assert!(text.contains("up to 1.000 from its rest pose"), "{text}");
    assert!(value["bodies"][0]["pins"][0].get("follow").is_none());
}

#[test]
fn pins_and_handles_list_what_they_select() {
    let second = "\n[[body.pin]]\nlattice = [0]\n\n[[body.handle]]\nplane = { point = [0, 3.9, 0], normal = [0, 1, 0] }\n\
                  keys = [{ time = 0 }]\n\n[[collider]]";
    let workspace = Workspace::with_scene(&SCENE.replace("\n[[collider]]", second));
    let value = inspect(&workspace, &[]);
    let body = &value["bodies"][0];
    let (pins, handles) = (body["pins"].as_array().unwrap(), body["handles"].as_array().unwrap());
    assert_eq!((pins.len(), handles.len()), (2, 1));
    // The box takes the four corners of the side x = -1.
    assert_eq!(pins[0]["mesh_vertices"], 4);
    assert_near(&pins[0]["low"], [-1.0, 1.0, -0.5]);
    assert_near(&pins[0]["high"], [-1.0, 4.0, 0.5]);
    // Each mesh vertex takes the 8 corners of its cell, and some share corners.
    let held = pins[0]["lattice_vertices"].as_u64().unwrap();
    assert!((8..=32).contains(&held), "{held}");
    assert_eq!(
        (&pins[1]["mesh_vertices"], &pins[1]["lattice_vertices"]),
        (&serde_json::Value::Null, &1.into())
    );
    assert_eq!(point(&pins[1]["low"]), point(&pins[1]["high"]));
    // The plane takes the six vertices of the upper side.
    assert_eq!(handles[0]["mesh_vertices"], 6);
    assert_near(&handles[0]["low"], [-1.0, 4.0, -0.5]);
    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    let line = format!(
        "  pin 0       4 mesh vertices from (-1.000, 1.000, -0.5000) to (-1.000, 4.000, 0.5000), {held} lattice \
         vertices"
    );
    assert!(text.contains(&line) && text.contains("  pin 1       1 lattice vertex from"), "{text}");
    assert!(text.contains("  handle 0    6 mesh vertices from"), "{text}");
}

#[test]
fn separate_parts_are_counted() {
    // Eight cubes of size 1 in a row, of which the first two share cells and the others are 9 apart.
    let mut mesh = String::new();
    for (cube, x) in [0.0, 1.1, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0].into_iter().enumerate() {
        for corner in [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
        {
            mesh += &format!("v {} {} {}\n", f64::from(corner[0]) + x, corner[1], corner[2]);
        }
        for face in [[4, 3, 2, 1], [5, 6, 7, 8], [1, 2, 6, 5], [2, 3, 7, 6], [3, 4, 8, 7], [4, 1, 5, 8]] {
            let [a, b, c, d] = face.map(|vertex| vertex + 8 * cube);
            mesh += &format!("f {a} {b} {c} {d}\n");
        }
    }
    let scene = "[[body]]\nname = \"row\"\nmesh = \"row.obj\"\ncell_size = 0.7\nvolume = \"off\"\n";
    let workspace = Workspace::with_scene(scene);
    workspace.write("row.obj", mesh);
    let value = inspect(&workspace, &[]);
    let lattice = &value["bodies"][0]["lattice"];
    let floating = lattice["floating"].as_array().unwrap().len();
    assert_eq!((floating, &lattice["joined_parts"], &lattice["separate_parts"]), (6, &6.into(), &0.into()));
    assert_eq!(lattice["glued_components"], 2);
    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    assert!(text.contains("6 floating parts, separate from the largest part; joined"), "{text}");
    assert!(text.contains("2 mesh components in 1 group are connected in the lattice"), "{text}");
    let text = workspace.supple(&["inspect", "scene.toml", "--set", "body.row.join=false"]).out;
    assert!(text.contains("6 floating parts, separate from the largest part; not joined"), "{text}");
}

#[test]
fn bodies_inside_colliders_or_beyond_the_precision_of_frames_are_warned_about() {
    let warnings = |scene: &str, options: &[&str]| -> Vec<String> {
        let workspace = Workspace::with_scene(scene);
        let no_pin = ["--set", "body.block.pin=[]"];
        let value = inspect(&workspace, &[options, &no_pin].concat());
        let mut warnings: Vec<String> = serde_json::from_value(value["warnings"].clone()).unwrap();
        warnings.retain(|line| is_not_of_large_faces(line));
        warnings
    };
    let moved = |translate: &str| warnings(SCENE, &["--set", &format!("body.block.translate={translate}")]);
    // The block is 3 high. It may stand on the ground.
    assert!(moved("[0, 1, 0]").is_empty() && moved("[0, 0, 0]").is_empty());
    for (translate, words) in [
        ("[0, -0.5, 0]", "begins partly inside collider.0, up to 0.5000 deep"),
        ("[0, -9, 0]", "begins under collider.0, up to 9.000 deep"),
    ] {
        let found = moved(translate);
        assert!(found.len() == 1 && found[0].contains(words), "{found:?}");
    }
    let ball = SCENE.replace(
        "plane = { point = [0, 0, 0], normal = [0, 1, 0] }",
        "sphere = { center = [0, 2, 0], radius = 9 }",
    );
    assert!(warnings(&ball, &[])[0].contains("begins inside collider.0"), "{ball}");
    // The ball lies inside the upper side of the block, at the center of a face.
    let small = ball.replace("[0, 2, 0], radius = 9", "[0.5, 4, 0], radius = 0.2");
    assert!(warnings(&small, &[])[0].contains("begins partly inside collider.0, up to 0.2"), "{small}");
    // A moving collider counts with its pose at time 0.
    let below = SCENE.replace(
        "normal = [0, 1, 0] }",
        "normal = [0, 1, 0] }\nkeys = [{ time = 0, translate = [0, 2, 0] }]",
    );
    assert!(warnings(&below, &[])[0].contains("up to 1.000 deep"), "{below}");

    // Cells have a size of about 0.4, and 32-bit numbers a spacing of 0.00024 at 4000 and 0.0005 at 8000.
    assert!(moved("[4000, 1, 0]").is_empty());
    let far = moved("[8000, 1, 0]");
    assert!(far.len() == 1 && far[0].contains("move it nearer to the origin with `translate`"), "{far:?}");
    assert!(far[0].contains("4.883e-4 apart at the coordinate 8001"), "{far:?}");
    let lost = moved("[1e7, 1, 0]");
    assert!(
        lost.len() == 1 && lost[0].contains("times its extent; check `translate` and the unit"),
        "{lost:?}"
    );
    // 30,000 cells in a row.
    let long = support::BLOCK.replace("v 1 ", "v 30000 ").replace("v 0 ", "v 15000 ");
    let workspace = Workspace::with_scene(&SCENE.replace("lattice_vertices = 200", "cell_size = 1"));
    workspace.write("block.obj", long);
    let value = inspect(&workspace, &["--set", "body.block.pin=[]"]);
    let mut lines = value["warnings"].as_array().unwrap().iter().map(|line| line.as_str().unwrap());
    let found = lines.find(|line| is_not_of_large_faces(line)).unwrap();
    assert!(found.contains("its cells are too small for its size; choose a larger `cell_size`"), "{found}");
    let text = workspace.supple(&["inspect", "scene.toml"]).out;
    assert!(text.contains(&format!("\nwarning: {found}\n")), "{text}");
}

#[test]
fn plasticity_is_described() {
    let workspace = Workspace::new();
    let set = ["--set", "body.block.plastic.yield=0.02", "--set", "body.block.half_width=1"];
    let inspect = |more: &[&str]| {
        let output = workspace.supple(&[&["inspect", "scene.toml"], &set[..], more].concat());
        output.expect(0, &[]);
        output.out
    };
    let text = inspect(&["--plan"]);
    assert!(
        text.contains("flows beyond a strain of 0.02, at 5 /s, up to a plastic strain of 1; region radius")
    );
    assert!(text.contains("plastic shapes"), "{text}");
    let value: serde_json::Value = serde_json::from_str(&inspect(&["--json"])).unwrap();
    let body = &value["bodies"][0];
    assert_eq!((&body["plastic"]["yield"], &body["plastic"]["max"]), (&0.02.into(), &1.0.into()));
    // √(w (w + 1)) cells.
    let cell_size = body["lattice"]["cell_size"].as_f64().unwrap();
    let radius = body["plastic"]["region_radius"].as_f64().unwrap();
    assert!((radius - cell_size * 2.0_f64.sqrt()).abs() < 1e-12);
    let elastic = workspace.supple(&["inspect", "scene.toml", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&elastic.out).unwrap();
    assert!(value["bodies"][0].get("plastic").is_none());
}

#[test]
fn fracture_is_described() {
    let workspace = Workspace::new();
    let set = ["--set", "body.block.fracture.strength=500", "--set", "body.block.half_width=2"];
    let inspect = |set: &[&str], more: &[&str]| {
        let output = workspace.supple(&[&["inspect", "scene.toml"], set, more].concat());
        output.expect(0, &[]);
        output.out
    };
    let text = inspect(&set, &["--plan"]);
    assert!(
        text.contains(
            "a stress of 500.0; noise 0.05 with seed 0, at most 1 crack at a time, smooth surfaces"
        ),
        "{text}"
    );
    assert!(!text.contains("smooths the strain at notches"), "{text}");
    let value: serde_json::Value = serde_json::from_str(&inspect(&set, &["--json"])).unwrap();
    let body = &value["bodies"][0];
    let (fracture, modulus) = (&body["fracture"], body["youngs_modulus_in_force"].as_f64().unwrap());
    assert_eq!((&fracture["strength"], &fracture["strain"]), (&500.0.into(), &serde_json::Value::Null));
    let strain = fracture["strain_in_force"].as_f64().unwrap();
    assert!((strain * modulus - 500.0).abs() < 1e-9);

    let set = ["--set", "body.block.fracture.strain=0.2", "--set", "body.block.half_width=3"];
    let text = inspect(&set, &["--set", "body.block.fracture.rotation=30"]);
    assert!(text.contains("breaks at a strain of 0.2000, a stress of "), "{text}");
    assert!(text.contains(" or a rotation of 30 degrees; noise"), "{text}");
    assert!(text.contains("warning: body block: its regions reach 3 cells to each side"), "{text}");
    let whole: serde_json::Value = serde_json::from_str(&inspect(&[], &["--json"])).unwrap();
    assert!(whole["bodies"][0].get("fracture").is_none());

    // A point cache has the same faces in all frames, so `run` refuses it.
    let refused = "warning: `supple run` refuses the scene: body `block` can break (`body.block.fracture`), and pc2 has";
    let formats = ["--set", "output.format=[\"obj\", \"pc2\"]"];
    let text = inspect(&set, &formats);
    assert!(text.contains(refused), "{text}");
    assert!(!text.contains("PC2"), "{text}");
    let text = inspect(&[], &formats);
    assert!(!text.contains(refused) && text.contains("PC2"), "{text}");
    assert!(!inspect(&set, &[]).contains(refused));
}

#[test]
fn models_of_other_formats_are_described() {
    let workspace = Workspace::new();
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
               element face 5\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int a\nend_header\n\
               0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n2 0 1\n1\n";
    workspace.write("model.ply", ply);
    let text = workspace.supple(&["inspect", "model.ply", "--set", "output.format=pc2"]);
    text.expect(0, &[]);
    for words in [
        "4 vertices",
        "closed",
        "not read: 1 element `edge`",
        "not read: 1 face of fewer than three corners",
        "4 points, the vertices of model.ply as in OBJ frames (--format obj,pc2)",
    ] {
        assert!(text.out.contains(words), "{words}: {}", text.out);
    }
    workspace.supple(&["run", "model.ply", "-o", "out", "--frames", "2"]).expect(0, &[]);
    assert!(workspace.path("out/model_0002.obj").exists());
    workspace.supple(&["model.ply"]).expect(2, &["to simulate it, write: supple run model.ply"]);
    workspace.write("cloud.ply", ply.replace("face 5", "face 0"));
    workspace
        .supple(&["run", "cloud.ply"])
        .expect(2, &["cloud.ply: a PLY file without faces is a point cloud"]);
    workspace.write("model.fbx", "Kaydara");
    let words = "model.fbx: files with the extension .fbx are not read; give a scene (.toml) or a model: OBJ (.obj), GLB";
    workspace.supple(&["inspect", "model.fbx"]).expect(2, &[words]);
}
