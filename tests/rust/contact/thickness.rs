//! Contact at a distance from the surfaces: the thickness of bodies and colliders.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, BodyBuilder, Collider, CollisionMesh, Handle, Key, Lattice, Mesh, Selection, Shape, Simulation,
    SimulationBuilder, Substeps, TimeWindow, Touched,
};
use supple_tests::{grid_box, mesh_of, square_sheet};

/// Cell size of the bodies.
const CELL: f64 = 0.125;

/// Thickness of a body and of a collider, in scene units: 0.16 and 0.12 cells.
const BODY: f64 = 0.02;
const COLLIDER: f64 = 0.015;

/// Greatest depth at which a body rests, in cells: deeper samples are pushed out, and shallower ones are so slowly that
/// they stay. A gap closes within this distance too.
const SOFT_DEPTH: f64 = 0.01;

fn box_mesh(extents: [f64; 3]) -> Mesh {
    let counts = extents.map(|extent| (extent / CELL).ceil() as u32);
    mesh_of(grid_box(extents.map(|x| -x / 2.0), extents.map(|x| x / 2.0), counts))
}

fn cube() -> BodyBuilder {
    Body::builder(box_mesh([0.5; 3])).cell_size(CELL)
}

/// Returns a sheet of one cell.
fn sheet() -> BodyBuilder {
    Body::builder(square_sheet(0.5, 8)).cell_size(CELL)
}

fn scene() -> SimulationBuilder {
    Simulation::builder().fps(60.0).substeps(Substeps::Fixed(4)).threads(1)
}

