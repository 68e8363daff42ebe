//! Rigid bodies: laws of motion, contacts, pins and handles, states, and settings.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, BodyBuilder, Collider, Error, Force, Handle, Key, Lattice, Pin, Preset, RigidError, Selection,
    Simulation, TimeWindow, Touched, VolumeMeasure, Zone,
};
use supple_tests::{mesh_of, plain_box, within};

const G: f64 = 9.81;

/// Returns a rigid box with its center at the origin.
fn cuboid(size: [f64; 3]) -> BodyBuilder {
    Body::builder(mesh_of(plain_box(size.map(|x| -x / 2.0), size.map(|x| x / 2.0)))).rigid(true)
}

/// Returns a simulation without gravity in steps of 1/60 s.
fn in_space(body: Body) -> Simulation {
    Simulation::builder().body(body).gravity([0.0; 3]).dt(1.0 / 60.0).threads(1).build().unwrap()
}

fn ground() -> Collider {
    Collider { friction: 0.5, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) }
}

/// Returns the sum of the forces on a body by what it touches.
fn contact_force(simulation: &Simulation, body: usize) -> Vector3<f64> {
    let force = |contact: supple::ContactPoint| match contact.other {
        _ if contact.body == body => contact.force,
        Touched::Body(other) if other == body => -contact.force,
        _ => Vector3::zeros(),
    };
    simulation.contacts().into_iter().map(force).sum()
}

#[test]
fn mass_center_and_inertia_of_a_closed_mesh_are_exact() {
    let body =
        cuboid([1.0, 2.0, 3.0]).density(700.0).translate([1.0, 2.0, 3.0]).spin([0.3, -0.2, 0.5]).build();
    let body = body.unwrap();
    within(body.mass(), 4200.0, 1e-14);
    assert!((body.center_of_mass() - Point3::new(1.0, 2.0, 3.0)).norm() < 1e-14);
    let moments = Vector3::new(13.0, 10.0, 5.0) * (4200.0 / 12.0);
    let expected = moments.component_mul(&Vector3::new(0.3, -0.2, 0.5));
    assert!((body.angular_momentum() - expected).norm() < 1e-13 * expected.norm());
    within(body.kinetic_energy(), 0.5 * expected.dot(&Vector3::new(0.3, -0.2, 0.5)), 1e-14);
    assert_eq!(body.linear_momentum(), Vector3::zeros());
}

#[test]
fn a_bare_lattice_has_the_mass_and_the_inertia_of_its_vertices() {
    let cells: Vec<_> = supple_tests::block([3, 2, 2]);
    let lattice = || Lattice::from_cells(&cells, 0.5, Point3::new(1.0, 0.0, 0.0), false).unwrap();
    let spun =
        |rigid: bool| Body::from_lattice(lattice()).rigid(rigid).spin([1.0, 2.0, -0.5]).build().unwrap();
    let (rigid, soft) = (spun(true), spun(false));
    within(rigid.mass(), soft.mass(), 1e-12);
    assert!((rigid.center_of_mass() - soft.center_of_mass()).norm() < 1e-12);
    // The velocities of the soft body are f32.
    let expected = soft.angular_momentum();
    assert!((rigid.angular_momentum() - expected).norm() < 1e-6 * expected.norm());
}

/// The velocity at the end of each step moves the body: c = c₀ + n h v₀ + n (n + 1)/2 h² g.
#[test]
fn free_fall_is_exact() {
    let (dt, steps) = (1.0 / 64.0, 640);
    let body = cuboid([1.0, 0.5, 0.25]).velocity([3.0, 8.0, -1.0]).spin([1.0, 2.0, 3.0]).build().unwrap();
    let mut simulation = Simulation::builder().body(body).dt(dt).threads(1).build().unwrap();
    simulation.steps(steps);
    let n = steps as f64;
    let fallen = Vector3::y() * (G * dt * dt * n * (n + 1.0) / 2.0);
    let expected = Vector3::new(3.0, 8.0, -1.0) * (n * dt) - fallen;
    let error = (simulation.body(0).center_of_mass().coords - expected).norm();
    assert!(error < 1e-11 * expected.norm(), "{error}");
}

