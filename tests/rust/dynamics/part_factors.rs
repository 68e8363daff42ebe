//! Zones of damping, friction and yield strain.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, BodyBuilder, Collider, Damping, HalfWidth, Lattice, Material, Pin, Plasticity, Selection,
    Simulation, SimulationBuilder, TimeWindow, Zone,
};
use supple_tests::{Random, block, block_at, coordinates, lattice, worst};

fn everywhere() -> Selection {
    Selection::Sphere { center: [0.0; 3], radius: 1e3 }
}

/// Returns a zone of the lattice vertices whose coordinate x is in a range.
fn between(low: f64, high: f64) -> Zone {
    Zone::new(Selection::Box { min: [low, -1e3, -1e3], max: [high, 1e3, 1e3] }, 1.0)
}

fn whole() -> Zone {
    Zone::new(everywhere(), 1.0)
}

/// Returns a body of cells of edge 1 with narrow regions.
fn soft(lattice: &Lattice, damping: Damping) -> BodyBuilder {
    let material = Material { damping: Some(damping), ..Material::fast_lsm() };
    Body::from_lattice(lattice.clone()).material(material).half_width(1)
}

fn free() -> SimulationBuilder {
    Simulation::builder().gravity([0.0; 3]).dt(1.0 / 240.0).threads(1)
}

fn shake(body: &mut Body, seed: u64) {
    let mut random = Random(seed);
    let velocities: Vec<_> = (0..body.lattice().len()).map(|_| random.vector()).collect();
    body.set_velocities(&velocities).unwrap();
}

/// Two blocks that are not connected, of one body: with the factor of a zone around one of them, each moves as in a body of
/// the same rate everywhere.
#[test]
fn a_part_is_damped_at_the_rate_times_its_factor() {
    let cells = [block_at([0; 3], [4, 3, 3]), block_at([10, 0, 0], [4, 3, 3])].concat();
    let two = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
    let run = |rate: f64, zone: Option<Zone>| {
        let mut body = soft(&two, Damping::Rate(rate)).build().unwrap();
        zone.iter().for_each(|zone| body.zone(zone).unwrap());
        shake(&mut body, 5);
        let mut simulation = free().body(body).build().unwrap();
        simulation.steps(120);
        simulation.body(0).velocities()
    };
    let (slow, fast) = (run(0.5, None), run(2.0, None));
    let varied = run(0.5, Some(Zone { damping: 4.0, ..between(9.0, 20.0) }));
    let is_fast = |vertex: usize| two.rest_position(vertex as u32).x > 9.0;
    let expected: Vec<_> = (0..slow.len()).map(|v| if is_fast(v) { fast[v] } else { slow[v] }).collect();
    // The fits of the rotations end at a tolerance, so that equal motions differ by more than rounding.
    assert!(worst(&varied, &expected) < 0.01 * worst(&slow, &fast), "{}", worst(&varied, &expected));
}

/// A zone of everything is another rate.
#[test]
fn a_damping_factor_of_the_whole_body_multiplies_the_rate() {
    let run = |rate: f64, factor: f64, velocities: bool| {
        let mut body = soft(&lattice(&block([6, 3, 3])), Damping::Rate(rate)).build().unwrap();
        body.zone(&Zone { damping: factor, ..whole() }).unwrap();
        shake(&mut body, 3);
        let mut simulation = free().body(body).build().unwrap();
        simulation.steps(60);
        if velocities {
            simulation.body(0).velocities()
        } else {
            coordinates(&simulation.body(0).positions())
        }
    };
    for velocities in [false, true] {
        let [slow, expected, found] =
            [(1.5, 1.0), (3.0, 1.0), (1.5, 2.0)].map(|(rate, factor)| run(rate, factor, velocities));
        assert!(worst(&expected, &found) < 0.01 * worst(&slow, &expected), "{}", worst(&expected, &found));
    }
}

