//! Colliders that are meshes: solids and shells.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, BodyBuilder, Collider, ColliderFault, CollisionMesh, Key, Mesh, MeshAnimation, Preset, Shape,
    Simulation, SimulationState,
};

use supple_io::run::{difference, fingerprint, prepare};
use supple_io::scene::Scene;
use supple_tests::{mesh_of, plain_box, sphere};

/// Returns the mesh of a box with its center at the origin. Without its top it is open.
fn centered_box(extents: [f64; 3], has_top: bool) -> Mesh {
    let (vertices, mut faces) = plain_box(extents.map(|x| -x / 2.0), extents.map(|x| x / 2.0));
    if !has_top {
        faces.remove(3);
    }
    mesh_of((vertices, faces))
}

/// Returns a square in the plane y = 0.
fn square(half: f64) -> Mesh {
    let vertices = vec![[-half, 0.0, -half], [half, 0.0, -half], [half, 0.0, half], [-half, 0.0, half]];
    Mesh::new(vertices, &[[0, 1, 2, 3]]).unwrap()
}

fn placed(mesh: Mesh, scale: f64, rotate: [f64; 3], translate: [f64; 3]) -> Collider {
    Collider::new(Shape::Mesh { mesh: CollisionMesh::new(mesh).unwrap(), scale, rotate, translate })
}

/// Returns a body whose mesh is a ball.
fn ball_body() -> BodyBuilder {
    let (vertices, faces) = sphere([0.0; 3], 0.5, 8);
    Body::builder(Mesh::new(vertices, &faces).unwrap()).preset(Preset::Rubber).lattice_vertices(300)
}

fn simulation(body: BodyBuilder, colliders: &[Collider]) -> Simulation {
    let builder = Simulation::builder().body(body.build().unwrap()).dt(1.0 / 240.0).threads(1);
    colliders.iter().fold(builder, |builder, collider| builder.collider(collider.clone())).build().unwrap()
}

fn center(simulation: &Simulation) -> Vector3<f64> {
    let positions = simulation.body(0).positions();
    positions.iter().map(|p| p.coords).sum::<Vector3<f64>>() / positions.len() as f64
}

/// Points on a grid around the origin, none of which is at equal distance from two faces of a box.
fn points() -> impl Iterator<Item = [f64; 3]> {
    (0..1000).map(|k| [k % 10, k / 10 % 10, k / 100].map(|i| -2.0 + 0.401 * f64::from(i)))
}

#[test]
fn distances_of_a_box_mesh_are_those_of_a_box() {
    let (extents, rotate, translate) = ([1.0, 1.5, 0.7], [20.0, 30.0, -40.0], [0.3, -0.2, 0.1]);
    let half = extents.map(|x| x * 0.5 * 1.2);
    let solid = Collider::cuboid(translate, half, rotate);
    let mut flipped_faces: Vec<Vec<u32>> = centered_box(extents, true).faces().map(<[u32]>::to_vec).collect();
    flipped_faces.iter_mut().for_each(|face| face.reverse());
    let vertices = centered_box(extents, true).vertices().iter().map(|&p| p.into()).collect();
    let flipped = Mesh::new(vertices, &flipped_faces).unwrap();
    for mesh in [centered_box(extents, true), flipped] {
        let mesh = placed(mesh, 1.2, rotate, translate);
        for point in points() {
            let (a, b) = (mesh.shape.signed_distance(point), solid.shape.signed_distance(point));
            assert!((a.distance - b.distance).abs() < 1e-12, "{point:?}: {a:?} {b:?}");
            // Inside, two faces may be equally near up to rounding.
            assert!(a.distance < 0.0 || (a.normal - b.normal).norm() < 1e-9, "{point:?}: {a:?} {b:?}");
        }
    }
}

#[test]
fn distances_of_an_open_mesh_are_not_negative() {
    let sheet = Collider::mesh(square(1.0)).unwrap();
    for point in points() {
        let outside = [point[0], point[2]].map(|x| (x.abs() - 1.0).max(0.0));
        let expected = Vector3::new(outside[0], point[1], outside[1]);
        let found = sheet.shape.signed_distance(point);
        assert!((found.distance - expected.norm()).abs() < 1e-12, "{point:?}");
        let away = Vector3::new(outside[0].copysign(point[0]), point[1], outside[1].copysign(point[2]));
        assert!((found.normal - away.normalize()).norm() < 1e-9, "{point:?}: {found:?}");
    }
}