/// The angular momentum is a constant of the integration. A box that spins about its middle axis tumbles: the axis turns
/// over again and again.
#[test]
fn a_torque_free_box_keeps_its_angular_momentum_and_its_energy_and_tumbles() {
    let body = cuboid([1.0, 2.0, 3.0]).spin([0.02, 6.0, 0.01]).velocity([1.0, 2.0, 3.0]).build().unwrap();
    let mut simulation = in_space(body);
    let (momentum, angular) = {
        let body = simulation.body(0);
        (body.linear_momentum(), body.angular_momentum())
    };
    let energy = simulation.body(0).kinetic_energy();
    let mut sides = Vec::new();
    for _ in 0..600 {
        simulation.step();
        let body = simulation.body(0);
        assert!((body.linear_momentum() - momentum).norm() == 0.0);
        assert!((body.angular_momentum() - angular).norm() <= 1e-9 * angular.norm());
        within(body.kinetic_energy(), energy, 1e-5);
        let axis = body.rotations()[0] * Vector3::y();
        let side = axis.dot(&angular) > 0.0;
        if sides.last() != Some(&side) {
            sides.push(side);
        }
    }
    assert!(sides.len() >= 3, "{sides:?}");
}

/// The distances of the mesh vertices are those at rest, up to the rounding of f32.
#[test]
fn the_surface_stays_congruent() {
    for skin in [supple::SkinKind::Linear, supple::SkinKind::Smooth] {
        let builder = Body::builder(supple_tests::bust()).rigid(true).skin(skin).spin([1.0, -2.0, 0.5]);
        let mut simulation = in_space(builder.build().unwrap());
        let before = simulation.body(0).surface().positions;
        simulation.steps(137);
        let after = simulation.body(0).surface().positions;
        let (low, high) =
            before.iter().fold((before[0], before[0]), |(low, high), p| (low.inf(p), high.sup(p)));
        let size = (high - low).norm();
        assert!((after[0] - before[0]).norm() > 0.01 * size);
        for (a, b) in [(0, 100), (5, 4000), (321, 1234), (7, 8), (100, 3000)] {
            let change = (after[a] - after[b]).norm() - (before[a] - before[b]).norm();
            assert!(change.abs() < 2e-6 * size, "{change}, {size}");
        }
    }
}

#[test]
fn nothing_of_a_rigid_body_is_to_be_corrected() {
    let mut simulation = in_space(cuboid([1.0; 3]).spin([1.0; 3]).build().unwrap());
    simulation.steps(50);
    let body = simulation.body(0);
    let report = body.volume_report();
    assert_eq!((report.measure, report.lambda, report.capped), (VolumeMeasure::Mesh, 0.0, false));
    within(report.after, report.rest, 1e-6);
    assert_eq!(report.before, report.after);
    assert_eq!(body.elastic_energy(), Some(0.0));
}

/// a = F/M, and the angular acceleration I⁻¹ (r × F + T).
#[test]
fn forces_act_with_the_exact_mass_and_inertia() {
    let (force, torque) = (Vector3::new(3e4, -1e4, 5e3), Vector3::new(2e3, 1e3, -4e3));
    let point = Point3::new(0.5, 1.0, -1.5);
    let moments = Vector3::new(13.0, 10.0, 5.0) * (6000.0 / 12.0);
    let everywhere = Selection::Sphere { center: [0.0; 3], radius: 9.0 };
    let corner = Selection::Box { min: [0.1, 0.4, -2.0], max: [1.0, 1.0, -1.0] };
    for selection in [everywhere, corner] {
        let mut simulation = in_space(cuboid([1.0, 2.0, 3.0]).build().unwrap());
        let force_at =
            Force { point: Some(point.into()), torque: torque.into(), ..<[f64; 3]>::from(force).into() };
        simulation.body_mut(0).apply_force(force_at, &selection).unwrap();
        simulation.step();
        let body = simulation.body(0);
        let expected = (point.coords.cross(&force) + torque) / 60.0;
        assert!((body.linear_momentum() - force / 60.0).norm() < 1e-12 * force.norm());
        assert!((body.angular_momentum() - expected).norm() < 1e-7 * expected.norm());
        let spin = expected.component_div(&moments);
        let before = simulation.body(0).angular_momentum();
        simulation.steps(1);
        assert_eq!(simulation.body(0).angular_momentum(), before);
        let turned = simulation.body(0).rotations()[0];
        let angle = (turned.m32 - turned.m23) / 2.0;
        // The gyroscopic torque changes the spin by a hundredth in the second step.
        within(angle, spin.x * 2.0 / 60.0, 2e-2);
    }
    // Without a point, a force on the whole body does not turn it.
    let body = Body::builder(supple_tests::bust()).rigid(true).build().unwrap();
    let everywhere = Selection::Vertices((0..body.lattice().len() as u32).collect());
    let mut simulation = in_space(body);
    simulation.body_mut(0).apply_force([1.0, 2.0, 3.0], &everywhere).unwrap();
    simulation.step();
    let body = simulation.body(0);
    let turned = body.angular_momentum().norm() / (body.linear_momentum().norm() * 1.0);
    assert!(turned < 1e-7, "{turned}");
}