/// The half with the greater factor comes to rest first, and a rigid motion stays.
#[test]
fn damping_that_varies_keeps_flight_and_spin() {
    let shape = lattice(&block([8, 3, 3]));
    let spun = |zone: Option<Zone>| {
        let mut body = soft(&shape, Damping::Rate(4.0)).build().unwrap();
        zone.iter().for_each(|zone| body.zone(zone).unwrap());
        let motion = |point: &Point3<f64>| {
            Vector3::new(0.1, 0.2, -0.3)
                + Vector3::new(0.0, 0.0, 0.2).cross(&(point - Point3::new(4.0, 1.5, 1.5)))
        };
        let velocities: Vec<_> = body.positions().iter().map(motion).collect();
        body.set_velocities(&velocities).unwrap();
        let mut simulation = free().body(body).build().unwrap();
        simulation.steps(960);
        let body = simulation.body(0);
        (body.kinetic_energy(), body.angular_momentum(), body.linear_momentum())
    };
    let (energy, spin, momentum) = spun(None);
    let varied = spun(Some(Zone { damping: 30.0, ..between(-1.0, 3.5) }));
    // Both oscillate about the slightly longer shape of a spinning bar: its strain is of the order (ω L/c)² = 1e-3.
    assert!((varied.0 / energy - 1.0).abs() < 2e-3, "{} {energy}", varied.0);
    assert!(
        (varied.1 - spin).norm() < 1e-4 * spin.norm()
            && (varied.2 - momentum).norm() < 1e-4 * momentum.norm()
    );
}