#[test]
fn invalid_meshes_and_numbers_are_errors() {
    let line = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let fault = Collider::mesh(Mesh::new(line, &[[0, 1, 2]]).unwrap()).unwrap_err();
    assert_eq!(fault, ColliderFault::NoArea { faces: 1 });
    for (scale, translate, name) in [(0.0, 0.0, "scale"), (-1.0, 0.0, "scale"), (1.0, f64::NAN, "translate")]
    {
        let fault = placed(square(1.0), scale, [0.0; 3], [0.0, translate, 0.0]).validate().unwrap_err();
        assert!(fault.to_string().starts_with(name), "{fault}");
    }
}

/// A body rests on a mesh as on the shape that the mesh has. The distance of a shell is 0.05 cells.
#[test]
fn a_body_rests_on_meshes_as_on_shapes() {
    let heights = [
        ("box", Collider::cuboid([0.0, -0.5, 0.0], [2.0, 0.5, 2.0], [0.0; 3])),
        ("solid", placed(centered_box([4.0, 1.0, 4.0], true), 1.0, [0.0; 3], [0.0, -0.5, 0.0])),
        ("sheet", Collider::mesh(square(2.0)).unwrap()),
        ("sheet from below", placed(square(1.0), 2.0, [180.0, 0.0, 0.0], [0.0; 3])),
    ]
    .map(|(name, collider)| {
        let mut simulation = simulation(ball_body().translate([0.1, 0.6, 0.1]), &[collider]);
        simulation.steps(720);
        (name, center(&simulation).y, simulation.body(0).lattice().cell_size())
    });
    let (_, expected, cell) = heights[0];
    for (name, height, _) in &heights[1..] {
        let shell = if name.contains("sheet") { 0.05 * cell } else { 0.0 };
        assert!((height - expected - shell).abs() < 0.01 * cell, "{name}: {height}, {expected}");
    }
}

#[test]
fn a_shell_has_two_sides() {
    // The lower body is pressed against the sheet from below, the upper one rests on it.
    for (y, gravity) in [(0.6, -9.81), (-0.6, 9.81)] {
        let body = ball_body().translate([0.1, y, 0.1]).build().unwrap();
        let sheet = Collider::mesh(square(2.0)).unwrap();
        let builder = Simulation::builder().body(body).collider(sheet).gravity([0.0, gravity, 0.0]);
        let mut simulation = builder.dt(1.0 / 240.0).build().unwrap();
        simulation.steps(480);
        let side = y.signum();
        let least = simulation.body(0).surface().positions.iter().map(|p| p.y * side).fold(9.0, f64::min);
        assert!(least > 0.0 && center(&simulation).y * side < 0.6, "{least}");
    }
}