#[test]
fn a_resting_body_presses_on_a_collider_with_its_weight_and_falls_asleep() {
    for size in [[1.0; 3], [0.3, 1.0, 0.6]] {
        let body = cuboid(size).translate([0.0, size[1] / 2.0 + 0.05, 0.0]).build().unwrap();
        let weight = body.mass() * G;
        let builder = Simulation::builder().body(body).collider(ground()).dt(1.0 / 60.0).threads(1);
        let mut simulation = builder.build().unwrap();
        simulation.steps(120);
        let force = contact_force(&simulation, 0);
        assert!((force - Vector3::y() * weight).norm() < 1e-4 * weight, "{force} {weight}");
        let place = simulation.body(0).center_of_mass();
        assert!((place - Point3::new(0.0, size[1] / 2.0, 0.0)).norm() < 2e-3, "{place}");
        simulation.steps(120);
        assert!(simulation.body(0).is_asleep());
        let force = contact_force(&simulation, 0);
        assert!((force - Vector3::y() * weight).norm() < 1e-4 * weight, "{force} {weight}");
        simulation.body_mut(0).apply_force([0.9 * weight, 0.0, 0.0], &Selection::Vertices(vec![0])).unwrap();
        simulation.steps(3);
        assert!(!simulation.body(0).is_asleep());
    }
}

/// Returns a soft cube on the ground with a rigid one above it.
fn stack(density: f64, threads: usize) -> Simulation {
    let soft = mesh_of(plain_box([-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]));
    let soft = Body::builder(soft).name("soft").lattice_vertices(500).preset(Preset::Rubber).build().unwrap();
    let rigid = cuboid([0.5; 3]).name("rigid").density(density).translate([0.0, 1.27, 0.0]).build().unwrap();
    let builder = Simulation::builder().body(soft).body(rigid).collider(ground()).dt(1.0 / 120.0);
    builder.sleep(false).threads(threads).build().unwrap()
}

#[test]
fn a_resting_body_presses_on_a_soft_one_with_its_weight() {
    for density in [1000.0, 4000.0] {
        let mut simulation = stack(density, 1);
        let weight = simulation.body(1).mass() * G;
        simulation.steps(900);
        let force = contact_force(&simulation, 1);
        assert!((force - Vector3::y() * weight).norm() < 1e-4 * weight, "{density}: {force} {weight}");
        let place = simulation.body(1).center_of_mass();
        assert!(place.y > 1.1 && place.y < 1.26 && place.x.abs() + place.z.abs() < 0.02, "{place}");
        let total = weight + simulation.body(0).mass() * G;
        let below = contact_force(&simulation, 0) + force;
        assert!((below.y - total).abs() < 2e-3 * total, "{below} {total}");
    }
}

