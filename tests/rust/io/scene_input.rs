//! Scenes changed by overrides, and the default scene of a model file.

use std::path::Path;

use supple::{Damping, Elasticity, Preservation, Preset, RegionSize, Stiffness};
use supple_io::frames::Format;
use supple_io::scene::{ColliderShape, Scene, SceneError, Up};

const TWO: &str = r#"
[output]
directory = "out"

[[body]]
name = "bust"
mesh = "bust.obj"
stiffness_radius = 0.2

[[body.handle]]
sphere = { center = [0, 1, 0], radius = 0.5 }
keys = [ { time = 0 }, { time = 1, translate = [0, 0.5, 0] } ]

[[body]]
name = "ball.2"
mesh = "ball.obj"

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }

[[collider]]
sphere = { center = [0, 0, 0], radius = 1 }
"#;

const SMALL: &str = "[[body]]\nname = \"bust\"\nmesh = \"bust.obj\"\n";

fn parse_with(text: &str, overrides: &[&str]) -> Result<Scene, SceneError> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Scene::parse(text, "scene.toml", Path::new("folder"), &overrides)
}

#[test]
fn overrides_change_values_of_the_scene() {
    let scene = parse_with(
        TWO,
        &[
            "simulation.frames=60",
            "output.format=pc2",
            "output.directory = \"else where\"",
            "body.bust.half_width=3",
            "body.ball.2.density=10",
            "body.bust.handle.0.keys.1.translate=[0, 2, 0]",
            "body.1.translate=[0, 5, 0]",
            "collider.1.friction=0",
        ],
    )
    .unwrap();
    assert_eq!((scene.simulation.frames, scene.output.format), (60, Format::Pc2.into()));
    assert_eq!(scene.output.directory, Path::new("else where"));
    // The override of `half_width` replaces `stiffness_radius`.
    assert_eq!(
        scene.bodies[0].material.elasticity,
        Elasticity::REGIONS.with_region_size(RegionSize::Cells(3.into()))
    );
    assert_eq!(
        (scene.bodies[1].material.density, scene.bodies[1].placement.translate),
        (10.0, [0.0, 5.0, 0.0])
    );
    assert_eq!(scene.bodies[0].handles[0].keys[1].translate, [0.0, 2.0, 0.0]);
    assert_eq!(scene.colliders[1].friction, 0.0);
    assert_eq!(parse_with(SMALL, &["simulation.fps=25"]).unwrap().simulation.fps, 25.0);
}

#[test]
fn an_override_of_the_elasticity_replaces_the_other_ways_to_set_it() {
    let elasticity = |line: &str, override_: &str| {
        let scene = parse_with(&format!("{SMALL}{line}\n"), &[override_]).unwrap();
        scene.bodies[0].material.elasticity
    };
    let modulus = "body.bust.youngs_modulus=2e6";
    for line in ["half_width = 3\nfrequency = 5", "stiffness_radius = 0.1", "material = \"firm\""] {
        assert_eq!(elasticity(line, modulus), Elasticity::YoungsModulus(2e6), "{line}");
    }
    assert_eq!(
        elasticity("half_width = 3\nstiffness = 0.5", "body.bust.material=jelly"),
        Elasticity::Preset(Preset::Jelly)
    );
    assert_eq!(elasticity("youngs_modulus = 2e6", "body.bust.stiffness=1"), Elasticity::REGIONS);
    // A key of the same way stays.
    let regions = Elasticity::REGIONS.with_stiffness(Stiffness::PerStep(0.5));
    assert_eq!(elasticity("half_width = 2", "body.bust.stiffness=0.5"), regions);

    let damping = |override_| {
        let scene = parse_with(&format!("{SMALL}damping_ratio = 0.3\n"), &[override_]).unwrap();
        scene.bodies[0].material.damping
    };
    assert_eq!(damping("body.bust.damping_rate=2"), Some(Damping::Rate(2.0)));
    assert!(!parse_with(SMALL, &["simulation.sleep=false"]).unwrap().simulation.sleep);
    let both = ["body.bust.half_width=3", modulus];
    let message = parse_with(SMALL, &both).unwrap_err().to_string();
    assert!(message.contains("youngs_modulus") && message.contains("half_width"), "{message}");
}

#[test]
fn invalid_overrides_are_errors_with_the_override_and_the_reason() {
    for (text, words) in [
        ("simulation.frames", "must be KEY=VALUE, such as body.bust.half_width=3"),
        ("simulation.frame=3", "unknown key `simulation.frame`; the nearest one is `frames`"),
        ("body.bsut.half_width=3", "no element is called `bsut`; the nearest known name is `bust`"),
        ("body.7.half_width=3", "there is no element 7: the list has 1, counted from 0"),
        (
            "body.bust.half_width=0",
            "`body.bust.half_width` is 0; it must be 0.5 or a whole number of cells, at least 1",
        ),
        ("body.bust.stiffness=soft", "a number, not the string \"soft\""),
        ("body.bust.name.x=1", "`x` is below the string \"bust\", which has no keys; shorten the key"),
        ("body..x=1", "is called ``; the nearest known name is `bust`"),
        (".x=1", "the key has an empty part; write a key like body.bust.half_width"),
    ] {
        let message = parse_with(SMALL, &[text]).unwrap_err().to_string();
        assert!(message.contains(&format!("--set {text}")) && message.contains(words), "{message}");
    }
    let both = ["body.bust.half_width=3", "body.bust.stiffness_radius=0.1"];
    assert!(matches!(parse_with(SMALL, &both), Err(SceneError::Exclusive { .. })));
}

#[test]
fn in_the_default_scene_a_model_falls_its_own_height_in_half_a_second() {
    for (up, axis) in [(Up::Y, 1), (Up::Z, 2)] {
        let scene =
            Scene::of_model(Path::new("models/red ball.obj"), [-1.0, -2.0, -3.0], [1.0, 2.0, 4.0], up);
        let height = [2.0, 4.0, 7.0][axis];
        let low = [-1.0, -2.0, -3.0][axis];
        let g = -scene.simulation.gravity.value(0.0)[axis];
        assert!((0.5 * g * 0.25 - height).abs() < 1e-4 * height);
        let ColliderShape::Plane { point, normal } = scene.colliders[0].shape else { panic!("a plane") };
        assert!(point[axis] < low && point[axis] > low - 0.2 * height);
        assert_eq!(normal[axis], 1.0);
        assert_eq!(scene.bodies[0].name, "red_ball");
        assert_eq!(scene.bodies[0].volume.measure, Preservation::Auto);
        assert_eq!(Scene::parse(&scene.to_toml(), "model", Path::new(""), &[]).unwrap(), scene);
    }
    let flat = Scene::of_model(Path::new("sheet.obj"), [0.0; 3], [1e-3, 0.0, 1e-3], Up::Y);
    assert!(flat.simulation.gravity.value(0.0)[1] < 0.0);
}
