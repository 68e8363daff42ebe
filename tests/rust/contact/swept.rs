//! Fast bodies do not pass thin colliders.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, BodyBuilder, Collider, CollisionMesh, Key, Mesh, Preservation, Preset, Shape, Simulation, Substeps,
};
use supple_tests::{grid_box, mesh_of, square_sheet};

/// Speed of the bodies in m/s.
const SPEED: f64 = 10.0;

/// Returns the mesh of a box with its center at the origin, in squares of at most the edge length `step`.
fn squares(extents: [f64; 3], step: f64) -> Mesh {
    let counts = extents.map(|extent| (extent / step).ceil() as u32);
    mesh_of(grid_box(extents.map(|x| -x / 2.0), extents.map(|x| x / 2.0), counts))
}

/// Returns the bust of the example scenes, with its base at y = -0.5, about one unit high.
fn bust() -> BodyBuilder {
    let mesh = supple_tests::bust();
    let (low, high) = mesh.bounds();
    let scale = 1.0 / (high.y - low.y);
    let center = nalgebra::center(&low, &high).coords * scale;
    Body::builder(mesh).scale(scale).translate((-center).into()).lattice_vertices(1000)
}

/// Returns the winding number of a surface around a point (Van Oosterom & Strackee 1983).
fn winding(mesh: &Mesh, positions: &[Point3<f64>], point: &Point3<f64>) -> f64 {
    let solid_angle = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| positions[v as usize] - point);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(denominator)
    };
    mesh.triangles().iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// A body and its name.
type NamedBody = (&'static str, fn() -> BodyBuilder);

fn bodies() -> [NamedBody; 4] {
    [
        ("cube", || Body::builder(squares([1.0; 3], 0.0625)).cell_size(0.125)),
        ("lying plate", || Body::builder(squares([1.0, 0.125, 1.0], 0.0625)).cell_size(0.125)),
        ("standing plate", || Body::builder(squares([1.0, 1.0, 0.125], 0.0625)).cell_size(0.125)),
        ("bust", bust),
    ]
}

/// Throws a body down at the collider at the origin, from about 0.4 above, and calls `check` with the positions of its mesh
/// after each of 90 frames of 1/60 s.
fn throw(
    body: BodyBuilder,
    collider: Collider,
    (speed, substeps): (f64, Substeps),
    mut check: impl FnMut(&[Point3<f64>], f64),
) {
    // The volume correction moves the displayed surface.
    let body = body
        .preset(Preset::Rubber)
        .poisson_ratio(0.0)
        .volume(Preservation::Off)
        .velocity([0.0, -speed, 0.0])
        .build()
        .unwrap();
    let builder = Simulation::builder().body(body).collider(collider).gravity([0.0; 3]).threads(1);
    let mut simulation = builder.fps(60.0).substeps(substeps).build().unwrap();
    let raised: Vec<_> = simulation.body(0).positions().iter().map(|p| p + Vector3::y() * 0.9).collect();
    simulation.body_mut(0).set_positions(&raised).unwrap();
    let cell = simulation.body(0).lattice().cell_size();
    for _ in 0..90 {
        simulation.advance(1);
        check(&simulation.body(0).surface().positions, cell);
    }
}

/// The colliders are wider than the bodies, so that every point has to stay above them.
#[test]
fn fast_bodies_stay_above_planes_plates_and_sheets() {
    let colliders = [
        ("plane", Collider::plane([0.0; 3], [0.0, 1.0, 0.0])),
        ("box", Collider::cuboid([0.0; 3], [5.0, 0.025, 5.0], [0.0; 3])),
        ("sheet", Collider::mesh(square_sheet(5.0, 7)).unwrap()),
        (
            "turned sheet",
            Collider { keys: vec![half_turn()], ..Collider::mesh(square_sheet(5.0, 7)).unwrap() },
        ),
    ];
    for (name, body) in bodies() {
        for (against, collider) in &colliders {
            for speed in [3.0, SPEED] {
                let mut lowest = f64::INFINITY;
                throw(body(), collider.clone(), (speed, Substeps::Fixed(1)), |positions, cell| {
                    lowest = positions.iter().map(|p| p.y / cell).fold(lowest, f64::min);
                });
                // The mid-plane of the box is 0.2 cells and more below its surface.
                assert!(lowest > -0.05, "{name} at {speed} m/s against {against}: {lowest}");
            }
        }
    }
}

fn half_turn() -> Key {
    Key { time: 0.0, translate: [0.0; 3], rotate: [180.0, 0.0, 0.0] }
}

/// A body wraps a narrow collider or slides off it. The collider does not get inside: neither the surface at rest nor more
/// than a few points of the moving one.
///
/// The fast bodies have the steps that their material needs. In one step a frame they are softer, and the dent of an impact,
/// deeper than the ball, can open beside the ball and close below it, without a vertex that crosses the ball.
#[test]
fn fast_bodies_do_not_swallow_balls_and_rods() {
    let colliders = [
        ("ball", Collider::sphere([0.013, 0.0, 0.017], 0.2)),
        ("rod", Collider::capsule([-2.0, 0.0, 0.017], [2.0, 0.0, 0.017], 0.03)),
    ];
    for (name, body) in bodies() {
        let mesh = body().build().unwrap().mesh().unwrap().clone();
        for (against, collider) in &colliders {
            for (speed, substeps) in [(3.0, Substeps::Fixed(1)), (SPEED, Substeps::Auto)] {
                let (mut inside, mut enclosed) = (0.0_f64, 0.0);
                throw(body(), collider.clone(), (speed, substeps), |positions, cell| {
                    let depth =
                        |p: &Point3<f64>| -collider.shape.signed_distance((*p).into()).distance / cell;
                    let deep = positions.iter().filter(|p| depth(p) > 0.2).count();
                    inside = inside.max(deep as f64 / positions.len() as f64);
                    let middle = Point3::new(0.013, 0.0, 0.017);
                    enclosed = winding(&mesh, positions, &middle).abs();
                });
                assert!(
                    inside < 0.01 && enclosed < 0.5,
                    "{name} at {speed} m/s against {against}: {inside} {enclosed}"
                );
            }
        }
    }
}

/// A plate that is driven through a body at rest pushes it, whichever of them moves.
#[test]
fn fast_colliders_push_bodies() {
    let key = |time, y| Key { time, translate: [0.0, y, 0.0], rotate: [0.0; 3] };
    let shapes = [
        Collider::cuboid([0.0, -1.0, 0.0], [5.0, 0.025, 5.0], [0.0; 3]),
        Collider::new(Shape::Mesh {
            mesh: CollisionMesh::new(square_sheet(5.0, 7)).unwrap(),
            scale: 1.0,
            rotate: [0.0; 3],
            translate: [0.0, -1.0, 0.0],
        }),
    ];
    for (name, body) in bodies() {
        for shape in &shapes {
            let plate = Collider { keys: vec![key(0.0, 0.0), key(0.3, 3.0)], ..shape.clone() };
            let body = body().volume(Preservation::Off).build().unwrap();
            let builder = Simulation::builder().body(body).collider(plate).gravity([0.0; 3]).threads(1);
            let mut simulation = builder.dt(1.0 / 60.0).build().unwrap();
            simulation.steps(30);
            let lowest = simulation.body(0).surface().positions.iter().map(|p| p.y).fold(9.0, f64::min);
            assert!(lowest > 2.0, "{name}: {lowest}");
        }
    }
}