/// Returns a block on a slope of the angle a about z after a time, with its speed along the slope.
fn on_slope(tangent: f64, friction: f64, steps: u64) -> f64 {
    let angle = f64::atan(tangent);
    let (normal, along) = ([-angle.sin(), angle.cos(), 0.0], Vector3::new(angle.cos(), angle.sin(), 0.0));
    let height = Vector3::from(normal) * 0.101;
    let body = cuboid([0.4, 0.2, 0.4]).rotate([0.0, 0.0, angle.to_degrees()]).translate(height.into());
    let body = body.rolling_resistance(0.0).build().unwrap();
    let slope = Collider { friction, ..Collider::plane([0.0; 3], normal) };
    let builder = Simulation::builder().body(body).collider(slope).dt(1.0 / 120.0).threads(1);
    let mut simulation = builder.build().unwrap();
    simulation.steps(steps);
    simulation.body(0).linear_momentum().dot(&along) / simulation.body(0).mass()
}

#[test]
fn a_block_on_a_slope_sticks_below_the_angle_of_friction_and_slides_above_it() {
    let stuck = on_slope(0.45, 0.5, 240).abs();
    assert!(stuck < 1e-4, "{stuck}");
    for (tangent, friction) in [(0.6, 0.5), (0.5, 0.2), (0.3, 0.0)] {
        let gained = on_slope(tangent, friction, 240) - on_slope(tangent, friction, 120);
        let cos = 1.0 / f64::sqrt(1.0 + tangent * tangent);
        within(-gained, G * cos * (tangent - friction), 0.01);
    }
}

#[test]
fn a_collision_with_a_free_soft_body_keeps_the_momenta() {
    let soft = mesh_of(plain_box([-0.5; 3], [0.5; 3]));
    let soft = Body::builder(soft).name("soft").lattice_vertices(300).build().unwrap();
    let rigid = cuboid([0.6, 0.4, 0.5]).name("rigid").translate([1.2, 0.15, -0.1]).velocity([-4.0, 0.0, 0.0]);
    let rigid = rigid.spin([0.0, 0.0, 2.0]).density(2000.0).build().unwrap();
    let builder = Simulation::builder().body(soft).body(rigid).gravity([0.0; 3]).dt(1.0 / 240.0);
    let mut simulation = builder.threads(1).build().unwrap();
    let sums = |simulation: &Simulation| {
        let bodies = [simulation.body(0), simulation.body(1)];
        let linear: Vector3<f64> = bodies.iter().map(|body| body.linear_momentum()).sum();
        let moment = |body: &supple::BodyRef| {
            body.angular_momentum() + body.center_of_mass().coords.cross(&body.linear_momentum())
        };
        let angular: Vector3<f64> = bodies.iter().map(moment).sum();
        (linear, angular)
    };
    let (linear, angular) = sums(&simulation);
    let before = simulation.body(1).linear_momentum();
    for _ in 0..240 {
        simulation.step();
        let (p, l) = sums(&simulation);
        assert!((p - linear).norm() < 1e-6 * linear.norm(), "{}", (p - linear).norm() / linear.norm());
        assert!((l - angular).norm() < 1e-5 * linear.norm(), "{}", (l - angular).norm() / linear.norm());
    }
    assert!((simulation.body(1).linear_momentum() - before).norm() > 0.3 * before.norm());
}

/// A ball of the restitution e reaches e² of the height of its fall.
#[test]
fn restitution_is_the_ratio_of_the_speeds() {
    for e in [0.5, 0.8, 0.0] {
        let body =
            Body::builder(supple_tests::ball(0.2)).rigid(true).translate([0.0, 1.2, 0.0]).build().unwrap();
        let plane = Collider { restitution: e, ..ground() };
        let builder = Simulation::builder().body(body).collider(plane).dt(1.0 / 480.0).threads(1);
        let mut simulation = builder.build().unwrap();
        let start = simulation.body(0).center_of_mass().y;
        let (mut low, mut top) = (start, 0.0_f64);
        for _ in 0..800 {
            simulation.step();
            let height = simulation.body(0).center_of_mass().y;
            if height > low {
                top = top.max(height);
            } else if top == 0.0 {
                low = height;
            }
        }
        let bounced = (top - low).max(0.0) / (start - low);
        assert!((bounced - e * e).abs() < 0.05 * e * e + 1e-3, "{e}: {bounced}");
    }
}