#[test]
fn a_body_lies_in_an_open_box_and_in_a_solid_bowl() {
    let tray = centered_box([2.0, 1.0, 2.0], false);
    // A cup: a box without its top, thickened.
    let (outer, inner) = ([1.2, 0.7, 1.2], [1.0, 0.5, 1.0]);
    let corner = |extents: [f64; 3], k: u32, low: f64| {
        [0, 1, 2].map(|a| {
            let side = f64::from(k >> a & 1);
            if a == 1 { low + side * (0.5 - low) } else { (2.0 * side - 1.0) * extents[a] }
        })
    };
    let mut vertices: Vec<_> = (0..8).map(|k| corner(outer, k, -outer[1])).collect();
    vertices.extend((0..8).map(|k| corner(inner, k, -inner[1])));
    let walls = [[0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut faces: Vec<[u32; 4]> = walls.to_vec();
    faces.extend(walls.map(|[a, b, c, d]| [d + 8, c + 8, b + 8, a + 8]));
    faces.extend([[2, 6, 14, 10], [6, 7, 15, 14], [7, 3, 11, 15], [3, 2, 10, 11]]);
    let cup = Mesh::new(vertices, &faces).unwrap();
    assert!(cup.is_closed() && !tray.is_closed());
    for (name, mesh) in [("tray", tray), ("cup", cup)] {
        let body = ball_body().translate([0.2, 0.6, 0.0]).velocity([3.0, -2.0, 1.0]);
        let collider = Collider::mesh(mesh).unwrap();
        let mut simulation = simulation(body, std::slice::from_ref(&collider));
        simulation.steps(960);
        let at = center(&simulation);
        assert!(at.y < 0.1 && at.x.abs() < 0.6 && at.z.abs() < 0.6, "{name}: {at}");
        let body = simulation.body(0);
        let cell = body.lattice().cell_size();
        let depth = |p: &Point3<f64>| -collider.shape.signed_distance((*p).into()).distance / cell;
        let is_inside = |p: &Point3<f64>| depth(p) < 0.02 && p.y > -0.5 - 0.02 * cell;
        assert!(body.surface().positions.iter().all(is_inside), "{name}");
    }
}

#[test]
fn a_moving_mesh_carries_a_body_by_friction() {
    let key = |time, x| Key { time, translate: [x, 0.0, 0.0], rotate: [0.0; 3] };
    let collider =
        Collider { keys: vec![key(0.5, 0.0), key(2.5, 1.0)], ..Collider::mesh(square(5.0)).unwrap() };
    let mut simulation = simulation(ball_body().translate([0.0, 0.52, 0.0]), &[collider]);
    simulation.steps(600);
    // A ball that starts to roll gets 2/7 of the displacement, and more with rolling resistance.
    assert!(center(&simulation).x > 0.25, "{}", center(&simulation));
}

#[test]
fn a_body_in_a_closed_mesh_leaves_it_whole() {
    let collider = Collider::mesh(centered_box([3.0, 2.0, 3.0], true)).unwrap();
    let mut simulation = simulation(ball_body().translate([0.0, 0.2, 0.0]), &[collider]);
    let before = simulation.body(0).positions();
    simulation.steps(10);
    let moved: Vec<_> = simulation.body(0).positions().iter().zip(&before).map(|(p, q)| p - q).collect();
    assert!(moved[0].y > 0.1 && moved.iter().all(|way| (way - moved[0]).norm() < 1e-5), "{}", moved[0]);
    simulation.steps(230);
    assert!(center(&simulation).y > 1.4, "{}", center(&simulation));
    // On a sheet through its middle, the body leaves to one side.
    let sheet = Collider::mesh(square(5.0)).unwrap();
    let mut cut = self::simulation(ball_body().translate([0.0, 0.1, 0.0]), &[sheet]);
    cut.steps(64);
    let lowest = cut.body(0).surface().positions.iter().map(|p| p.y).fold(9.0, f64::min);
    assert!(lowest > 0.0, "{lowest}");
}

/// The fast body has side points when the state is saved.
#[test]
fn side_points_have_the_same_bits_for_any_thread_count_and_after_a_restart() {
    let scene = |threads| {
        let body = ball_body().translate([0.0, 0.7, 0.0]).velocity([2.0, -10.0, 0.0]).build().unwrap();
        let sheet = Collider::mesh(square(5.0)).unwrap();
        let rod = Collider::capsule([-2.0, 0.1, 0.0], [2.0, 0.1, 0.0], 0.03);
        let builder = Simulation::builder().body(body).collider(sheet).collider(rod);
        builder.dt(1.0 / 60.0).threads(threads).build().unwrap()
    };
    let bits = |simulation: &Simulation| postcard::to_stdvec(&simulation.state()).unwrap();
    let mut first = scene(1);
    first.steps(4);
    let saved = bits(&first);
    first.steps(40);
    for threads in [2, 3] {
        let mut other = scene(threads);
        other.steps(44);
        assert!(bits(&other) == bits(&first), "{threads} threads");
    }
    let mut restarted = scene(2);
    let state: SimulationState = postcard::from_bytes(&saved).unwrap();
    restarted.restore(&state).unwrap();
    restarted.steps(40);
    assert!(bits(&restarted) == bits(&first));
}

#[test]
fn scenes_read_mesh_colliders_and_their_errors_name_file_key_and_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("sheet.obj", "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 2 3 4\n");
    write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    write("points.obj", "v 0 0 0\nv 1 0 0\n");
    write("body.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    let scene = |collider: &str| {
        let text = format!("[[body]]\nmesh = \"body.obj\"\n[[collider]]\n{collider}\n");
        Scene::parse(&text, "scene.toml", folder.path(), &[])
    };
    let text = "mesh = \"sheet.obj\"\nscale = 3\nrotate = [0, 90, 0]\ntranslate = [0, -2, 0]\nfriction = 0.7";
    let read = scene(text).unwrap();
    let again = Scene::parse(&read.to_toml(), "again", folder.path(), &[]).unwrap();
    assert_eq!(again, read);
    let prepared = prepare(&read).unwrap();
    let collider = prepared.simulation.collider(0).description().clone();
    assert_eq!(collider.shape.center(), Point3::new(0.0, -2.0, 0.0));
    assert_eq!((collider.friction, collider.shape.signed_distance([2.9, -1.0, 0.0]).distance), (0.7, 1.0));
    // Checkpoints depend on the contents of the file.
    let before = fingerprint(&read).unwrap();
    write("sheet.obj", "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nf 1 2 3\n");
    let change = difference(&before, &fingerprint(&read).unwrap()).unwrap();
    assert!(change.contains("the mesh file has changed"), "{change}");
    for (collider, words) in [
        ("mesh = \"sheet.obj\"\nscale = 0", &["scene.toml:5", "collider.0.scale", "0", "above 0"][..]),
        ("mesh = \"\"", &["collider.0.mesh", "the path of a model"]),
        ("sphere = { center = [0, 0, 0], radius = 1 }\nscale = 2", &["collider.0.scale", "only `mesh`"]),
        ("mesh = \"sheet.obj\"\nplane = { point = [0, 0, 0], normal = [0, 1, 0] }", &["mesh", "plane"]),
    ] {
        let error = scene(collider).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
    for (file, words) in [
        ("missing.obj", &["collider.0.mesh", "missing.obj"][..]),
        ("points.obj", &["collider.0.mesh", "points.obj", "face"]),
        ("line.obj", &["collider.0.mesh", "line.obj", "area"]),
    ] {
        let error = prepare(&scene(&format!("mesh = \"{file}\"")).unwrap()).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}

/// A sheet rises by 1 between 0.5 s and 1 s and then stays, in samples every half second.
fn rising_sheet() -> CollisionMesh {
    let sheet = square(2.0);
    let at = |height: f32| sheet.vertices().iter().map(move |p| [p.x as f32, height, p.z as f32]);
    let positions: Vec<[f32; 3]> = [0.0, 0.0, 1.0, 1.0].into_iter().flat_map(at).collect();
    let animation = MeshAnimation::new(positions, 4, 0.0, 0.5).unwrap();
    CollisionMesh::animated(sheet, animation).unwrap()
}

#[test]
fn an_animated_mesh_lifts_a_body_as_keyframes_do() {
    let key = |time, y| Key { time, translate: [0.0, y, 0.0], rotate: [0.0; 3] };
    let rigid = Collider { keys: vec![key(0.5, 0.0), key(1.0, 1.0)], ..Collider::mesh(square(2.0)).unwrap() };
    let (mesh, zero) = (rising_sheet(), [0.0; 3]);
    let animated = Collider::new(Shape::Mesh { mesh, scale: 1.0, rotate: zero, translate: zero });
    let mut simulations = [rigid, animated].map(|collider| {
        let body = ball_body().translate([0.1, 0.52, 0.1]).build().unwrap();
        let builder = Simulation::builder().body(body).collider(collider).dt(1.0 / 240.0);
        builder.threads(1).sleep(false).build().unwrap()
    });
    for _ in 0..16 {
        simulations.iter_mut().for_each(|simulation| simulation.steps(30));
        let [a, b] = [0, 1].map(|index| center(&simulations[index]));
        assert!((a - b).norm() < 1e-3, "{a} {b} at {}", simulations[0].time());
    }
    assert!(center(&simulations[1]).y > 1.4);
}

#[test]
fn an_animation_has_the_same_bits_after_a_restart_and_a_new_time() {
    let (mesh, zero) = (rising_sheet(), [0.0; 3]);
    let collider = Collider::new(Shape::Mesh { mesh, scale: 1.0, rotate: [0.0, 20.0, 0.0], translate: zero });
    let scene = || simulation(ball_body().translate([0.1, 0.52, 0.1]), std::slice::from_ref(&collider));
    let mut first = scene();
    first.steps(150);
    let saved = first.state();
    first.steps(60);
    let mut restarted = scene();
    restarted.restore(&saved).unwrap();
    restarted.steps(60);
    assert!(restarted.state() == first.state());
    // After the last sample the sheet is raised.
    let mut later = simulation(ball_body().translate([0.1, 1.6, 0.1]), &[collider]);
    later.set_time(5.0).unwrap();
    later.steps(240);
    assert!((center(&later).y - 1.5).abs() < 0.05, "{}", center(&later));
}

#[test]
fn invalid_animations_are_errors() {
    let zeros = |count: usize| vec![[0.0_f32; 3]; count];
    for (animation, words) in [
        (MeshAnimation::new(zeros(7), 4, 0.0, 1.0), "whole samples of 4"),
        (MeshAnimation::new(zeros(0), 4, 0.0, 1.0), "whole samples of 4"),
        (MeshAnimation::new(zeros(8), 4, 0.0, 0.0), "above 0"),
        (MeshAnimation::new(vec![[0.0, f32::NAN, 0.0]; 4], 4, 0.0, 1.0), "vertex 0 is not finite"),
    ] {
        let error = animation.unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let other = MeshAnimation::new(zeros(5), 5, 0.0, 1.0).unwrap();
    let error = CollisionMesh::animated(square(1.0), other).unwrap_err().to_string();
    assert!(error.contains("5 vertices") && error.contains("has 4"), "{error}");
}

#[test]
fn scenes_read_animations_of_colliders() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(
        path("body.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
    )
    .unwrap();
    let cache = |points: i32, samples: i32, positions: &[f32]| {
        let mut bytes = b"POINTCACHE2\0".to_vec();
        bytes.extend([1, points].into_iter().flat_map(i32::to_le_bytes));
        bytes.extend([3.0_f32, 2.0].into_iter().flat_map(f32::to_le_bytes));
        bytes.extend(samples.to_le_bytes());
        bytes.extend(positions.iter().flat_map(|x| x.to_le_bytes()));
        bytes
    };
    let positions: Vec<f32> = (0..24).map(|k| k as f32).collect();
    std::fs::write(path("walk.pc2"), cache(4, 2, &positions)).unwrap();
    std::fs::write(path("short.pc2"), cache(4, 3, &positions)).unwrap();
    std::fs::write(path("other.pc2"), cache(3, 2, &positions[..18])).unwrap();
    std::fs::write(path("text.pc2"), "no cache, but long enough for the header").unwrap();
    let read = |collider: &str| {
        let text =
            format!("[simulation]\nfps = 10\n[[body]]\nmesh = \"body.obj\"\n[[collider]]\n{collider}\n");
        Scene::parse(&text, "scene.toml", folder.path(), &[])
    };
    let scene = read("mesh = \"body.obj\"\nanimation = \"walk.pc2\"").unwrap();
    let prepared = prepare(&scene).unwrap();
    let Shape::Mesh { mesh, .. } = &prepared.simulation.collider(0).description().shape else {
        panic!("a mesh")
    };
    let animation = mesh.animation().unwrap();
    assert_eq!((animation.samples(), animation.vertices()), (2, 4));
    assert!((animation.start() - 0.3).abs() < 1e-12 && (animation.interval() - 0.2).abs() < 1e-12);
    assert_eq!(animation.positions()[7], [21.0, 22.0, 23.0]);
    for (file, words) in [
        ("missing.pc2", "missing.pc2"),
        ("text.pc2", "POINTCACHE2"),
        ("short.pc2", "incomplete"),
        ("other.pc2", "3 vertices, and the mesh has 4"),
    ] {
        let scene = read(&format!("mesh = \"body.obj\"\nanimation = \"{file}\"")).unwrap();
        let error = prepare(&scene).unwrap_err().to_string();
        assert!(error.contains("collider.0.animation") && error.contains(words), "{error}");
    }
    let error = read("sphere = { center = [0, 0, 0], radius = 1 }\nanimation = \"walk.pc2\"").unwrap_err();
    assert!(error.to_string().contains("only `mesh`"), "{error}");
}