/// Returns colliders whose top is at y = 0.
fn grounds() -> [(&'static str, Collider); 5] {
    let mesh = |mesh: Mesh, translate| {
        let mesh = CollisionMesh::new(mesh).unwrap();
        Collider::new(Shape::mesh(mesh, 1.0, [0.0; 3], translate).unwrap())
    };
    [
        ("plane", Collider::plane([0.0; 3], [0.0, 1.0, 0.0])),
        ("sphere", Collider::sphere([0.0, -3.0, 0.0], 3.0)),
        ("box", Collider::cuboid([0.0, -0.5, 0.0], [2.0, 0.5, 2.0], [0.0; 3])),
        ("closed mesh", mesh(box_mesh([2.0, 0.5, 2.0]), [0.0, -0.25, 0.0])),
        ("open mesh", mesh(square_sheet(2.0, 1), [0.0; 3])),
    ]
}

/// Drops a body on a collider from a distance of about 0.05, and returns the least distance of its displayed surface.
fn rest_distance(body: BodyBuilder, ground: &Collider) -> f64 {
    let lowest = body.clone().build().unwrap().positions().iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let body = body.translate([0.0, 0.05 - lowest, 0.0]).build().unwrap();
    let mut sim = scene().body(body).collider(ground.clone()).build().unwrap();
    sim.advance(120);
    least_distance(&sim, 0, ground)
}

/// Returns the least distance of the displayed surface of a body from a collider.
fn least_distance(sim: &Simulation, body: usize, ground: &Collider) -> f64 {
    let distance = ground.signed_distance_at(0.0).unwrap();
    let surface = sim.body(body).surface().positions;
    surface.iter().map(|&p| distance(p.into())).fold(f64::INFINITY, f64::min)
}

fn bodies() -> [(&'static str, BodyBuilder); 3] {
    [("cube", cube()), ("sheet", sheet()), ("rigid cube", cube().rigid(true))]
}

#[test]
fn bodies_rest_on_colliders_at_the_sum_of_the_thicknesses() {
    for (name, ground) in grounds() {
        for (kind, body) in bodies() {
            let thick = Collider { thickness: COLLIDER, ..ground.clone() };
            // An open mesh has a shell without a thickness, which is part of the thickness.
            let thin = if name == "open mesh" { 0.0 } else { rest_distance(body.clone(), &ground) };
            let found = rest_distance(body.thickness(BODY), &thick) - thin;
            assert!((found - BODY - COLLIDER).abs() < 2.0 * SOFT_DEPTH * CELL, "{kind} on {name}: {found}");
        }
    }
}

#[test]
fn bodies_rest_on_each_other_at_the_sum_of_their_thicknesses() {
    let gap = |lower: BodyBuilder, upper: BodyBuilder, thickness: f64| {
        let built = |body: BodyBuilder, name: &str, y: f64| {
            body.name(name).thickness(thickness).translate([0.0, y, 0.0]).build().unwrap()
        };
        let bodies = (built(lower, "lower", 0.3), built(upper, "upper", 0.9));
        let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        let mut sim = scene().body(bodies.0).body(bodies.1).collider(ground).build().unwrap();
        sim.advance(180);
        // The vertices of both bodies lie above each other.
        let middle = |body: usize| {
            let surface = sim.body(body).surface().positions.into_iter();
            surface.filter(|p| p.x.abs() < 1.1 * CELL && p.z.abs() < 1.1 * CELL).collect::<Vec<_>>()
        };
        let contacts = sim.contacts();
        let touched = contacts.iter().filter(|contact| matches!(contact.other, Touched::Body(_)));
        assert!(touched.count() > 0);
        let lower = middle(0);
        let gap = |p: &Point3<f64>| {
            let beside = |q: &&Point3<f64>| (q.x - p.x).hypot(q.z - p.z) < 0.3 * CELL;
            p.y - lower.iter().filter(beside).map(|q| q.y).fold(f64::MIN, f64::max)
        };
        middle(1).iter().map(gap).fold(f64::INFINITY, f64::min)
    };
    for (lower_kind, lower) in bodies() {
        for (kind, upper) in bodies() {
            let thin = gap(lower.clone(), upper.clone(), 0.0);
            let found = gap(lower.clone(), upper, BODY);
            // A sheet without a thickness keeps 0.1 cells, and may bulge between the samples that touch.
            assert!(thin > -SOFT_DEPTH * CELL && thin < 1.5 * BODY, "{kind} on {lower_kind}: {thin}");
            let range = 2.0 * BODY - 2.0 * SOFT_DEPTH * CELL..2.0 * BODY + 0.1 * CELL;
            assert!(range.contains(&found), "{kind} on {lower_kind}: {found}");
        }
    }
}

/// Returns the least difference of the distances from the center of a sphere between the vertices of the upper sheet
/// and the nearest ones of the lower sheet, in scene units.
fn least_gap(sim: &Simulation, center: &Point3<f64>) -> f64 {
    let [lower, upper] = [0, 1].map(|body| sim.body(body).surface().positions);
    let gap = |p: &Point3<f64>| {
        let nearest = lower.iter().min_by(|a, b| (*a - p).norm().total_cmp(&(*b - p).norm())).unwrap();
        // Beside the other sheet there is no gap.
        ((nearest - p).norm() < CELL).then(|| (p - center).norm() - (nearest - center).norm())
    };
    upper.iter().filter_map(gap).fold(f64::INFINITY, f64::min)
}

#[test]
fn sheets_lie_on_each_other_on_a_sphere_and_do_not_pass() {
    let center = Point3::new(0.0, -0.8, 0.0);
    let placed = |name: &str, y: f64, turn: f64| {
        sheet().name(name).thickness(BODY).translate([0.0, y, 0.0]).rotate([0.0, turn, 0.0]).build().unwrap()
    };
    let ball = Collider::sphere(center.into(), 0.8);
    let (lower, upper) = (placed("lower", 0.05, 0.0), placed("upper", 0.3, 45.0));
    let mut sim = scene().body(lower).body(upper).collider(ball.clone()).build().unwrap();
    for frame in 0..150 {
        sim.advance(1);
        let gap = least_gap(&sim, &center);
        assert!(gap > 0.5 * BODY, "frame {frame}: {gap}");
    }
    let (lower, upper) = (least_distance(&sim, 0, &ball), least_distance(&sim, 1, &ball));
    let gap = least_gap(&sim, &center);
    // Between samples a cell apart, the sphere is higher than their chord.
    let (tolerance, sagitta) = (2.0 * SOFT_DEPTH * CELL, CELL * CELL / (8.0 * 0.8));
    assert!(lower > BODY - tolerance && lower < BODY + tolerance + sagitta, "{lower}");
    assert!(upper > 3.0 * BODY - tolerance, "{upper}");
    assert!((gap - 2.0 * BODY).abs() < tolerance, "{gap}");
}

/// Linear momentum, angular momentum about the origin, Σ m |v| and Σ m |x| |v|.
fn momenta(sim: &Simulation) -> (Vector3<f64>, Vector3<f64>, f64, f64) {
    let mut sums = (Vector3::zeros(), Vector3::zeros(), 0.0, 0.0);
    for body in sim.bodies() {
        for ((x, v), m) in body.positions().iter().zip(body.velocities()).zip(body.masses()) {
            sums.0 += v * m;
            sums.1 += x.coords.cross(&v) * m;
            sums.2 += m * v.norm();
            sums.3 += m * v.norm() * x.coords.norm();
        }
    }
    sums
}

#[test]
fn collision_with_a_thickness_keeps_momenta() {
    let first = cube().translate([-0.4, 0.0, 0.0]).rotate([10.0, 20.0, 5.0]).velocity([1.0, 0.0, 0.0]);
    let second = cube().translate([0.4, 0.2, 0.1]).density(700.0).velocity([-1.0, 0.0, 0.0]);
    let floating = Simulation::builder().gravity([0.0; 3]).dt(1.0 / 240.0).sleep(false).threads(1);
    let mut sim = floating
        .body(first.thickness(3.0 * BODY).spin([0.0, 1.0, 0.5]).build().unwrap())
        .body(second.thickness(BODY).spin([0.3, 0.0, 1.0]).build().unwrap())
        .build()
        .unwrap();
    sim.step();
    let before = momenta(&sim);
    let mut touched = false;
    for _ in 0..120 {
        sim.step();
        touched |= !sim.contacts().is_empty();
        let now = momenta(&sim);
        // The velocities are f32: each has a relative rounding error of 6e-8.
        assert!((now.0 - before.0).norm() < 1e-7 * before.2, "{}", (now.0 - before.0).norm() / before.2);
        assert!((now.1 - before.1).norm() < 1e-6 * before.3, "{}", (now.1 - before.1).norm() / before.3);
    }
    assert!(touched);
    let [first, second] = [0, 1].map(|body| sim.bodies()[body].center_of_mass().x);
    assert!(second - first > 0.5, "they pass through each other: {first}, {second}");
}

#[test]
fn fast_bodies_do_not_pass_thin_colliders_with_a_thickness() {
    let plate = Collider::cuboid([0.0; 3], [2.0, 0.01, 2.0], [0.0; 3]);
    for (name, ground) in [("plate", plate), ("open mesh", Collider::mesh(square_sheet(2.0, 1)).unwrap())] {
        for (kind, body) in bodies() {
            let thick = Collider { thickness: COLLIDER, ..ground.clone() };
            let body = body.thickness(BODY).translate([0.0, 0.6, 0.0]).velocity([0.0, -10.0, 0.0]);
            let mut sim = scene().body(body.build().unwrap()).collider(thick).build().unwrap();
            sim.advance(120);
            let surface = sim.body(0).surface().positions;
            let lowest = surface.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
            assert!(lowest > BODY, "{kind} on {name}: {lowest}");
        }
    }
}

#[test]
fn a_thickness_of_zero_has_the_bits_of_none_and_another_one_has_not() {
    let positions = |set: fn(BodyBuilder) -> BodyBuilder, thickness: f64| {
        let built = |body: BodyBuilder, name: &str, y: f64| {
            set(body.name(name).translate([0.0, y, 0.0])).build().unwrap()
        };
        let (lower, upper) = (built(cube(), "lower", 0.3), built(sheet(), "upper", 0.7));
        let ground = Collider { thickness, ..Collider::cuboid([0.0, -0.5, 0.0], [2.0, 0.5, 2.0], [0.0; 3]) };
        let mut sim = scene().body(lower).body(upper).collider(ground).build().unwrap();
        sim.advance(40);
        (sim.body(0).surface().positions, sim.body(1).surface().positions)
    };
    let none = positions(|body| body, 0.0);
    assert_eq!(none, positions(|body| body.thickness(0.0), 0.0));
    assert_ne!(none, positions(|body| body.thickness(BODY), 0.0));
    assert_ne!(none, positions(|body| body, COLLIDER));
}

#[test]
fn a_body_with_a_thickness_continues_from_a_state_with_the_same_bits() {
    let built =
        |name: &str, y: f64| cube().name(name).thickness(BODY).translate([0.0, y, 0.0]).build().unwrap();
    let build = || {
        let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        scene().body(built("lower", 0.28)).body(built("upper", 0.85)).collider(ground).build().unwrap()
    };
    let (mut first, mut second) = (build(), build());
    first.advance(20);
    second.restore(&first.state()).unwrap();
    first.advance(20);
    second.advance(20);
    assert_eq!(first.body(1).surface().positions, second.body(1).surface().positions);
}

/// The layers of both bodies may be thicker than a cell.
#[test]
fn bodies_with_layers_of_several_cells_continue_from_a_state() {
    let built =
        |name: &str, y: f64| cube().name(name).thickness(CELL).translate([0.0, y, 0.0]).build().unwrap();
    let mut sim =
        scene().gravity([0.0; 3]).body(built("lower", 0.0)).body(built("upper", 0.7)).build().unwrap();
    sim.advance(3);
    assert!(sim.contacts().iter().any(|contact| contact.other == Touched::Body(1)));
    let state = sim.state();
    sim.advance(3);
    let expected = sim.body(1).positions();
    sim.restore(&state).unwrap();
    sim.advance(3);
    assert_eq!(sim.body(1).positions(), expected);
}

/// Two fingers three cells apart, on a common base: with a thickness of two cells each, their layers overlap at rest.
#[test]
fn self_contact_leaves_parts_where_they_are_at_rest() {
    let mut cells = Vec::new();
    for x in 0..7 {
        for y in 0..8 {
            for z in 0..2 {
                if y < 2 || !(2..5).contains(&x) {
                    cells.push([x, y, z]);
                }
            }
        }
    }
    let lattice = Lattice::from_cells(&cells, CELL, Point3::origin(), false).unwrap();
    let floating = |body: BodyBuilder| {
        let builder = Simulation::builder().gravity([0.0; 3]).dt(1.0 / 240.0).threads(1).sleep(false);
        builder.body(body.build().unwrap()).build().unwrap()
    };
    let body = |thickness: f64| Body::from_lattice(lattice.clone()).self_contact(true).thickness(thickness);
    let mut sim = floating(body(2.0 * CELL));
    let before = sim.body(0).positions();
    sim.steps(60);
    let moved = sim.body(0).positions().iter().zip(&before).map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    // Positions at rest are rounded to f32.
    assert!(moved < 1e-4 * CELL, "{moved}");
    // The tips are pressed together.
    let closest = |thickness: f64| {
        let handle = |x: f64, push: f64| {
            let selection =
                Selection::Box { min: [x - 0.01, 7.9 * CELL, -1.0], max: [x + 0.01, 9.0 * CELL, 1.0] };
            let key = |time: f64, x: f64| Key { time, translate: [x, 0.0, 0.0], rotate: [0.0; 3] };
            let keys = vec![key(0.0, 0.0), key(0.3, push * CELL)];
            Handle { goal: None, selection, motion: keys.into(), window: TimeWindow::default() }
        };
        let mut sim = floating(body(thickness).handle(handle(0.0, 1.6)).handle(handle(7.0 * CELL, -1.6)));
        sim.steps(120);
        let positions = sim.body(0).positions();
        let inner = |left: bool| {
            let is_side = |index: &[i32; 3]| index[1] > 3 && index[0] == if left { 2 } else { 5 };
            let all = positions.iter().zip(lattice.indices());
            let x = all.filter(|(_, index)| is_side(index)).map(|(p, _)| p.x);
            if left { x.fold(f64::MIN, f64::max) } else { x.fold(f64::MAX, f64::min) }
        };
        inner(false) - inner(true)
    };
    let (thin, thick) = (closest(0.0), closest(0.5 * CELL));
    let tolerance = 2.0 * SOFT_DEPTH * CELL;
    assert!(thin.abs() < tolerance && (thick - CELL).abs() < tolerance, "{thin} {thick}");
}

#[test]
fn a_thickness_out_of_range_is_an_error_with_its_name() {
    for thickness in [-0.1, f64::NAN, f64::INFINITY] {
        let message = cube().thickness(thickness).build().unwrap_err().to_string();
        assert!(message.starts_with("thickness = "), "{message}");
        let plane = Collider { thickness, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
        let message = plane.validate().unwrap_err().to_string();
        assert!(message.contains("thickness is "), "{message}");
    }
    // Half of the longest side of the cube is 0.25.
    assert!(cube().thickness(0.25).build().is_ok());
    let message = cube().thickness(0.26).build().unwrap_err().to_string();
    assert!(message.contains("thickness = 0.26 is out of range: it must be at most 0.25"), "{message}");
}