/// Two rigid bodies of different masses meet head-on: e = (v₂' - v₁')/(v₁ - v₂).
#[test]
fn two_rigid_bodies_exchange_their_momenta() {
    let at = |name: &str, x: f64, density: f64| {
        cuboid([1.0; 3]).name(name).translate([x, 0.0, 0.0]).density(density).restitution(0.5).friction(0.0)
    };
    let a = at("a", 0.0, 1000.0).velocity([2.0, 0.0, 0.0]).build().unwrap();
    let b = at("b", 1.3, 3000.0).build().unwrap();
    let builder = Simulation::builder().body(a).body(b).gravity([0.0; 3]).dt(1.0 / 240.0).threads(1);
    let mut simulation = builder.build().unwrap();
    simulation.steps(120);
    let speed = |body: usize| simulation.body(body).linear_momentum().x / simulation.body(body).mass();
    // (m₁ v₁ ∓ e m v₁)/(m₁ + m₂)
    within(speed(0), (2000.0 - 0.5 * 3000.0 * 2.0) / 4000.0, 1e-3);
    within(speed(1), (2000.0 + 0.5 * 1000.0 * 2.0) / 4000.0, 1e-3);
}

#[test]
fn a_stack_of_rigid_bodies_stands_and_falls_asleep() {
    let cube = |k: usize| {
        cuboid([0.5; 3])
            .name(format!("cube {k}"))
            .translate([0.0, 0.251 + 0.501 * k as f64, 0.0])
            .build()
            .unwrap()
    };
    let builder = (0..3).map(cube).fold(Simulation::builder(), supple::SimulationBuilder::body);
    let mut simulation = builder.collider(ground()).dt(1.0 / 120.0).threads(1).build().unwrap();
    simulation.steps(600);
    for k in 0..3 {
        let place = simulation.body(k).center_of_mass();
        assert!((place - Point3::new(0.0, 0.25 + 0.5 * k as f64, 0.0)).norm() < 5e-3, "{k}: {place}");
    }
    assert!((0..3).all(|k| simulation.body(k).is_asleep()));
}

/// Returns the vertex of a lattice that is nearest to a point.
fn vertex_at(body: &Body, point: [f64; 3]) -> u32 {
    let point = Point3::from(point);
    let distance = |p: &Point3<f64>| (p - point).norm();
    let positions = body.positions();
    let nearest =
        (0..positions.len()).min_by(|&a, &b| distance(&positions[a]).total_cmp(&distance(&positions[b])));
    nearest.unwrap() as u32
}

/// A rod hangs from one vertex: T = 2π √(I_p/(M g d)) for small angles.
#[test]
fn a_vertex_that_is_held_is_a_ball_joint() {
    let mut body = cuboid([0.1, 1.0, 0.1]).lattice_vertices(100).build().unwrap();
    let vertex = vertex_at(&body, [0.0, 0.5, 0.0]);
    let pivot = body.positions()[vertex as usize];
    let distance = pivot.coords.norm();
    body.pin(&Pin {
        goal: None,
        selection: Selection::Vertices(vec![vertex]),
        window: TimeWindow::default(),
    })
    .unwrap();
    let (dt, amplitude) = (1.0 / 240.0, 0.05);
    // The spin with which it swings to the amplitude.
    let about_pivot = (0.01 + 1.0) / 12.0 + distance * distance;
    let omega = (G * distance / about_pivot).sqrt();
    let spin = amplitude * omega;
    let lever = body.center_of_mass() - pivot;
    let velocities: Vec<_> =
        body.positions().iter().map(|p| (Vector3::z() * spin).cross(&(p - pivot))).collect();
    body.set_velocities(&velocities).unwrap();
    let mut simulation = Simulation::builder().body(body).dt(dt).threads(1).sleep(false).build().unwrap();
    let mut crossings = Vec::new();
    let (mut greatest, mut last) = (0.0_f64, 0.0);
    let side = (Vector3::z()).cross(&lever).normalize();
    let mut late = 0.0_f64;
    for step in 1..=4800 {
        simulation.step();
        let arm = simulation.body(0).center_of_mass() - pivot;
        assert!((arm.norm() - lever.norm()).abs() < 1e-6, "{}", arm.norm() - lever.norm());
        let angle = arm.dot(&side) / arm.norm();
        if last < 0.0 && angle >= 0.0 {
            crossings.push(dt * (step as f64 - angle / (angle - last)));
        }
        greatest = greatest.max(angle);
        if step > 3600 {
            late = late.max(angle);
        }
        last = angle;
    }
    let count = crossings.len() - 1;
    let period = (crossings[count] - crossings[0]) / count as f64;
    within(period, std::f64::consts::TAU / omega, 2e-3);
    within(greatest, amplitude, 0.02);
    // It swings on without damping.
    within(late, greatest, 0.01);
}

