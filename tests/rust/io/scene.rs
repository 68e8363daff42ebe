//! Scenes: all keys, errors with their messages, overrides, and writing as text.

use std::path::Path;

use supple::{
    Attraction, BreakLimit, Curve, CurveKey, CutSurface, Damping, Elasticity, Field, FieldKind, FieldLaw,
    FractureOptions, Goal, Interpolation, KeyedMaterial, Link, Material, Plasticity, Preservation, Preset,
    RegionDamping, RegionSize, Resolution, Selection, Stiffness, TouchingOptions, VolumeMeasure, VolumeScope,
    Vortex, Wind, Zone,
};
use supple_io::frames::Format;
use supple_io::scene::{ColliderShape, Scene, SceneError, Substeps, body_keys, exclusive_keys};

const FULL: &str = r#"
[simulation]
frames = 12
fps = 24
substeps = "auto"
gravity = [0, 0, -9.81]
threads = 2
contact = false
self_contact = true
sleep = false

[output]
directory = "out"
format = "ply"

[[body]]
name = "bust"
mesh = "bust.obj"
object = "Head"
scale = 2
rotate = [0, 90, 0]
translate = [0, 1, 0]
cell_size = 0.1
join = false
stiffness_radius = 0.2
frequency = 12.0
damping_rate = 1.5
region_damping_rate = 3.0
density = 500
inflate = { keys = [{ time = 0, value = 1 }, { time = 2.5, value = 1.3 }], interpolation = "smooth" }
volume = { measure = "mesh", scope = "regional", field = "paper", max_correction = 0.5 }
velocity = [1, 2, 3]
spin = [4, 5, 6]
friction = 0.25
restitution = 0.75
rolling_resistance = 0.1
thickness = 0.02
ignore = ["ball.2"]
self_contact = false

[[body.pin]]
box = { min = [0, 0, 0], max = [1, 1, 1] }
end = 2.0

[[body.pin]]
group = "Skin"
weight = [ { time = 0, value = 0.5 }, { time = 1, value = 1 } ]
goal_frequency = 8
goal_damping = 0

[[body.pin]]
lattice = [7, 1]

[[body.zone]]
plane = { point = [0, 2, 0], normal = [0, 1, 0] }
factor = 0.5

[[body.zone]]
vertices = [3, 5]
inflate = 0.75

[[body.handle]]
sphere = { center = [0, 1, 0], radius = 0.5 }
keys = [ { time = 0 }, { time = 1, translate = [0, 0.5, 0], rotate = [0, 720, 0] } ]
start = 0.5
weight = 0.7

[[body]]
name = "ball.2"
mesh = "ball.obj"

[[collider]]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }

[[collider]]
box = { center = [0, 0, 0], half_extents = [1, 2, 3], rotate = [0, 45, 0] }
friction = 0.1
restitution = 0.9
rolling_resistance = 0.2
thickness = 0.01
keys = [ { time = 1, translate = [0, -1, 0] } ]

[[collider]]
capsule = { a = [0, 0, 0], b = [0, 1, 0], radius = 0.25 }

[[field]]
wind = { velocity = [1, 0, 2], drag = 0.5, gust = 0.3, turbulence = 0.1, seed = 9 }
strength = [ { time = 0, value = 0 }, { time = 2, value = 1.5 } ]
bodies = ["ball.2"]
sphere = { center = [0, 1, 0], radius = 4 }

[[field]]
drag = 0.25

[[field]]
gravity = [0, 0, 1]
plane = { point = [0, 0, 0], normal = [0, 1, 0] }

[[field]]
vortex = { center = [1, 0, 0], axis = [0, 0, 1], spin = 2, radius = 3, drag = 4 }

[[link]]
body = "bust"
sphere = { center = [0, 1, 0], radius = 2 }
other = "ball.2"
stiffness = 100
damping_ratio = 0.5
break = 20

[[link]]
body = "ball.2"
group = "top"

[[field]]
attract = { center = [0, 5, 0], acceleration = -2, radius = 0.5, power = 1 }
"#;

const SMALL: &str = "[[body]]\nname = \"bust\"\nmesh = \"bust.obj\"\n";

fn parse(text: &str) -> Result<Scene, SceneError> {
    parse_with(text, &[])
}

fn parse_with(text: &str, overrides: &[&str]) -> Result<Scene, SceneError> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Scene::parse(text, "scene.toml", Path::new("folder"), &overrides)
}

/// Returns the error message of a small scene with additional lines in its body.
fn refusal(lines: &str) -> String {
    parse(&format!("{SMALL}{lines}\n")).expect_err(lines).to_string()
}

