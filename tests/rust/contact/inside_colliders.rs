//! Bodies that begin inside colliders leave them whole.

use nalgebra::{Matrix3, Point3, Vector3};
use supple::{
    Body, BodyBuilder, BodyRef, Collider, Lattice, Mesh, Pin, Preset, Selection, Simulation, SimulationState,
    Substeps, TimeWindow,
};

use supple_tests::{ball, block};

const GRAVITY: f64 = 9.81;

/// A cube with edges of 1, of 6 cells along each, with its center at zero.
fn cube() -> BodyBuilder {
    let lattice = Lattice::from_cells(&block([6; 3]), 1.0 / 6.0, Point3::from([-0.5; 3]), true);
    Body::from_lattice(lattice.unwrap())
}

/// The bust, 2 high, with the center of its bounding box at zero.
fn bust() -> BodyBuilder {
    let mesh = supple_tests::bust();
    let (low, high) = bounds(mesh.vertices());
    let scale = 2.0 / (high.y - low.y);
    let center = nalgebra::center(&low, &high) * scale;
    Body::builder(mesh).scale(scale).translate((-center.coords).into()).lattice_vertices(1000)
}

fn bounds(points: &[Point3<f64>]) -> (Point3<f64>, Point3<f64>) {
    points[1..].iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)))
}

fn simulation(body: BodyBuilder, colliders: Vec<Collider>, threads: usize) -> Simulation {
    let builder = Simulation::builder()
        .body(body.preset(Preset::Rubber).build().unwrap())
        .gravity([0.0, -GRAVITY, 0.0]);
    let builder = colliders.into_iter().fold(builder, |builder, collider| builder.collider(collider));
    builder.fps(30.0).substeps(Substeps::Auto).threads(threads).build().unwrap()
}

/// Returns the depth of the deepest point of the surface in a collider at rest.
fn depth(body: BodyRef<'_>, colliders: &[Collider]) -> f64 {
    let surface = if body.mesh().is_some() { body.surface().positions } else { body.positions() };
    let depth = |p: &Point3<f64>| {
        colliders
            .iter()
            .map(|c| -c.shape.signed_distance((*p).into()).distance)
            .fold(f64::NEG_INFINITY, f64::max)
    };
    surface.iter().map(depth).fold(f64::NEG_INFINITY, f64::max)
}

/// Returns the root mean square of the distances of the positions to the closest pose of the rest shape.
fn deformation(positions: &[Point3<f64>], rest: &[Point3<f64>]) -> f64 {
    let mean =
        |points: &[Point3<f64>]| points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    let (center, rest_center) = (mean(positions), mean(rest));
    let pairs = || positions.iter().zip(rest).map(|(p, r)| (p.coords - center, r.coords - rest_center));
    let svd = pairs().fold(Matrix3::zeros(), |sum, (p, r)| sum + p * r.transpose()).svd(true, true);
    let (u, v_t) = (svd.u.unwrap(), svd.v_t.unwrap());
    let sign = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant().signum()));
    let squares = pairs().map(|(p, r)| (p - u * sign * v_t * r).norm_squared());
    (squares.sum::<f64>() / rest.len() as f64).sqrt()
}

fn speed(body: &Body) -> f64 {
    body.velocities().iter().map(|v| v.norm()).fold(0.0, f64::max)
}