/// Two vertices are a hinge: the body turns about their line, and its other ends meet the ground.
#[test]
fn two_vertices_that_are_held_are_a_hinge() {
    let mut body = cuboid([1.0, 0.1, 1.0]).lattice_vertices(300).translate([0.0, 1.0, 0.0]).build().unwrap();
    let vertices = [[-0.5, 1.0, -0.5], [-0.5, 1.0, 0.5]].map(|point| vertex_at(&body, point));
    let held = vertices.map(|vertex| body.positions()[vertex as usize]);
    let mut sorted = vertices.to_vec();
    sorted.sort_unstable();
    body.pin(&Pin { goal: None, selection: Selection::Vertices(sorted), window: TimeWindow::default() })
        .unwrap();
    let mut simulation = Simulation::builder().body(body).dt(1.0 / 240.0).threads(1).build().unwrap();
    simulation.steps(60);
    for (vertex, before) in vertices.into_iter().zip(held) {
        assert!((simulation.body(0).positions()[vertex as usize] - before).norm() < 1e-6);
    }
    let center = simulation.body(0).center_of_mass();
    assert!(center.y < 0.95 && center.z.abs() < 1e-6, "{center}");
    // The force on the hinge: the weight and what turns the body.
    let force = simulation.body(0).hold_force(0).unwrap().unwrap().force;
    let weight = simulation.body(0).mass() * G;
    assert!(force.y > 0.1 * weight && force.y < 3.0 * weight, "{force}");
}

#[test]
fn a_handle_moves_the_whole_body() {
    let key =
        |time: f64, y: f64, degrees: f64| Key { time, translate: [0.0, y, 0.0], rotate: [0.0, degrees, 0.0] };
    let handle = Handle {
        goal: None,
        selection: Selection::Box { min: [0.1, -1.0, -1.0], max: [1.0, 1.0, 1.0] },
        motion: vec![key(0.0, 0.0, 0.0), key(1.0, 2.0, 90.0)].into(),
        window: TimeWindow { start: 0.0, end: 1.0 },
    };
    let body = cuboid([1.0, 0.4, 0.4]).handle(handle).build().unwrap();
    let mut simulation = Simulation::builder().body(body).dt(1.0 / 60.0).threads(1).build().unwrap();
    let weight = simulation.body(0).mass() * G;
    simulation.steps(30);
    let turned = simulation.body(0).rotations()[0];
    within(turned.m13, 0.5_f64.sqrt(), 1e-4);
    assert!((simulation.body(0).linear_momentum().y / simulation.body(0).mass() - 2.0).abs() < 1e-3);
    let hold = simulation.body(0).hold_force(0).unwrap().unwrap();
    within(hold.force.y, weight, 1e-2);
    simulation.steps(30);
    let turned = simulation.body(0).rotations()[0];
    within(turned.m13, 1.0, 1e-4);
    // It flies on with the velocity of the handle.
    let velocity = simulation.body(0).linear_momentum() / simulation.body(0).mass();
    simulation.step();
    let after = simulation.body(0).linear_momentum() / simulation.body(0).mass();
    assert!((after - velocity + Vector3::y() * (G / 60.0)).norm() < 1e-9, "{velocity} {after}");
}