#[test]
fn every_key_is_read() {
    let scene = parse(FULL).unwrap();
    assert_eq!((scene.simulation.frames, scene.simulation.fps), (12, 24.0));
    assert_eq!((scene.simulation.substeps, scene.simulation.threads), (Substeps::Auto, 2));
    assert_eq!((&scene.simulation.gravity, scene.simulation.sleep), (&[0.0, 0.0, -9.81].into(), false));
    assert_eq!((scene.simulation.contact, scene.simulation.self_contact), (false, true));
    assert_eq!(scene.output.format, Format::Ply.into());
    assert_eq!(scene.resolve(&scene.output.directory), Path::new("folder/out"));

    let body = &scene.bodies[0];
    assert_eq!((body.name.as_str(), body.object.as_deref()), ("bust", Some("Head")));
    assert_eq!(
        (body.scale, body.placement.rotate, body.placement.translate),
        (2.0.into(), [0.0, 90.0, 0.0], [0.0, 1.0, 0.0])
    );
    assert_eq!((body.resolution, body.join), (Resolution::CellSize(0.1), false));
    assert_eq!(
        body.material.elasticity,
        Elasticity::Regions { size: RegionSize::Radius(0.2), stiffness: Stiffness::Frequency(12.0) }
    );
    assert_eq!(
        (body.material.damping, body.material.region_damping),
        (Some(Damping::Rate(1.5)), RegionDamping::Rate(3.0))
    );
    assert_eq!(
        (body.volume.measure, body.volume.scope, body.volume.field, body.volume.max_correction),
        (Preservation::By(VolumeMeasure::Mesh), VolumeScope::Regional, FieldKind::Paper, 0.5)
    );
    assert_eq!(
        (body.material.density, body.placement.velocity, body.placement.spin),
        (500.0, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0])
    );
    let touching = TouchingOptions {
        friction: 0.25,
        restitution: 0.75,
        rolling_resistance: Some(0.1),
        thickness: 0.02,
        self_contact: Some(false),
        ignored: vec!["ball.2".to_owned()],
        soft_only: false,
    };
    assert_eq!(body.touching, touching);
    let pin = &body.pins[0];
    assert_eq!(pin.selection, Selection::Box { min: [0.0; 3], max: [1.0; 3] });
    assert_eq!((pin.window.start, pin.window.end), (0.0, 2.0));
    let key = |time, value| CurveKey { time, value };
    assert_eq!(body.pins[1].selection, Selection::Group("Skin".to_owned()));
    let weight = Curve::new(vec![key(0.0, 0.5), key(1.0, 1.0)]).unwrap();
    assert_eq!(body.pins[1].goal, Some(Goal { weight, frequency: 8.0, damping_ratio: 0.0 }));
    assert_eq!((&body.pins[2].selection, &body.pins[2].goal), (&Selection::Vertices(vec![7, 1]), &None));
    assert_eq!(body.handles[0].goal, Some(Goal::from(0.7)));
    let wind = Wind { velocity: [1.0, 0.0, 2.0], drag: 0.5, gust: 0.3, turbulence: 0.1, seed: 9 };
    let windy = Field {
        strength: Curve::new(vec![key(0.0, 0.0), key(2.0, 1.5)]).unwrap(),
        bodies: vec!["ball.2".to_owned()],
        within: Some(Selection::Sphere { center: [0.0, 1.0, 0.0], radius: 4.0 }),
        ..Field::new(FieldLaw::Wind(wind))
    };
    let half = Selection::Plane { point: [0.0; 3], normal: [0.0, 1.0, 0.0] };
    let vortex = Vortex { center: [1.0, 0.0, 0.0], axis: [0.0, 0.0, 1.0], spin: 2.0, radius: 3.0, drag: 4.0 };
    let attract = Attraction { center: [0.0, 5.0, 0.0], acceleration: -2.0, radius: 0.5, power: 1.0 };
    let fields = [
        windy,
        Field::new(FieldLaw::Drag(0.25)),
        Field { within: Some(half), ..Field::new(FieldLaw::Gravity([0.0, 0.0, 1.0])) },
        Field::new(FieldLaw::Vortex(vortex)),
        Field::new(FieldLaw::Attract(attract)),
    ];
    assert_eq!(scene.fields, fields);
    let near = Selection::Sphere { center: [0.0, 1.0, 0.0], radius: 2.0 };
    let springs = Link {
        other: Some("ball.2".to_owned()),
        stiffness: Some(100.0),
        damping_ratio: 0.5,
        break_force: Some(20.0),
        ..Link::new("bust", near)
    };
    assert_eq!(scene.links, [springs, Link::new("ball.2", Selection::Group("top".to_owned()))]);
    let half_space = Selection::Plane { point: [0.0, 2.0, 0.0], normal: [0.0, 1.0, 0.0] };
    let grown = Zone::new(Selection::MeshVertices(vec![3, 5]), 1.0).inflated(0.75);
    assert_eq!(body.zones, [Zone::new(half_space, 0.5), grown]);
    let keys = vec![CurveKey { time: 0.0, value: 1.0 }, CurveKey { time: 2.5, value: 1.3 }];
    assert_eq!(body.inflate, Curve::new(keys).unwrap().interpolated(Interpolation::Smooth));
    let handle = &body.handles[0];
    assert_eq!((handle.window.start, handle.window.end, handle.keys.len()), (0.5, f64::INFINITY, 2));
    assert_eq!(handle.keys[1].rotate, [0.0, 720.0, 0.0]);

    let ball = &scene.bodies[1];
    assert_eq!(
        (ball.resolution, ball.material.elasticity),
        (Resolution::Vertices(1000), Elasticity::Preset(Preset::Flesh))
    );
    assert_eq!((ball.material.damping, ball.material.region_damping), (None, RegionDamping::PerStep(0.0)));
    assert!(matches!(scene.colliders[2].shape, ColliderShape::Capsule { radius: 0.25, .. }));
    assert_eq!(ball.touching, TouchingOptions::default());
    assert_eq!((scene.colliders[0].friction, scene.colliders[1].restitution), (0.5, 0.9));
    let rolling_resistance = scene.colliders.iter().map(|collider| collider.rolling_resistance);
    assert_eq!(rolling_resistance.collect::<Vec<_>>(), [None, Some(0.2), None]);
    let thickness = scene.colliders.iter().map(|collider| collider.thickness);
    assert_eq!(thickness.collect::<Vec<_>>(), [0.0, 0.01, 0.0]);
}

#[test]
fn a_written_scene_reads_back_the_same() {
    let scene = parse(FULL).unwrap();
    assert_eq!(parse(&scene.to_toml()).unwrap(), scene);
    for lines in [
        "material = \"jelly\"",
        "material = \"flesh\"\ndamping_ratio = 0",
        "material = \"rubber\"",
        "material = \"firm\"\ndamping_rate = 0.1",
        "youngs_modulus = 2.5e6",
        "youngs_modulus = 12\ndamping_ratio = 1\nregion_damping = 0.25",
        "half_width = 3",
        "stiffness_radius = 0.3\nfrequency = 7",
        "stiffness = 0.5\ndamping_rate = 3",
        "inflate = 1.5",
        "inflate = [{ time = 0, value = 0.5 }, { time = 1, value = 2 }]",
        "rolling_resistance = 0.1\npoisson_ratio = 0.2",
        "youngs_modulus = [{ time = 0, value = 1e5 }, { time = 1, value = 2e4 }]",
        "youngs_modulus = { keys = [{ time = 0, value = 1e5 }, { time = 1, value = 2e4 }], interpolation = \"smooth\" }",
        "poisson_ratio = [{ time = 0, value = 0 }, { time = 1, value = 0.4 }]\nfriction = 0.2",
        "damping_ratio = [{ time = 0, value = 0 }, { time = 1, value = 0.4 }]",
        "friction = [{ time = 0, value = 1 }, { time = 1, value = 0 }]",
        "[[body.zone]]\nmap = \"red\"\ndensity_factor = 2.5",
        "[[body.zone]]\nmap = [0.0, 0.5]\nstrength_factor = 0.5",
        "[[body.zone]]\nmap = [0.0, 0.5]\ndamping_factor = 0.5\nfriction_factor = 3.0\nyield_factor = 2.0",
        "[[collider]]\nsphere = { center = [0, 0, 0], radius = 1 }\nenabled = false",
        "[[collider]]\nsphere = { center = [0, 0, 0], radius = 1 }\nenabled = [{ time = 1, value = false }, { time = 2, value = true }]",
        "[simulation]\ngravity = [{ time = 0, value = [0, -1, 0] }, { time = 1.5, value = [2, 0, 0] }]",
        "[simulation]\ngravity = { keys = [{ time = 0, value = [0, -1, 0] }, { time = 1, value = [0, 0, 0] }], interpolation = \"cubic\" }",
    ] {
        let scene = parse(&format!("{SMALL}{lines}\n")).unwrap();
        let written = scene.to_toml();
        assert_eq!(parse(&written).unwrap(), scene, "{written}");
        for line in lines.lines().filter(|line| line.contains(" = ")) {
            let key = line.split(' ').next().unwrap();
            assert!(written.contains(&format!("{key} = ")), "{key} is missing: {written}");
        }
    }
    let quoted = parse_with(SMALL, &["body.bust.mesh=\"a \\\"b\\\" \\\\ c.obj\""]).unwrap();
    assert_eq!(parse(&quoted.to_toml()).unwrap(), quoted);
}