/// Coulomb's law on a slope of 30 degrees, with the friction of the collider times the factor of the body.
#[test]
fn a_friction_factor_multiplies_the_friction_at_colliders_and_bodies() {
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    let slides = |friction: f64, factor: f64, on_body: bool| {
        let material = Material { damping: Some(Damping::Ratio(0.3)), ..Material::default() };
        let block_of = |size| Body::from_lattice(lattice(&block(size)).scaled(0.25).unwrap()).friction(0.4);
        let mut slider = block_of([4, 2, 4]).material(material).friction(friction).build().unwrap();
        slider.zone(&Zone { friction: factor, ..whole() }).unwrap();
        let gravity = [9.81 * sine, -9.81 * cosine, 0.0];
        let plane = Collider { friction: 0.4, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
        let scene = Simulation::builder().gravity(gravity).dt(1.0 / 240.0).threads(1).sleep(false);
        let mut simulation = match on_body {
            false => scene.body(slider).collider(plane).build().unwrap(),
            true => {
                // A rail of the same friction, held below.
                let rail = block_of([60, 2, 8]).rigid(true).translate([-2.0, -0.5, -0.5]);
                let mut rail = rail.build().unwrap();
                let window = TimeWindow::default();
                rail.pin(&Pin { selection: everywhere(), window, goal: None }).unwrap();
                scene.body(slider).body(rail).build().unwrap()
            }
        };
        let speed = |simulation: &Simulation| {
            let body = simulation.body(0);
            body.linear_momentum().x / body.mass()
        };
        simulation.steps(240);
        let before = speed(&simulation);
        simulation.steps(240);
        speed(&simulation) - before
    };
    for factor in [0.25, 0.5, 1.0] {
        let on_plane = slides(0.4, factor, false);
        let expected = 9.81 * (sine - 0.4 * factor * cosine);
        assert!((on_plane / expected - 1.0).abs() < 2e-3, "{factor}: {on_plane} of {expected}");
        // On a body, the coefficient is the geometric mean. Powers of two are exact, and equal contacts have equal bits.
        let (on_body, expected) = (slides(0.4, factor, true), slides(0.4 * factor, 1.0, true));
        assert!((on_body / expected - 1.0).abs() < 1e-3, "{factor}: {on_body} of {expected}");
    }
}

/// A slab whose halves differ in friction sticks with the mean of both, where the pressure is even.
#[test]
fn friction_is_that_of_the_vertices_that_touch() {
    let gripped = |low: f64, high: f64| {
        let slab = Body::from_lattice(lattice(&block([8, 2, 8])).scaled(0.25).unwrap());
        let mut slab = slab.material(Material::default()).build().unwrap();
        slab.zone(&Zone {
            friction: low,
            ..Zone::new(Selection::Plane { point: [0.0, 0.0, 1.0], normal: [0.0, 0.0, 1.0] }, 1.0)
        })
        .unwrap();
        slab.zone(&Zone {
            friction: high,
            ..Zone::new(Selection::Plane { point: [0.0, 0.0, 1.2], normal: [0.0, 0.0, -1.0] }, 1.0)
        })
        .unwrap();
        let plane = Collider { friction: 0.1, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
        let scene = Simulation::builder().gravity([5.0, -9.81, 0.0]).dt(1.0 / 240.0).sleep(false);
        let mut simulation = scene.body(slab).collider(plane).build().unwrap();
        simulation.steps(60);
        let contacts = simulation.contacts();
        let rough = contacts.iter().map(|contact| {
            let normal = contact.force.dot(&contact.normal);
            let sideways = (contact.force - contact.normal * normal).norm();
            (contact.point.z, sideways, normal)
        });
        rough.filter(|(.., normal)| *normal > 1e-3).collect::<Vec<_>>()
    };
    let contacts = gripped(0.5, 3.0);
    let (mut smooth, mut rough) = (0, 0);
    for (z, sideways, normal) in contacts {
        let friction = sideways / normal;
        // The reaction of the damping is shared by all contacts, so that the bounds leave room.
        if z > 1.3 && friction > 0.1 * 0.5 * 1.2 {
            smooth += 1;
        }
        rough += usize::from(z < 0.9 && friction > 0.1 * 1.2);
    }
    assert!(smooth == 0 && rough > 4, "{smooth} {rough}");
}

fn plastic(size: [i32; 3], yield_strain: f64, half_width: HalfWidth) -> BodyBuilder {
    let plastic = Some(Plasticity { yield_strain, creep: 500.0, max: 1.0 });
    let material = Material { plastic, damping: Some(Damping::Rate(8.0)), ..Material::fast_lsm() };
    Body::from_lattice(lattice(&block(size))).material(material).half_width(half_width)
}

/// Returns a body in a shape that is longer by a half along x.
fn stretched(mut body: Body) -> Simulation {
    let longer: Vec<_> =
        body.positions().iter().map(|point| Point3::new(1.5 * point.x, point.y, point.z)).collect();
    body.set_positions(&longer).unwrap();
    let mut simulation = free().body(body).build().unwrap();
    simulation.steps(120);
    simulation
}

#[test]
fn a_yield_factor_of_the_whole_body_is_another_yield_strain_bit_for_bit() {
    for half_width in [HalfWidth::CELL, 1.into(), 2.into()] {
        let expected = stretched(plastic([8, 3, 3], 0.04, half_width).build().unwrap());
        let mut body = plastic([8, 3, 3], 0.01, half_width).build().unwrap();
        body.zone(&Zone { yield_strain: 4.0, ..whole() }).unwrap();
        let found = stretched(body);
        assert_eq!(found.body(0).positions(), expected.body(0).positions(), "{half_width:?}");
        assert!(found.body(0).plastic_strain().iter().any(|strain| *strain > 0.01));
    }
}

#[test]
fn only_the_part_with_the_low_yield_strain_keeps_a_dent() {
    let mut body = plastic([12, 3, 3], 0.02, 1.into()).build().unwrap();
    body.zone(&Zone { yield_strain: 100.0, ..between(-1.0, 5.5) }).unwrap();
    let simulation = stretched(body);
    let body = simulation.body(0);
    for (vertex, strain) in (0..).zip(body.plastic_strain()) {
        let x = body.lattice().rest_position(vertex).x;
        // |D| of the first pose is 0.35, and the limit 2.
        assert!(x > 5.6 || strain == 0.0, "{x}: {strain}");
        assert!(!(8.0..11.0).contains(&x) || strain > 0.02, "{x}: {strain}");
    }
}

/// States, and resets, have the factors of all quantities.
#[test]
fn states_carry_the_factors() {
    let zone = Zone { damping: 5.0, friction: 0.3, yield_strain: 3.0, ..between(-1.0, 3.5) };
    let mut simulation = {
        let mut body = plastic([8, 3, 3], 0.02, 1.into()).translate([0.0, 0.2, 0.0]).build().unwrap();
        body.zone(&zone).unwrap();
        shake(&mut body, 9);
        let ground = Collider::plane([0.0; 3], [0.2, 1.0, 0.0]);
        Simulation::builder().body(body).collider(ground).dt(1.0 / 240.0).build().unwrap()
    };
    simulation.steps(50);
    let saved = simulation.state();
    simulation.steps(50);
    let expected = simulation.body(0).positions();
    simulation.body_mut(0).zone(&Zone { damping: 5.0, friction: 3.0, ..whole() }).unwrap();
    simulation.steps(50);
    assert_ne!(simulation.body(0).positions(), expected);
    simulation.restore(&saved).unwrap();
    simulation.steps(50);
    assert_eq!(simulation.body(0).positions(), expected);
}

#[test]
fn a_yield_factor_needs_plasticity() {
    let zone = Zone { yield_strain: 0.5, ..whole() };
    let error =
        soft(&lattice(&block([2; 3])), Damping::Rate(1.0)).zone(zone).build().unwrap_err().to_string();
    assert!(error.contains("yield_factor") && error.contains("plastic"), "{error}");
}