#[test]
fn results_are_the_same_bits_for_any_number_of_threads_and_after_a_restart() {
    let run = |threads: usize| {
        let mut simulation = stack(2000.0, threads);
        simulation.steps(150);
        simulation
    };
    let (one, mut two) = (run(1), run(2));
    assert_eq!(one.state(), two.state());
    let saved = two.state();
    two.steps(150);
    let mut restored = stack(2000.0, 1);
    restored.restore(&saved).unwrap();
    restored.steps(150);
    assert_eq!(restored.state(), two.state());
}

#[test]
fn states_of_sleeping_bodies_that_are_held_restart_with_the_same_bits() {
    let build = || {
        let mut body = cuboid([0.2, 1.0, 0.2]).name("rod").lattice_vertices(100).build().unwrap();
        let vertex = vertex_at(&body, [0.0, 0.5, 0.0]);
        body.pin(&Pin {
            goal: None,
            selection: Selection::Vertices(vec![vertex]),
            window: TimeWindow::default(),
        })
        .unwrap();
        let ball = Body::builder(supple_tests::ball(0.1)).rigid(true).name("ball");
        let ball = ball.translate([-3.0, 0.5, 0.0]).velocity([2.0, 0.0, 0.0]).build().unwrap();
        let gravity = [0.0, -1.0, 0.0];
        Simulation::builder()
            .body(body)
            .body(ball)
            .gravity(gravity)
            .dt(1.0 / 120.0)
            .threads(1)
            .build()
            .unwrap()
    };
    let mut whole = build();
    whole.steps(100);
    assert!(whole.body(0).is_asleep());
    let saved = whole.state();
    whole.steps(200);
    let mut restored = build();
    restored.restore(&saved).unwrap();
    restored.steps(200);
    assert_eq!(restored.state(), whole.state());
    assert!(!whole.body(0).is_asleep());
}

#[test]
fn positions_and_velocities_that_are_set_move_the_whole_body() {
    let mut body = cuboid([1.0, 0.5, 0.25]).build().unwrap();
    let turn = nalgebra::Rotation3::from_scaled_axis(Vector3::new(0.3, 0.5, -0.2));
    let moved: Vec<_> = body.positions().iter().map(|p| turn * p + Vector3::new(1.0, 2.0, 3.0)).collect();
    body.set_positions(&moved).unwrap();
    let error = body.positions().iter().zip(&moved).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(error < 1e-6, "{error}");
    assert!((body.center_of_mass() - Point3::new(1.0, 2.0, 3.0)).norm() < 1e-6);
    let (velocity, spin) = (Vector3::new(1.0, 0.0, -2.0), Vector3::new(0.0, 3.0, 1.0));
    let velocities: Vec<_> =
        moved.iter().map(|p| velocity + spin.cross(&(p - Point3::new(1.0, 2.0, 3.0)))).collect();
    body.set_velocities(&velocities).unwrap();
    assert!((body.linear_momentum() / body.mass() - velocity).norm() < 1e-6);
    let error = body.velocities().iter().zip(&velocities).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(error < 1e-5, "{error}");
}