#[test]
fn keyframes_of_gravity_and_of_colliders_are_read_and_their_errors_name_the_key() {
    let scene = parse(&format!(
        "[simulation]\ngravity = [{{ time = 1, value = [0, -1, 0] }}, {{ time = 2, value = [0, 3, 0.5] }}]\n{SMALL}\
         [[collider]]\nplane = {{ point = [0, 0, 0], normal = [0, 1, 0] }}\nenabled = [{{ time = 1, value = false }}]\n"
    ))
    .unwrap();
    assert_eq!(
        [0.0, 1.5].map(|time| scene.simulation.gravity.value(time)),
        [[0.0, -1.0, 0.0], [0.0, 1.0, 0.25]]
    );
    let enabled = &scene.colliders[0].enabled;
    assert_eq!([0.0, 0.9, 1.0, 5.0].map(|time| enabled.value(time)), [true, true, false, false]);
    assert!(parse(FULL).unwrap().colliders.iter().all(|collider| collider.enabled.is_always_on()));

    for (value, words) in [
        (
            "1",
            "`simulation.gravity` must be a list of three numbers, or keyframes with `time` and `value`, not 1",
        ),
        ("[0, -1]", "`simulation.gravity` must be a list of three numbers"),
        ("[]", "`simulation.gravity` must be a list of three numbers"),
        ("[0, { time = 1, value = [0, 0, 0] }]", "`simulation.gravity` must be a list of three numbers"),
        ("[0, inf, 0]", "`simulation.gravity.1` is inf; it must be a finite number"),
        ("[0, \"a\", 0]", "`simulation.gravity.1` must be a number, or a keyframe with `time` and `value`"),
        ("[{ time = 1 }]", "`simulation.gravity.0.value` is missing"),
        ("[{ time = 1, value = 2 }]", "`simulation.gravity.0.value` must be a list of three numbers, not 2"),
        ("[{ time = 1, value = [0, 0, 0] }, { time = 1, value = [0, 0, 0] }]", "not after key 0 at 1"),
    ] {
        let error = parse(&format!("[simulation]\ngravity = {value}\n{SMALL}")).unwrap_err().to_string();
        assert!(error.starts_with("scene.toml:2: ") && error.contains(words), "{error}");
    }
    for (value, words) in [
        (
            "1",
            "`collider.0.enabled` must be true, false, or a list of keyframes with `time` and `value`, not 1",
        ),
        (
            "[]",
            "`collider.0.enabled` is []; it must be a list of keyframes in the order of time: there are no keys",
        ),
        ("[{ time = 1, value = 1 }]", "`collider.0.enabled.0.value` must be true or false, not 1"),
        ("[{ time = 1 }]", "`collider.0.enabled.0.value` is missing"),
        ("[{ time = 2, value = true }, { time = 1, value = true }]", "not after key 0 at 2"),
    ] {
        let plane = "plane = { point = [0, 0, 0], normal = [0, 1, 0] }";
        let error =
            parse(&format!("{SMALL}[[collider]]\n{plane}\nenabled = {value}\n")).unwrap_err().to_string();
        assert!(error.starts_with("scene.toml:6: ") && error.contains(words), "{error}");
    }
}

#[test]
fn a_file_of_vertices_takes_the_place_of_the_list() {
    let folder = tempfile::tempdir().unwrap();
    let write = |text: &str| std::fs::write(folder.path().join("rim.txt"), text).unwrap();
    let read = |part: &str| {
        let text = format!("{SMALL}{part}\n");
        Scene::parse(&text, "scene.toml", folder.path(), &[])
    };
    let pin = "[[body.pin]]\nvertices_file = \"rim.txt\"";
    write("# rim\n 3\n\n7 # and this\r\n0\n");
    let expected = Selection::MeshVertices(vec![3, 7, 0]);
    assert_eq!(read(pin).unwrap().bodies[0].pins[0].selection, expected);
    let scene = read("[[body.zone]]\nfactor = 2\nvertices_file = \"rim.txt\"").unwrap();
    assert_eq!(scene.bodies[0].zones[0].selection, expected);
    let scene = read("[[body.handle]]\nkeys = [{ time = 0 }]\nvertices_file = \"rim.txt\"").unwrap();
    assert_eq!(scene.bodies[0].handles[0].selection, expected);
    let scene = read("[[link]]\nbody = \"bust\"\nvertices_file = \"rim.txt\"").unwrap();
    assert_eq!(scene.links[0].selection, expected);
    // It is written as a list.
    assert!(scene.to_toml().contains("vertices = [3, 7, 0]"));

    let rim = folder.path().join("rim.txt").display().to_string();
    for (text, words) in [
        (
            "1\ntwo\n",
            format!(
                "{rim}:2: \"two\" is no index of a mesh vertex; write one whole number from 0 in each line"
            ),
        ),
        ("1\n2 3\n", format!("{rim}:2: \"2 3\" is no index")),
        ("1.5\n", format!("{rim}:1: \"1.5\" is no index")),
        (
            "0\n\n-4\n",
            format!(
                "{rim}:3: `body.bust.pin.0.vertices.1` is -4; it must be a whole number from 0 to 4294967295"
            ),
        ),
        (
            "5000000000\n",
            format!("{rim}:1: `body.bust.pin.0.vertices.0` is 5000000000; it must be a whole number"),
        ),
        ("# none\n", format!("{rim}:1: the file has no vertices; write one index in each line")),
        ("\u{1b}[2J\n", "is no index of a mesh vertex".to_owned()),
    ] {
        write(text);
        let error = read(pin).unwrap_err().to_string();
        assert!(error.contains(&words) && !error.contains('\u{1b}'), "{error}");
    }
    for (part, words) in [
        ("vertices_file = \"none.txt\"", "scene.toml:5: `body.0.pin.0.vertices_file`: cannot read "),
        (
            "vertices_file = 3",
            "scene.toml:5: `body.0.pin.0.vertices_file` must be the path of a text file, in quotes, not 3",
        ),
        ("vertices_file = \"C:\\temp\"", "a path without control characters"),
        (
            "vertices_file = \"rim.txt\"\nvertices = [1]",
            "`body.0.pin.0.vertices_file` and `vertices` exclude each other",
        ),
        ("vertices_file = \"rim.txt\"\nlattice = [1]", "exclude each other"),
    ] {
        write("1\n");
        let error = read(&format!("[[body.pin]]\n{part}")).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }

    // The number of vertices of the mesh is known when the scene is prepared. A checkpoint has the vertices.
    std::fs::write(folder.path().join("bust.obj"), super::run_files::BLOCK).unwrap();
    write("0\n7\n\n8 # one too many\n");
    let error = supple_io::run::prepare(&read(pin).unwrap()).unwrap_err().to_string();
    assert_eq!(
        error,
        format!("{rim}:4: body.bust.pin.0: vertex 8 is out of range: the mesh has 8 vertices, 0 to 7")
    );
    let link = "[[link]]\nbody = \"bust\"\nvertices_file = \"rim.txt\"";
    let error = supple_io::run::prepare(&read(link).unwrap()).unwrap_err().to_string();
    assert_eq!(error, format!("{rim}:4: link.0: vertex 8 is out of range: the mesh has 8 vertices, 0 to 7"));
    let fingerprint = |text: &str| {
        write(text);
        supple_io::run::fingerprint(&read(pin).unwrap()).unwrap()
    };
    assert_eq!(fingerprint("0\n7\n"), fingerprint("# the same\n0\n7\n"));
    assert_ne!(fingerprint("0\n7\n"), fingerprint("0\n6\n"));
}