/// Runs two seconds.
///
/// Rubber has E = 300 ρ L g, so that a body is strained by up to 1/300 under its weight and 2/300 when it
/// gets its weight at once, and about ten times that where a narrow section carries it; its deformation is below 1 % of
/// its size L. No vertex is faster than in a free fall plus the velocity of a vibration with a strain of 2/300,
/// 2/300 √(E/ρ).
fn leaves_whole(name: &str, body: BodyBuilder, colliders: Vec<Collider>) -> Vector3<f64> {
    let mut simulation = simulation(body, colliders.clone(), 1);
    let rest = simulation.body(0).positions();
    let (low, high) = bounds(&rest);
    let size = (high - low).product().cbrt();
    let cell = simulation.body(0).lattice().cell_size();
    let mut left = None;
    while simulation.time() < 2.0 {
        simulation.step();
        let body = simulation.body(0);
        if left.is_none() {
            // The shape is that at the start until the body is outside.
            assert!(speed(&body) == 0.0, "{name}: {} at {} s", speed(&body), simulation.time());
            assert!(deformation(&body.positions(), &rest) < 1e-6 * size, "{name}");
            left = (depth(body, &colliders) < 0.02 * cell).then(|| simulation.time());
        }
        let fall = GRAVITY * simulation.time() + 2.0 / 300.0 * (300.0 * GRAVITY * size).sqrt();
        assert!(speed(&body) <= fall, "{name}: {} at {} s", speed(&body), simulation.time());
        let strain = deformation(&body.positions(), &rest) / size;
        assert!(strain < 0.01, "{name}: {strain} at {} s", simulation.time());
    }
    assert!(left.is_some_and(|time| time < 0.5), "{name}: left after {left:?} s");
    let body = simulation.body(0);
    assert!(depth(body, &colliders) < 0.02 * cell, "{name}");
    let moved = body.positions().iter().zip(&rest).map(|(p, r)| p - r).sum::<Vector3<f64>>();
    moved / rest.len() as f64
}

fn cuboid(center: [f64; 3], half_extents: [f64; 3]) -> Collider {
    Collider::cuboid(center, half_extents, [0.0; 3])
}

#[test]
fn a_body_in_the_middle_of_a_collider_leaves_it_upwards_and_whole() {
    let cases = [
        ("box", cuboid([0.0; 3], [1.0; 3]), 1.5),
        ("equal box", cuboid([0.0; 3], [0.5; 3]), 1.0),
        ("ball", Collider::sphere([0.0; 3], 1.0), 1.5),
        ("capsule", Collider::capsule([-3.0, 0.0, 0.0], [3.0, 0.0, 0.0], 1.0), 1.5),
        ("plate", cuboid([0.0; 3], [5.0, 0.05, 5.0]), 0.55),
        ("plate between samples", cuboid([0.0, -0.06, 0.0], [5.0, 0.02, 5.0]), 0.46),
        ("half space", Collider::plane([0.0, 2.0, 0.0], [0.0, 1.0, 0.0]), 2.5),
    ];
    for (name, collider, height) in cases {
        let moved = leaves_whole(name, cube(), vec![collider]);
        // It has sunk into round colliders by a part of a cell, and is compressed by its weight.
        assert!((moved - Vector3::y() * height).norm() < 0.05, "{name}: {moved}");
    }
}

#[test]
fn a_body_leaves_by_the_nearest_side() {
    let cases = [
        ("box", cuboid([0.2, -0.05, 0.1], [1.0; 3]), Vector3::new(-1.3, 0.0, 0.0)),
        ("ball", Collider::sphere([0.3, 0.0, 0.0], 1.0), Vector3::new(-1.2, 0.0, 0.0)),
    ];
    for (name, collider, way) in cases {
        let moved = leaves_whole(name, cube(), vec![collider]);
        assert!(moved.dot(&way) > 0.8 * way.norm_squared(), "{name}: {moved}");
    }
    leaves_whole(
        "turned box",
        cube(),
        vec![Collider::cuboid([0.2, -0.1, 0.1], [1.0; 3], [20.0, 30.0, 10.0])],
    );
}

#[test]
fn meshes_leave_boxes_and_plates_whole() {
    leaves_whole("bust in a box", bust(), vec![cuboid([0.0; 3], [2.0; 3])]);
    leaves_whole("bust in a plate", bust(), vec![cuboid([0.0; 3], [5.0, 0.05, 5.0])]);
    let ball = Body::builder(ball(0.5)).lattice_vertices(300);
    leaves_whole(
        "ball in a box on the ground",
        ball,
        vec![cuboid([0.3, 0.0, 0.0], [1.0; 3]), Collider::plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0])],
    );
}