#[test]
fn settings_of_bodies_that_deform_are_errors() {
    let builder = || cuboid([1.0; 3]);
    let zone = Zone::new(Selection::Vertices(vec![0]), 2.0);
    let cases = [
        (builder().youngs_modulus(1e5), "youngs_modulus"),
        (builder().preset(Preset::Jelly), "material"),
        (builder().half_width(2), "half_width or stiffness"),
        (builder().poisson_ratio(0.3), "poisson_ratio"),
        (builder().damping_ratio(0.1), "damping_ratio or damping_rate"),
        (builder().region_damping(0.1), "region_damping"),
        (builder().plastic(supple::Plasticity::default()), "plastic"),
        (builder().fracture(supple::FractureOptions::new(supple::BreakLimit::Strain(0.1))), "fracture"),
        (builder().inflate(1.1), "inflate"),
        (builder().volume(VolumeMeasure::Mesh), "volume"),
        (builder().zone(zone), "zone"),
    ];
    for (builder, expected) in cases {
        match builder.build() {
            Err(Error::Rigid(RigidError::Setting { key })) => assert_eq!(key, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
    let error = builder().build().unwrap().cut([0.0; 3], [1.0, 0.0, 0.0]).unwrap_err();
    assert!(error.to_string().contains("rigid"), "{error}");
}

/// A ball that rolls without slip is slowed by rolling resistance, and by nothing else.
#[test]
fn a_ball_rolls_and_rolling_resistance_slows_it() {
    let rolled = |resistance: f64| {
        let body = Body::builder(supple_tests::ball(0.5)).rigid(true).rolling_resistance(resistance);
        let body =
            body.translate([0.0, 0.5, 0.0]).velocity([1.0, 0.0, 0.0]).spin([0.0, 0.0, -2.0]).build().unwrap();
        let builder = Simulation::builder().body(body).collider(ground()).dt(1.0 / 120.0).threads(1);
        let mut simulation = builder.build().unwrap();
        simulation.steps(120);
        simulation.body(0).linear_momentum().x / simulation.body(0).mass()
    };
    let (free, slowed) = (rolled(0.0), rolled(0.3));
    // The faces of the ball cost some speed.
    assert!((free - 1.0).abs() < 0.1, "{free}");
    assert!(slowed < 0.9 * free, "{slowed} {free}");
}

/// A body that begins inside a collider leaves it without a speed.
#[test]
fn a_body_inside_a_collider_leaves_it_as_a_whole() {
    let body = cuboid([0.5; 3]).translate([0.0, -0.2, 0.0]).build().unwrap();
    let builder = Simulation::builder().body(body).collider(ground()).dt(1.0 / 60.0).threads(1);
    let mut simulation = builder.build().unwrap();
    let mut fastest = 0.0_f64;
    for _ in 0..240 {
        simulation.step();
        fastest = fastest.max(simulation.body(0).linear_momentum().norm() / simulation.body(0).mass());
    }
    let height = simulation.body(0).center_of_mass().y;
    assert!((height - 0.25).abs() < 5e-3, "{height}");
    assert!(fastest < 1.0, "{fastest}");
}

/// A field that is the same everywhere does not turn a body.
#[test]
fn a_uniform_field_moves_the_center_of_mass_alone() {
    let body = Body::builder(supple_tests::bust()).rigid(true).build().unwrap();
    let builder = Simulation::builder().body(body).gravity([0.0; 3]).dt(1.0 / 60.0).threads(1);
    let builder = builder.field(supple::Field::new(supple::FieldLaw::Gravity([1.0, -2.0, 0.5])));
    let mut simulation = builder.build().unwrap();
    simulation.steps(60);
    let body = simulation.body(0);
    let velocity = body.linear_momentum() / body.mass();
    assert!((velocity - Vector3::new(1.0, -2.0, 0.5)).norm() < 1e-9, "{velocity}");
    // The positions of the vertices are rounded to f32.
    let turned = body.angular_momentum().norm() / body.linear_momentum().norm();
    assert!(turned < 1e-6, "{turned}");
}

/// A plane is searched only near the body; with a ball far away it is searched in each step.
#[test]
fn a_rigid_body_is_searched_wherever_it_may_touch() {
    let run = |others: &[Collider]| {
        let body = cuboid([1.0, 0.6, 0.3]).translate([0.0, 2.0, 0.0]).spin([3.0, 1.0, -2.0]).restitution(0.7);
        let empty = Simulation::builder().body(body.build().unwrap()).dt(1.0 / 120.0).sleep(false);
        let ground = Collider { restitution: 0.7, ..ground() };
        let builder =
            others.iter().cloned().fold(empty.collider(ground), supple::SimulationBuilder::collider);
        let mut simulation = builder.build().unwrap();
        let mut contacts = Vec::new();
        for _ in 0..360 {
            simulation.step();
            contacts.push(simulation.contacts().len());
        }
        (simulation.body(0).positions(), contacts)
    };
    let (positions, contacts) = run(&[]);
    let (with_ball, contacts_with_ball) = run(&[Collider::sphere([0.0, -1e3, 0.0], 1.0)]);
    assert!(contacts.contains(&0) && contacts.iter().any(|&count| count > 0));
    assert_eq!(contacts, contacts_with_ball);
    assert!(positions == with_ball);
}