/// Keyframes set the greatest value as the number of the material, by which regions and steps are chosen.
#[test]
fn keyframes_of_the_material_are_read_beside_its_numbers() {
    let keys = |values: [f64; 2]| {
        let keys = values.into_iter().zip([0.0, 2.0]).map(|(value, time)| CurveKey { time, value });
        Some(Curve::new(keys.collect()).unwrap())
    };
    let scene = parse(&format!(
        "{SMALL}youngs_modulus = [{{ time = 0, value = 2e4 }}, {{ time = 2, value = 1e5 }}]\n\
         damping_ratio = 0.3\nfriction = [{{ time = 0, value = 1 }}, {{ time = 2, value = 0 }}]\n"
    ));
    let body = &scene.unwrap().bodies[0];
    assert_eq!(body.material.elasticity, Elasticity::YoungsModulus(1e5));
    assert_eq!(body.material.damping, Some(Damping::Ratio(0.3)));
    assert_eq!(body.touching.friction, 1.0);
    let expected = KeyedMaterial {
        youngs_modulus: keys([2e4, 1e5]),
        friction: keys([1.0, 0.0]),
        ..KeyedMaterial::default()
    };
    assert_eq!(body.keyed, expected);
    // A factor of 1 is a factor.
    let zone = parse(&format!("{SMALL}[[body.zone]]\nvertices = [0]\ndensity_factor = 1\n")).unwrap();
    assert_eq!(zone.bodies[0].zones, [Zone::new(Selection::MeshVertices(vec![0]), 1.0)]);
    let constant = parse(&format!("{SMALL}youngs_modulus = [{{ time = 0, value = 5 }}]\n")).unwrap();
    assert!(constant.bodies[0].keyed.is_empty());
}

#[test]
fn the_keys_of_the_material_set_elasticity_and_damping() {
    let material = |lines: &str| parse(&format!("{SMALL}{lines}\n")).unwrap().bodies[0].material;
    assert_eq!(material(""), Material::default());
    for (name, preset) in Preset::NAMED {
        let expected = Material { elasticity: Elasticity::Preset(preset), ..Material::default() };
        assert_eq!(material(&format!("material = \"{name}\"")), expected);
    }
    assert_eq!(material("youngs_modulus = 2e6").elasticity, Elasticity::YoungsModulus(2e6));
    // The default of a region key that is left out is that of the paper.
    assert_eq!(material("half_width = 2").elasticity, Elasticity::REGIONS);
    assert_eq!(material("stiffness = 1").elasticity, Elasticity::REGIONS);
    let radius = RegionSize::Radius(0.5);
    assert_eq!(
        material("stiffness_radius = 0.5\nstiffness = 0.25").elasticity,
        Elasticity::Regions { size: radius, stiffness: Stiffness::PerStep(0.25) }
    );
    assert_eq!(material("damping_ratio = 0").damping, Some(Damping::Ratio(0.0)));
    assert_eq!(material("damping_rate = 4").damping, Some(Damping::Rate(4.0)));
    assert_eq!(
        material("half_width = 2\ndamping_ratio = 0"),
        Material::fast_lsm(),
        "the material of the paper in keys of a scene"
    );
}

#[test]
fn unknown_keys_are_errors_with_the_nearest_known_key() {
    for (text, line, key, nearest) in [
        (format!("{SMALL}half_widht = 3\n"), 4, "body.bust.half_widht", "half_width"),
        ("[simulatoin]\nframes = 3\n".to_owned(), 1, "simulatoin", "simulation"),
        (
            format!("{SMALL}[[body.pin]]\nbox = {{ min = [0,0,0], mx = [1,1,1] }}\n"),
            5,
            "body.bust.pin.0.box.mx",
            "max",
        ),
    ] {
        let expected = format!("scene.toml:{line}: unknown key `{key}`; the nearest one is `{nearest}`");
        assert_eq!(parse(&text).unwrap_err().to_string(), expected);
    }
}