#[test]
fn positions_and_colliders_that_are_set_are_searched_for_overlaps() {
    let collider = cuboid([0.0; 3], [1.0; 3]);
    let mut simulation = simulation(cube().translate([0.0, 1.5, 0.0]), vec![collider.clone()], 1);
    let outside = simulation.body(0).positions();
    simulation.advance(30);
    let resting = simulation.body(0).positions();
    let inside: Vec<_> = outside.iter().map(|p| p - Vector3::y() * 1.4).collect();
    simulation.body_mut(0).set_positions(&inside).unwrap();
    simulation.advance(30);
    assert!(depth(simulation.body(0), std::slice::from_ref(&collider)) < 0.01);
    assert!(deformation(&simulation.body(0).positions(), &resting) < 0.01);
    let raised = cuboid([0.0, 1.2, 0.0], [1.0; 3]);
    simulation.set_colliders(std::slice::from_ref(&raised)).unwrap();
    simulation.advance(30);
    assert!(depth(simulation.body(0), &[raised]) < 0.01);
    assert!(deformation(&simulation.body(0).positions(), &resting) < 0.01);
}

#[test]
fn a_pinned_body_and_a_pressed_body_stay() {
    let pin = Pin {
        goal: None,
        selection: Selection::Plane { point: [0.0, 0.4, 0.0], normal: [0.0, 1.0, 0.0] },
        window: TimeWindow::default(),
    };
    let mut pinned = simulation(cube().pin(pin), vec![cuboid([0.0, -1.2, 0.0], [1.0; 3])], 1);
    let mut pressed = simulation(
        cube(),
        vec![cuboid([0.0, -0.9, 0.0], [9.0, 0.5, 9.0]), cuboid([0.0, 0.9, 0.0], [9.0, 0.5, 9.0])],
        1,
    );
    for simulation in [&mut pinned, &mut pressed] {
        simulation.advance(30);
        let moved: Vector3<f64> =
            simulation.body(0).positions().iter().map(|p| p.coords).sum::<Vector3<f64>>() / 343.0;
        // An even compression of the pinned cube by 0.3 moves its mean by 0.15, and a way out by 0.3.
        assert!(moved.norm() < 0.16, "{moved}");
    }
}

/// The state is saved while the body is leaving.
#[test]
fn a_way_out_has_the_same_bits_for_any_thread_count_and_after_a_restart() {
    let scene = |threads| {
        let collider = Collider::cuboid([0.2, -0.1, 0.1], [1.0; 3], [20.0, 30.0, 10.0]);
        let ground = Collider::plane([0.0, -3.0, 0.0], [0.0, 1.0, 0.0]);
        simulation(bust().lattice_vertices(3000), vec![collider, ground], threads)
    };
    let bits = |simulation: &Simulation| postcard::to_stdvec(&simulation.state()).unwrap();
    let mut first = scene(1);
    first.steps(10);
    let saved = bits(&first);
    first.steps(100);
    for threads in [2, 3] {
        let mut other = scene(threads);
        other.steps(110);
        assert_eq!(bits(&other), bits(&first), "{threads} threads");
    }
    let mut restarted = scene(2);
    let state: SimulationState = postcard::from_bytes(&saved).unwrap();
    restarted.restore(&state).unwrap();
    restarted.steps(100);
    assert_eq!(bits(&restarted), bits(&first));
}

/// A cube without holes in its faces would do as well; this one has a hole, so that it has no inside.
#[test]
fn an_open_mesh_leaves_by_its_samples() {
    let corners = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1].map(|x| f64::from(x) - 0.5)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5]];
    let open = Mesh::new(corners, &quads).unwrap();
    let mut simulation = simulation(Body::builder(open).cell_size(0.1), vec![cuboid([0.0; 3], [1.0; 3])], 1);
    simulation.advance(15);
    assert!(depth(simulation.body(0), &[cuboid([0.0; 3], [1.0; 3])]) < 0.01);
}