#[test]
fn values_out_of_range_are_errors_with_the_value_and_the_range() {
    for (text, line, key, value, range) in [
        ("stiffness = 0", 4, "stiffness", "0", "in (0, 1]"),
        ("stiffness = 1.5", 4, "stiffness", "1.5", "in (0, 1]"),
        ("region_damping = -0.1", 4, "region_damping", "-0.1", "in [0, 1]"),
        ("region_damping_rate = -1", 4, "region_damping_rate", "-1", "a rate in 1/s, >= 0"),
        ("damping_ratio = 1.5", 4, "damping_ratio", "1.5", "in [0, 1]"),
        ("damping_ratio = -0.1", 4, "damping_ratio", "-0.1", "in [0, 1]"),
        ("damping_rate = -1", 4, "damping_rate", "-1", "a rate in 1/s, >= 0"),
        ("youngs_modulus = 0", 4, "youngs_modulus", "0", "a force per area > 0"),
        ("youngs_modulus = -1e6", 4, "youngs_modulus", "-1000000", "a force per area > 0"),
        ("frequency = 0", 4, "frequency", "0", "a frequency in Hz, > 0"),
        ("frequency = nan", 4, "frequency", "NaN", "a frequency in Hz, > 0"),
        (
            "scale = inf",
            4,
            "scale",
            "inf",
            "a number above 0, or three numbers that are not 0, of which negative ones mirror the mesh",
        ),
        ("friction = -0.1", 4, "friction", "-0.1", "a number of at least 0"),
        ("thickness = -0.1", 4, "thickness", "-0.1", "a number of at least 0"),
        ("restitution = 1.1", 4, "restitution", "1.1", "in [0, 1]"),
        ("density = 0", 4, "density", "0", "a number above 0"),
        ("plastic = { yield = 0 }", 4, "plastic.yield", "0", "in (0, 1]"),
        ("plastic = { creep = -1 }", 4, "plastic.creep", "-1", "a rate in 1/s, > 0"),
        ("[body.plastic]\nmax = 2.5", 5, "plastic.max", "2.5", "in (0, 2]"),
        ("fracture = { strain = 0 }", 4, "fracture.strain", "0", "a number above 0"),
        ("fracture = { strength = -1 }", 4, "fracture.strength", "-1", "a number above 0"),
        ("fracture = { strain = 1, rotation = 0 }", 4, "fracture.rotation", "0", "in (0, 180] degrees"),
        (
            "fracture = { strain = 1, cracks = 0 }",
            4,
            "fracture.cracks",
            "0",
            "a whole number from 1 to 1000000",
        ),
        (
            "fracture = { strain = 1, seed = -1 }",
            4,
            "fracture.seed",
            "-1",
            "a whole number from 0 to 4294967295",
        ),
        (
            "fracture = { strain = 1, surface = 'rough' }",
            4,
            "fracture.surface",
            "the string \"rough\"",
            "one of \"smooth\", \"cells\"",
        ),
        ("[body.fracture]\nstrain = 1\nnoise = 0.6", 6, "fracture.noise", "0.6", "in [0, 0.5]"),
        ("cell_size = 0.0", 4, "cell_size", "0", "a number above 0"),
        ("lattice_vertices = 7", 4, "lattice_vertices", "7", "a whole number from 8 to 2000000000"),
        ("half_width = 0", 4, "half_width", "0", "0.5 or a whole number of cells, at least 1"),
        ("half_width = 2.5", 4, "half_width", "2.5", "0.5 or a whole number of cells, at least 1"),
        ("stiffness_radius = 0", 4, "stiffness_radius", "0", "a length > 0"),
        ("rotate = [0, nan, 0]", 4, "rotate.1", "NaN", "a finite number"),
        ("volume = { max_correction = -1 }", 4, "volume.max_correction", "-1", "a number of at least 0"),
        (
            "[[body.pin]]\nplane = { point = [0,0,0], normal = [0,0,0] }",
            5,
            "pin.0.plane.normal",
            "[0, 0, 0]",
            "a vector that is not zero",
        ),
        (
            "[[body.pin]]\nbox = { min = [1,0,0], max = [0,1,1] }",
            5,
            "pin.0.box.max",
            "[0, 1, 1]",
            "at least `min`, which is [1, 0, 0], on every axis",
        ),
        (
            "[[body.zone]]\nbox = { min = [1,0,0], max = [0,1,1] }\nfactor = 1",
            5,
            "zone.0.box.max",
            "[0, 1, 1]",
            "at least `min`, which is [1, 0, 0], on every axis",
        ),
        ("[[body.pin]]\nvertices = [0]\nweight = 0", 6, "pin.0.weight", "0", "in (0, 1]"),
        ("[[body.pin]]\nvertices = [0]\ngoal_damping = 2", 6, "pin.0.goal_damping", "2", "in [0, 1]"),
        ("[[body.zone]]\nvertices = [0]\ninflate = 11", 6, "zone.0.inflate", "11", "in [0.1, 10]"),
        (
            "inflate = [{ time = 0, value = 1 }, { time = 1, value = 11 }]",
            4,
            "inflate.1.value",
            "11",
            "in [0.1, 10]",
        ),
        (
            "inflate = [{ time = 1, value = 1 }, { time = 0, value = 1 }]",
            4,
            "inflate",
            "a list of 2 values",
            "a list of keyframes in the order of time: key 1 is at time 0, which is not after key 0 at 1; sort the keys by time",
        ),
        (
            "youngs_modulus = [{ time = 0, value = 1e5 }, { time = 1, value = 0 }]",
            4,
            "youngs_modulus.1.value",
            "0",
            "a force per area > 0",
        ),
        (
            "poisson_ratio = [{ time = 0, value = 0 }, { time = 1, value = 0.5 }]",
            4,
            "poisson_ratio.1.value",
            "0.5",
            "in [0, 0.47]",
        ),
        ("[[body.zone]]\nmap = \"red\"\ndensity_factor = 0", 6, "zone.0.density_factor", "0", "in (0, 100]"),
        ("[[body.zone]]\nvertices = [0]\nyield_factor = 101", 6, "zone.0.yield_factor", "101", "in (0, 100]"),
        ("[[body.zone]]\nvertices = [0]\nfactor = 0", 6, "zone.0.factor", "0", "in (0, 100]"),
        ("[[body.zone]]\nvertices = [0]\nfactor = 101", 6, "zone.0.factor", "101", "in (0, 100]"),
        (
            "[[body.pin]]\nsphere = { center = [0,0,0], radius = 1 }\nstart = 2\nend = 1",
            7,
            "pin.0.end",
            "1",
            "a number above 2",
        ),
    ] {
        let expected = format!("scene.toml:{line}: `body.bust.{key}` is {value}; it must be {range}");
        assert_eq!(refusal(text), expected);
    }
    assert_eq!(
        refusal("material = \"wood\""),
        "scene.toml:4: `body.bust.material` is the string \"wood\"; it must be one of \"jelly\", \"flesh\", \
         \"rubber\", \"firm\""
    );
    let message = refusal("volume = \"mehs\"");
    assert!(message.contains("\"mehs\"; it must be one of \"auto\", \"off\", \"lattice\""), "{message}");
    for (text, key, value, range) in [
        ("[simulation]\nfps = 0\n", "simulation.fps", "0", "frames per second, > 0"),
        (
            "[simulation]\nsubsteps = 0\n",
            "simulation.substeps",
            "0",
            "\"auto\" or a whole number from 1 to 100000",
        ),
        (
            "[simulation]\nsubsteps = \"all\"\n",
            "simulation.substeps",
            "\"all\"",
            "\"auto\" or a whole number from 1 to 100000",
        ),
        ("[simulation]\nframes = -1\n", "simulation.frames", "-1", "a whole number from 0 to 10000000"),
        (
            "[output]\nformat = \"abc\"\n",
            "output.format",
            "\"abc\"",
            "one of \"obj\", \"ply\", \"pc2\", \"usd\", \"usdz\", \"html\", \"glb\", \"vat\", \"vtu\", \"lattice\", \"film\", \"gif\"",
        ),
        ("[output]\nup = \"x\"\n", "output.up", "\"x\"", "one of \"y\", \"z\""),
        ("[output]\nscale = 0\n", "output.scale", "0", "a number above 0"),
        ("[output]\nfps = -25\n", "output.fps", "-25", "a number above 0"),
        ("[output]\nmeters_per_unit = inf\n", "output.meters_per_unit", "inf", "a number above 0"),
    ] {
        let message = parse(&format!("{text}{SMALL}")).unwrap_err().to_string();
        assert!(message.starts_with(&format!("scene.toml:2: `{key}` is ")), "{message}");
        assert!(message.ends_with(&format!("{value}; it must be {range}")), "{message}");
    }
}

#[test]
fn values_of_the_wrong_type_are_errors_with_the_expected_type() {
    for (text, key, expected, found) in [
        ("stiffness = \"hard\"", "stiffness", "a number", "\"hard\""),
        ("join = 1", "join", "true or false", "1"),
        ("self_contact = 1", "self_contact", "true or false", "1"),
        ("ignore = \"eyes\"", "ignore", "a list of names of bodies", "\"eyes\""),
        ("ignore = [3]", "ignore.0", "a string in quotes", "3"),
        ("material = 3", "material", "in quotes", "3"),
        ("youngs_modulus = \"soft\"", "youngs_modulus", "a number", "\"soft\""),
        ("rotate = [0, 1]", "rotate", "three numbers", "[0, 1]"),
        ("object = 3", "object", "in quotes", "3"),
        ("lattice_vertices = 99.5", "lattice_vertices", "a whole number", "99.5"),
        ("scale = \"big\"", "scale", "a number above 0", "\"big\""),
        ("inflate = \"much\"", "inflate", "a list of keyframes", "\"much\""),
        ("inflate = [1, 2]", "inflate.0", "a table", "1"),
        ("volume = 1", "volume", "keys like `measure`", "1"),
        (
            "[body.pin]\nbox = { min = [0,0,0], max = [1,1,1] }",
            "pin",
            "[[body.pin]] in double brackets",
            "one table",
        ),
        (
            "[[body.handle]]\nbox = { min = [0,0,0], max = [1,1,1] }\nkeys = 3",
            "handle.0.keys",
            "a list of keyframes",
            "3",
        ),
    ] {
        let message = refusal(text);
        assert!(message.contains(&format!(": `body.bust.{key}` must be ")), "{message}");
        assert!(message.contains(expected) && message.ends_with(found), "{message}");
    }
}

#[test]
fn sleep_is_true_or_false() {
    let sleep = |value: &str| parse(&format!("[simulation]\nsleep = {value}\n{SMALL}"));
    assert!(parse(SMALL).unwrap().simulation.sleep && sleep("true").unwrap().simulation.sleep);
    let awake = sleep("false").unwrap();
    assert!(!awake.simulation.sleep && !parse(&awake.to_toml()).unwrap().simulation.sleep);
    let message = sleep("1").unwrap_err().to_string();
    assert_eq!(message, "scene.toml:2: `simulation.sleep` must be true or false, not 1");
}

#[test]
fn contact_is_between_bodies_by_default_and_not_of_a_body_with_itself() {
    let settings = |text: &str| {
        let scene = parse(&format!("[simulation]\n{text}\n{SMALL}")).unwrap();
        let again = parse(&scene.to_toml()).unwrap();
        assert_eq!(again, scene);
        (scene.simulation.contact, scene.simulation.self_contact)
    };
    assert_eq!(settings(""), (true, false));
    assert_eq!(settings("contact = false\nself_contact = true"), (false, true));
    let message = parse(&format!("[simulation]\ncontact = 1\n{SMALL}")).unwrap_err().to_string();
    assert_eq!(message, "scene.toml:2: `simulation.contact` must be true or false, not 1");
    // The setting of a body that is left out is not written, because the simulation decides.
    assert_eq!(parse(SMALL).unwrap().to_toml().matches("self_contact = ").count(), 1);
}

#[test]
fn ignored_bodies_must_be_other_bodies_of_the_scene() {
    let other = "[[body]]\nname = \"eyes\"\nmesh = \"eyes.obj\"\n";
    let ignoring = |name: &str| format!("{SMALL}ignore = [\"{name}\"]\n{other}");
    assert_eq!(parse(&ignoring("eyes")).unwrap().bodies[0].touching.ignored, ["eyes"]);
    assert_eq!(
        parse(&ignoring("eyse")).unwrap_err().to_string(),
        "scene.toml:4: `body.bust.ignore.0` is \"eyse\", and no body has this name; the nearest name of another body is \
         `eyes`"
    );
    assert_eq!(
        parse(&ignoring("bust")).unwrap_err().to_string(),
        "scene.toml:4: `body.bust.ignore.0` is \"bust\", the body itself, whose contact with itself is `self_contact`; \
         the nearest name of another body is `eyes`"
    );
    assert_eq!(
        refusal("ignore = [\"eyes\"]"),
        "scene.toml:4: `body.bust.ignore.0` is \"eyes\", and no body has this name; the scene has no other body; \
         leave it out"
    );
    // A name that follows from the mesh counts, and an override is checked as the file is.
    let unnamed = format!("{SMALL}[[body]]\nmesh = \"tongue.obj\"\n");
    assert!(parse_with(&unnamed, &["body.bust.ignore=[\"tongue\"]"]).is_ok());
    let message = parse_with(&unnamed, &["body.bust.ignore=[\"tong\"]"]).unwrap_err().to_string();
    assert!(message.starts_with("--set body.bust.ignore=") && message.ends_with("is `tongue`"), "{message}");
}

#[test]
fn every_key_of_the_table_is_known_to_the_body_reader() {
    // No key accepts a date.
    for key in body_keys().iter().filter(|key| !["name", "mesh"].contains(&key.as_str())) {
        let message = refusal(&format!("{key} = 1979-05-27"));
        assert!(message.contains(&format!("scene.toml:4: `body.bust.{key}` must be")), "{message}");
    }
}

#[test]
fn mutually_exclusive_keys_are_errors_that_name_both() {
    for (line, first, second) in [
        ("half_width = 2\nstiffness_radius = 0.1", "half_width", "stiffness_radius"),
        ("stiffness = 1\nfrequency = 3", "stiffness", "frequency"),
        ("damping_ratio = 0.1\ndamping_rate = 3", "damping_ratio", "damping_rate"),
        ("region_damping = 0\nregion_damping_rate = 3", "region_damping", "region_damping_rate"),
        ("lattice_vertices = 100\ncell_size = 0.1", "lattice_vertices", "cell_size"),
        ("rigid = true\nmaterial = \"flesh\"", "rigid", "material"),
        ("rigid = true\nyoungs_modulus = 1e5", "rigid", "youngs_modulus"),
        ("damping_rate = 1\nrigid = true", "rigid", "damping_rate"),
        ("rigid = true\nfracture = { strain = 0.1 }", "rigid", "fracture"),
        ("rigid = true\nvolume = \"mesh\"", "rigid", "volume"),
        ("rigid = true\n[[body.zone]]\nvertices = [3]\nfactor = 2", "rigid", "zone"),
        (
            "[[body.pin]]\nbox = { min = [0,0,0], max = [1,1,1] }\nsphere = { center = [0,0,0], radius = 1 }",
            "box",
            "sphere",
        ),
    ] {
        let message = refusal(line);
        assert!(message.contains(&format!("{second}` and `{first}` ")), "{message}");
        assert!(message.ends_with("; leave one of them out"), "{message}");
    }
}

#[test]
fn a_rigid_body_has_keys_and_defaults_of_its_own() {
    let scene = parse(&format!("{SMALL}rigid = true\ndensity = 300\nvolume = \"off\"\n")).unwrap();
    assert!(scene.bodies[0].rigid);
    assert_eq!(scene.bodies[0].resolution, Resolution::Vertices(300));
    let written = scene.to_toml();
    assert!(!written.contains("\nmaterial") && written.contains("rigid = true"), "{written}");
    assert_eq!(parse(&written).unwrap(), scene);
    let given = parse(&format!("{SMALL}rigid = true\nlattice_vertices = 1000\n")).unwrap();
    assert_eq!(given.bodies[0].resolution, Resolution::Vertices(1000));
    let soft = parse(&format!("{SMALL}rigid = false\nmaterial = \"jelly\"\n")).unwrap();
    assert!(!soft.bodies[0].rigid);
    assert_eq!(soft.bodies[0].resolution, Resolution::Vertices(1000));
}

#[test]
fn the_three_ways_to_set_the_elasticity_are_mutually_exclusive() {
    let ways = [
        &["material = \"jelly\""][..],
        &["youngs_modulus = 1e6"],
        &["half_width = 2", "stiffness_radius = 0.1", "stiffness = 1", "frequency = 3"],
    ];
    let key = |line: &str| line.split(' ').next().unwrap().to_owned();
    for (a, b) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
        for (first, second) in
            ways[a].iter().flat_map(|first| ways[b].iter().map(move |second| (first, second)))
        {
            let message = refusal(&format!("{first}\n{second}"));
            let keys = [key(first), key(second)];
            assert!(keys.iter().all(|key| message.contains(&format!("{key}`"))), "{message}");
            let line = 4 + usize::from(a < b);
            assert!(message.starts_with(&format!("scene.toml:{line}: ")), "{message}");
            assert!(message.ends_with(" exclude each other; leave one of them out"), "{message}");
            assert!(exclusive_keys(&keys[0]).contains(&keys[1].as_str()), "{keys:?}");
        }
    }
    let sizes = ["stiffness_radius"];
    assert_eq!(exclusive_keys("half_width").iter().filter(|key| sizes.contains(key)).count(), 1);
    assert!(!exclusive_keys("half_width").contains(&"stiffness") && exclusive_keys("density").is_empty());
}

#[test]
fn bodies_need_a_mesh_and_unique_valid_names() {
    let message = parse("[[body]]\nname = \"a\"\n").unwrap_err().to_string();
    assert!(
        message.contains(
            "scene.toml:1: `body.a.mesh` is missing: the path of a model (OBJ, GLB, glTF, STL, PLY)"
        ),
        "{message}"
    );
    let message = parse("[simulation]\n").unwrap_err().to_string();
    assert!(
        message.contains("`body` is missing: a scene needs at least one [[body]] with a `mesh`"),
        "{message}"
    );
    let message = parse(&format!("{SMALL}{SMALL}")).unwrap_err().to_string();
    assert!(
        message.starts_with("scene.toml:4: a second body is called `bust`; names must differ"),
        "{message}"
    );
    for name in ["", "a b", "a/b", "ä!"] {
        let text = format!("[[body]]\nname = \"{name}\"\nmesh = \"m.obj\"\n");
        let message = parse(&text).unwrap_err().to_string();
        assert!(message.starts_with("scene.toml:2: `body.0.name` is "), "{message}");
        let expected = format!("{name:?}; it must be made of letters, digits, `-`, `_` and `.` only");
        assert!(message.contains(&expected), "{message}");
    }
    assert_eq!(parse("[[body]]\nmesh = \"a/red ball.obj\"\n").unwrap().bodies[0].name, "red_ball");
}

#[test]
fn key_times_must_increase() {
    let handle = |keys: &str| {
        refusal(&format!("[[body.handle]]\nsphere = {{ center = [0,0,0], radius = 1 }}\nkeys = {keys}"))
    };
    assert!(
        handle("[{ time = 1 }, { time = 1 }]").contains("keys.1.time` is 1; it must be a number above 1")
    );
    assert!(handle("[]").contains("at least one keyframe"));
    assert!(handle("[{ translate = [0,0,0] }]").contains("keys.0.time` is missing"));
}

#[test]
fn invalid_toml_and_unreadable_files_are_errors_with_the_line_or_the_path() {
    let message = parse("[simulation]\nframes = \n").unwrap_err().to_string();
    assert!(message.starts_with("scene.toml:2: not valid TOML"), "{message}");
    let message = parse("[simulation]\nframes = 99999999999999999999\n").unwrap_err().to_string();
    assert_eq!(message, "scene.toml:2: the number 99999999999999999999 does not fit in 64 bits");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("latin.toml");
    std::fs::write(&path, b"[simulation]\n# caf\xe9\n").unwrap();
    let message = Scene::read(&path).unwrap_err().to_string();
    assert!(message.ends_with("latin.toml:2: not valid TOML: the text is not UTF-8"), "{message}");
    let message = Scene::read(folder.path().join("none.toml")).unwrap_err().to_string();
    assert!(message.contains("none.toml: cannot read the scene: "), "{message}");
}

#[test]
fn every_shipped_scene_is_read() {
    let folder = supple_tests::example("");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            let scene = Scene::read(&path).unwrap();
            assert!(
                scene.bodies.iter().all(|body| scene.resolve(&body.mesh).is_file()),
                "{}",
                path.display()
            );
            count += 1;
        }
    }
    assert!(count >= 5);
}

#[test]
fn plasticity_is_a_table_of_a_body() {
    let scene = parse(&format!("{SMALL}[body.plastic]\nyield = 0.02\n")).unwrap();
    let plastic = Plasticity { yield_strain: 0.02, ..Plasticity::default() };
    assert_eq!(scene.bodies[0].material.plastic, Some(plastic));
    assert_eq!(parse(&scene.to_toml()).unwrap(), scene);
    assert_eq!(parse(SMALL).unwrap().bodies[0].material.plastic, None);

    // An override creates the table.
    let name = &scene.bodies[0].name;
    let overrides = [format!("body.{name}.plastic.creep=20")];
    let scene = Scene::parse(SMALL, "scene.toml", Path::new(""), &overrides).unwrap();
    let plastic = Plasticity { creep: 20.0, ..Plasticity::default() };
    assert_eq!(scene.bodies[0].material.plastic, Some(plastic));

    let message = refusal("plastic = { yeild = 0.1 }");
    assert!(message.contains("plastic.yeild`") && message.contains("`yield`"), "{message}");
    let message = refusal("plastic = true");
    assert!(message.contains("plastic`") && message.contains("a table"), "{message}");
    let message = refusal("plastik = { yield = 0.1 }");
    assert!(message.contains("`plastic`"), "{message}");
}

#[test]
fn fracture_is_a_table_of_a_body() {
    let scene = parse(&format!("{SMALL}[body.fracture]\nstrength = 2e4\n")).unwrap();
    let name = scene.bodies[0].name.clone();
    let strength = FractureOptions::new(BreakLimit::Strength(2e4));
    assert_eq!(scene.bodies[0].fracture, Some(strength));
    assert_eq!(parse(&scene.to_toml()).unwrap(), scene);
    assert_eq!(parse(SMALL).unwrap().bodies[0].fracture, None);

    let all =
        "fracture = { strain = 0.15, rotation = 20, cracks = 3, noise = 0, seed = 9, surface = \"cells\" }";
    let scene = parse(&format!("{SMALL}{all}\n")).unwrap();
    let mut options = FractureOptions::new(BreakLimit::Strain(0.15));
    (options.rotation, options.cracks, options.noise, options.seed) = (Some(20.0), 3, 0.0, 9);
    options.surface = CutSurface::Cells;
    assert_eq!(scene.bodies[0].fracture, Some(options));
    assert_eq!(parse(&scene.to_toml()).unwrap(), scene);

    // An override creates the table, and one limit replaces the other.
    for text in [SMALL.to_owned(), format!("{SMALL}[body.fracture]\nstrength = 2e4\n")] {
        let overrides = [format!("body.{name}.fracture.strain=0.1")];
        let scene = Scene::parse(&text, "scene.toml", Path::new(""), &overrides).unwrap();
        assert_eq!(scene.bodies[0].fracture, Some(FractureOptions::new(BreakLimit::Strain(0.1))));
    }

    let message = refusal("fracture = { strain = 1, niose = 0.1 }");
    assert!(message.contains("fracture.niose`") && message.contains("`noise`"), "{message}");
    for text in ["fracture = { noise = 0.1 }", "fracture = { strain = 1, strength = 1 }"] {
        let message = refusal(text);
        assert!(message.contains("`strength`") && message.contains("strain`"), "{message}");
    }
    let message = refusal("fracture = 0.1");
    assert!(message.contains("fracture`") && message.contains("a table"), "{message}");
    let message = refusal("fractur = { strain = 1 }");
    assert!(message.contains("`fracture`"), "{message}");
}

#[test]
fn wrong_fields_are_errors_that_name_key_and_way_out() {
    let refused = |lines: &str| parse(&format!("{SMALL}[[field]]\n{lines}\n")).expect_err(lines).to_string();
    for (lines, part) in [
        ("drag = -1", "scene.toml:5: `field.0.drag` is -1; it must be a rate in 1/s, >= 0"),
        ("wind = { gust = 2 }", "`field.0.wind.gust` is 2; it must be in [0, 1]"),
        ("wind = { gusts = 1 }", "`gust`"),
        ("drag = 1\nwind = {}", "`field.0.drag` and `wind` exclude each other"),
        ("strength = 2", "`vortex`"),
        ("drag = 1\nbodies = [\"bush\"]", "\"bush\""),
        ("drag = 1\nbodies = \"bust\"", "a list of names of bodies"),
        ("drag = 1\nstrength = -2", "`field.0.strength` is -2"),
        ("drag = 1\nbox = { min = [1, 0, 0], max = [0, 1, 1] }", "at least `min`"),
        ("drag = 1\nvertices = [0]", "`field.0.vertices`; give one of `gravity`"),
    ] {
        let message = refused(lines);
        assert!(message.contains(part), "{lines}: {message}");
    }
}

#[test]
fn wrong_links_are_errors_that_name_key_and_way_out() {
    let refused = |lines: &str| parse(&format!("{SMALL}[[link]]\n{lines}\n")).expect_err(lines).to_string();
    let part = "sphere = { center = [0, 0, 0], radius = 1 }";
    for (lines, expected) in [
        (part.to_owned(), "`link.0.body`"),
        (format!("body = \"bush\"\n{part}"), "\"bush\""),
        (format!("body = \"bust\"\nother = \"bust\"\n{part}"), "`link.0.other`"),
        (format!("body = \"bust\"\nstiffness = 0\n{part}"), "`link.0.stiffness` is 0"),
        (format!("body = \"bust\"\nbreaks = 1\n{part}"), "`break`"),
        ("body = \"bust\"".to_owned(), "`group`"),
    ] {
        let message = refused(&lines);
        assert!(message.contains(expected), "{lines}: {message}");
    }
}
