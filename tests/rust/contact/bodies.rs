//! Contact between bodies, of a body with itself, and of bodies that rest on each other.

use nalgebra::{Point3, Vector3};
use supple::{
    Accuracy, Body, BodyBuilder, Collider, Handle, Key, Lattice, Mesh, Pin, Selection, Simulation,
    SimulationBuilder, Substeps, TimeWindow, Touched,
};

use supple_tests::{block, sphere, surface_of};

/// A cube of edge 1 with `n` cells along each axis, centered at the origin, with a mesh.
fn cube(n: i32) -> BodyBuilder {
    boxed([n; 3], 1.0 / f64::from(n))
}

/// A box of cells with a mesh of their faces, centered at the origin.
fn boxed(cells: [i32; 3], cell_size: f64) -> BodyBuilder {
    let (vertices, faces) = surface_of(&block(cells));
    let center = cells.map(|n| f64::from(n) / 2.0);
    let place = |p: [f64; 3]| std::array::from_fn(|a| (p[a] - center[a]) * cell_size);
    let mesh = Mesh::new(vertices.into_iter().map(place).collect(), &faces).unwrap();
    Body::builder(mesh).cell_size(cell_size).youngs_modulus(1e5)
}

/// A ball with a mesh.
fn ball(radius: f64, cell_size: f64) -> BodyBuilder {
    let (vertices, faces) = sphere([0.0; 3], radius, 12);
    Body::builder(Mesh::new(vertices, &faces).unwrap()).cell_size(cell_size).youngs_modulus(1e5)
}

fn floating() -> SimulationBuilder {
    Simulation::builder().gravity([0.0; 3]).dt(1.0 / 240.0).sleep(false)
}

fn on_ground() -> SimulationBuilder {
    Simulation::builder().collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
}

/// Linear momentum, angular momentum about the origin, Σ m |v|, Σ m |x| |v|, and the kinetic and elastic energy.
fn totals(sim: &Simulation) -> (Vector3<f64>, Vector3<f64>, f64, f64, f64) {
    let mut sums = (Vector3::zeros(), Vector3::zeros(), 0.0, 0.0, 0.0);
    for (index, body) in sim.bodies().iter().enumerate() {
        for ((x, v), m) in body.positions().iter().zip(body.velocities()).zip(body.masses()) {
            sums.0 += v * m;
            sums.1 += x.coords.cross(&v) * m;
            sums.2 += m * v.norm();
            sums.3 += m * v.norm() * x.coords.norm();
        }
        sums.4 += body.kinetic_energy() + sim.body(index).elastic_energy().unwrap();
    }
    sums
}

/// All vertices.
fn everything() -> Selection {
    Selection::Box { min: [-10.0; 3], max: [10.0; 3] }
}

/// The number of contacts between bodies.
fn contacts_between(sim: &Simulation) -> usize {
    sim.contacts().iter().filter(|contact| matches!(contact.other, Touched::Body(_))).count()
}

#[test]
fn collision_keeps_momenta_and_adds_no_energy() {
    for (friction, damping) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.2)] {
        // Positions and velocities are half a step apart, so that the energy of the fastest modes, which regions of one cell
        // have, varies from step to step.
        let set = |body: BodyBuilder| body.friction(friction).damping_ratio(damping).accuracy(Accuracy::Fast);
        let first = set(cube(6)).translate([-0.7, 0.0, 0.0]).rotate([10.0, 20.0, 5.0]);
        let second = set(ball(0.5, 0.13)).translate([0.7, 0.3, 0.1]).density(700.0);
        let mut sim = floating()
            .body(first.velocity([1.0, 0.0, 0.0]).spin([0.0, 1.0, 0.5]).build().unwrap())
            .body(second.velocity([-1.0, 0.0, 0.0]).spin([0.3, 0.0, 1.0]).build().unwrap())
            .build()
            .unwrap();
        sim.step();
        let (p, l, mv, mvr, energy) = totals(&sim);
        let mut touched = false;
        for _ in 0..240 {
            sim.step();
            touched |= contacts_between(&sim) > 0;
            let now = totals(&sim);
            // The velocities are f32: each has a relative rounding error of 6e-8.
            assert!((now.0 - p).norm() < 1e-7 * mv, "{friction} {damping}: {}", (now.0 - p).norm() / mv);
            assert!((now.1 - l).norm() < 1e-6 * mvr, "{friction} {damping}: {}", (now.1 - l).norm() / mvr);
            assert!(now.4 < 1.0001 * energy, "{friction} {damping}: energy {}", now.4 / energy);
        }
        assert!(touched);
        let [left, right] = [0, 1].map(|body| sim.bodies()[body].center_of_mass().x);
        assert!(left < right - 0.8, "they pass through each other: {left}, {right}");
    }
}

#[test]
fn tower_stands_and_sleeps_and_wakes_as_one() {
    let place = |k: usize| [0.1 * (k % 2) as f64, 0.5 + 1.001 * k as f64, 0.0];
    let level =
        |k: usize| cube(6).youngs_modulus(4e6).translate(place(k)).rotate([0.0, 20.0 * k as f64, 0.0]);
    let mut sim = on_ground().fps(60.0).substeps(Substeps::Fixed(4));
    for k in 0..3 {
        sim = sim.body(level(k).name(format!("level{k}")).build().unwrap());
    }
    let mut sim = sim.build().unwrap();
    let asleep = |sim: &Simulation| sim.bodies().iter().filter(|body| body.is_asleep()).count();
    let mut frame = 0;
    while asleep(&sim) == 0 {
        sim.advance(1);
        frame += 1;
        assert!(frame < 600, "the tower is not at rest after 10 s");
    }
    assert_eq!(asleep(&sim), 3);
    for (k, body) in sim.bodies().iter().enumerate() {
        let moved = body.center_of_mass() - Point3::from(place(k));
        assert!(moved.norm() < 0.1, "level {k} moved by {moved}");
    }
    // The contacts carry the weight above them, and remain while the tower sleeps.
    sim.advance(1);
    let weight: f64 = sim.bodies().iter().map(|body| body.mass() * 9.81).sum();
    let carried = |other: Touched, body: usize| -> f64 {
        let all = sim.contacts();
        all.iter().filter(|c| c.other == other && c.body == body).map(|c| c.force.y).sum()
    };
    let ground = carried(Touched::Collider(0), 0);
    assert!((ground - weight).abs() < 0.01 * weight, "{ground} of {weight}");
    let [lower, upper] = [carried(Touched::Body(1), 0), carried(Touched::Body(2), 1)];
    assert!((lower + weight * 2.0 / 3.0).abs() < 0.01 * weight, "{lower} of {weight}");
    assert!((upper + weight / 3.0).abs() < 0.01 * weight, "{upper} of {weight}");
    // A push on the top wakes all.
    sim.bodies_mut()[2]
        .apply_force([9e3, 0.0, 0.0], &Selection::Sphere { center: [0.0, 2.5, 0.0], radius: 0.6 })
        .unwrap();
    sim.steps(2);
    assert_eq!(asleep(&sim), 0);
}

#[test]
fn soft_tower_stands() {
    // A column of this elasticity and density buckles by its own weight from a height of 4.8 on (Euler: the third power of
    // the height is 7.84 E I / (ρ g A), with I/A = 1/12). If the impulses of a step are not exact enough, it tilts slowly.
    let place = |k: usize| [0.02 * (k % 3) as f64, 0.5 + 1.001 * k as f64, 0.02 * (k % 2) as f64];
    let mut sim = on_ground().fps(30.0).substeps(Substeps::Fixed(10));
    for k in 0..4 {
        let level = cube(4).youngs_modulus(1.7e6).translate(place(k)).rotate([0.0, 17.0 * k as f64, 0.0]);
        sim = sim.body(level.name(format!("level{k}")).build().unwrap());
    }
    let mut sim = sim.build().unwrap();
    sim.advance(450);
    for (k, body) in sim.bodies().iter().enumerate() {
        let moved = body.center_of_mass() - Point3::from(place(k));
        // The height of a soft column shrinks by ρ g L / 2 E of its length: 5 cm here.
        assert!(moved.norm() < 0.3, "level {k} moved by {moved}");
    }
}

/// Some bodies that fall on each other.
fn heap(threads: usize) -> Simulation {
    let mut sim = on_ground().fps(60.0).substeps(Substeps::Fixed(2)).threads(threads);
    for k in 0..5 {
        let at = [0.2 * f64::from(k % 2), 0.7 + 1.05 * f64::from(k), 0.1 * f64::from(k % 3)];
        let body = if k % 2 == 0 { cube(5) } else { ball(0.5, 0.2).self_contact(true) };
        sim = sim.body(body.translate(at).rotate([13.0 * f64::from(k), 29.0, 7.0]).build().unwrap());
    }
    sim.build().unwrap()
}

type Outcome = Vec<(Vec<Point3<f64>>, Vec<Vector3<f64>>)>;

fn outcome(sim: &Simulation) -> Outcome {
    sim.bodies().iter().map(|body| (body.positions(), body.velocities())).collect()
}

#[test]
fn touching_bodies_have_the_same_bits_for_any_number_of_threads_and_after_restore() {
    let mut sim = heap(1);
    sim.advance(40);
    let state = sim.state();
    assert!(contacts_between(&sim) > 0);
    sim.advance(40);
    let one = outcome(&sim);
    for threads in [2, 3, 8] {
        let mut sim = heap(threads);
        sim.advance(80);
        assert!(outcome(&sim) == one, "{threads} threads differ from one");
    }
    for mut other in [sim, heap(2)] {
        other.restore(&state).unwrap();
        other.advance(40);
        assert!(outcome(&other) == one);
    }
}

#[test]
fn restored_bodies_that_rest_on_each_other_continue_with_the_same_bits() {
    // Bodies that move little are not searched in each step.
    let mut sim = on_ground().fps(60.0).substeps(Substeps::Fixed(2)).sleep(false);
    for k in 0..2 {
        let at = [0.1 * f64::from(k), 0.5 + 1.001 * f64::from(k), 0.0];
        sim = sim.body(cube(5).youngs_modulus(1e6).translate(at).build().unwrap());
    }
    let mut sim = sim.build().unwrap();
    sim.advance(150);
    let state = sim.state();
    let begin = outcome(&sim);
    let mut ends = Vec::new();
    for _ in 0..2 {
        for _ in 0..7 {
            sim.step();
            assert!(contacts_between(&sim) > 0);
        }
        ends.push(outcome(&sim));
        sim.restore(&state).unwrap();
    }
    assert!(ends[0] == ends[1]);
    let moved = |(a, b): (&Point3<f64>, &Point3<f64>)| (a - b).norm() < 0.02 * 0.2;
    let same_place = ends[0].iter().zip(&begin).all(|(a, b)| a.0.iter().zip(&b.0).all(moved));
    assert!(same_place, "the bodies moved too far for the search to be left out");
}

#[test]
fn slow_bodies_touch_before_they_are_deep_in_each_other() {
    // The upper body is lowered so slowly that it is searched every tenth step or so.
    let (speed, dt, cell_size) = (0.05, 1.0 / 240.0, 0.2);
    let held = |body: BodyBuilder, [low, high]: [f64; 2], keys: Vec<Key>| {
        let mut body = body.build().unwrap();
        let selection = Selection::Box { min: [-1.0, low, -1.0], max: [1.0, high, 1.0] };
        body.handle(&Handle { goal: None, selection, motion: keys.into(), window: TimeWindow::default() })
            .unwrap();
        body
    };
    let end = Key { time: 2.0, translate: [0.0, -2.0 * speed, 0.0], ..Key::default() };
    let lower = held(cube(5), [-0.6, -0.3], vec![Key::default()]);
    let upper = held(cube(5).translate([0.0, 1.02, 0.0]), [1.3, 1.6], vec![Key::default(), end]);
    let mut sim = floating().body(lower).body(upper).build().unwrap();
    let mut touched = false;
    for step in 0..480 {
        sim.step();
        touched |= contacts_between(&sim) > 0;
        let deepest = sim.contacts().iter().map(|contact| contact.depth).fold(0.0, f64::max);
        // Each body may move by 0.02 cells before a search, one of them by as much again before that of the other one.
        let limit = 3.0 * 0.02 * cell_size + speed * dt;
        assert!(deepest <= limit, "step {step}: {deepest} of {limit}");
    }
    assert!(touched);
}

#[test]
fn bodies_that_slide_on_another_one_bounce_off_each_other() {
    // Each moves by 0.008 cells in a step, so that only bodies that bounce need a search in each step.
    for phase in 0..4 {
        let mut sim = Simulation::builder().dt(1.0 / 600.0).sleep(false);
        let mut floor = boxed([12, 1, 6], 0.25).restitution(0.0).friction(0.0).build().unwrap();
        floor.pin(&Pin { goal: None, selection: everything(), window: TimeWindow::default() }).unwrap();
        sim = sim.body(floor);
        for side in [-1.0, 1.0] {
            let x = side * (0.56 + f64::from(phase) / 600.0);
            // Wide regions, so that the layer that bounces has a share of the mass.
            let body = cube(5)
                .youngs_modulus(1e6)
                .accuracy(Accuracy::Fast)
                .restitution(1.0)
                .friction(0.0)
                .damping_ratio(1.0);
            let body = body.translate([x, 0.626, 0.0]).velocity([-side, 0.0, 0.0]);
            sim = sim.body(body.build().unwrap());
        }
        let mut sim = sim.build().unwrap();
        sim.steps(120);
        let speed = |body: usize| sim.bodies()[body].linear_momentum().x / sim.bodies()[body].mass();
        // The damping leaves no elastic bounce: without that of the contact, they would move together.
        let apart = speed(2) - speed(1);
        assert!(apart > 0.2, "phase {phase}: {apart}");
    }
}

#[test]
fn a_ball_that_slides_down_another_one_leaves_it_where_its_speed_carries_it() {
    let mut sim = Simulation::builder().dt(1.0 / 960.0).sleep(false);
    // Balls of flat faces leave each other at edges.
    let smooth = |radius: f64, cell_size: f64| {
        let (vertices, faces) = sphere([0.0; 3], radius, 96);
        let body = Body::builder(Mesh::new(vertices, &faces).unwrap()).cell_size(cell_size);
        body.friction(0.0).youngs_modulus(1e7).damping_ratio(1.0)
    };
    let mut hill = smooth(1.0, 0.25).build().unwrap();
    hill.pin(&Pin { goal: None, selection: everything(), window: TimeWindow::default() }).unwrap();
    let start = 0.25_f64;
    let center = Vector3::new(start.sin(), start.cos(), 0.0) * 1.5;
    let slider = smooth(0.5, 0.15).translate(center.into()).build().unwrap();
    sim = sim.body(hill).body(slider);
    let mut sim = sim.build().unwrap();
    let mut last = 0.0_f64;
    for _ in 0..1440 {
        sim.step();
        if contacts_between(&sim) > 0 {
            let center = sim.bodies()[1].center_of_mass();
            last = center.y.atan2(center.x);
        }
    }
    // A point that slides leaves a ball where gravity no longer bends its path so much: 3 cos θ = 2 cos θ₀. It may leave at
    // an edge before: a face spans 0.065.
    let expected = (2.0 * start.cos() / 3.0).asin();
    assert!((last - expected).abs() < 0.065, "{last}, {expected}");
}

#[test]
fn bodies_that_are_woken_keep_their_contacts() {
    let mut sim = on_ground().fps(60.0).substeps(Substeps::Fixed(4));
    for k in 0..3 {
        let height = [0.5, 1.501, 4.0][k];
        let mut body = cube(5).youngs_modulus(2e6).translate([0.0, height, 0.0]).build().unwrap();
        if k == 2 {
            let window = TimeWindow { start: 0.0, end: 5.0 };
            body.pin(&Pin { goal: None, selection: everything(), window }).unwrap();
        }
        sim = sim.body(body);
    }
    let mut sim = sim.build().unwrap();
    sim.advance(299);
    let asleep = |sim: &Simulation| [0, 1].map(|body| sim.bodies()[body].is_asleep());
    let lower = |sim: &Simulation| {
        let all = sim.contacts();
        let pressing = all.iter().filter(|c| c.body == 0 && c.other == Touched::Body(1));
        (pressing.clone().count(), pressing.map(|c| c.force.norm()).sum::<f64>())
    };
    assert_eq!(asleep(&sim), [true; 2]);
    let (count, force) = lower(&sim);
    // The third body falls on the second one, which wakes up, and in the next step the first one.
    let mut steps = 0;
    while asleep(&sim) != [false; 2] {
        sim.step();
        steps += 1;
        assert!(steps < 400, "nothing wakes the bodies");
    }
    let (awake_count, awake_force) = lower(&sim);
    assert!(awake_count >= count / 2, "{awake_count} contacts of {count}");
    assert!(awake_force > 0.9 * force, "{awake_force} of {force}");
}

#[test]
fn held_bodies_that_overlap_stay_stable() {
    // Both bodies are in the same place, so that their contacts contradict each other.
    let mut sim = floating();
    for _ in 0..2 {
        let mut body = cube(5).build().unwrap();
        let at = |low: f64, high: f64| Selection::Box { min: [-1.0, low, -1.0], max: [1.0, high, 1.0] };
        body.pin(&Pin { goal: None, selection: at(-0.6, -0.3), window: TimeWindow::default() }).unwrap();
        let end = Key { time: 1.0, translate: [0.0, 0.5, 0.0], ..Key::default() };
        let keys = vec![Key::default(), end];
        body.handle(&Handle {
            goal: None,
            selection: at(0.3, 0.6),
            motion: keys.into(),
            window: TimeWindow::default(),
        })
        .unwrap();
        sim = sim.body(body);
    }
    let mut sim = sim.build().unwrap();
    for step in 0..360 {
        sim.step();
        // The handles stretch the bodies from 1 to 1.5; nothing throws a vertex out of the box around them.
        let inside = |p: &Point3<f64>| p.x.abs() < 1.0 && p.z.abs() < 1.0 && p.y.abs() < 1.5;
        assert!(sim.bodies().iter().all(|body| body.positions().iter().all(inside)), "step {step}");
    }
}

#[test]
fn pile_in_a_bin_falls_asleep() {
    let wall = |x: f64, z: f64| Collider::plane([-0.9 * x, 0.0, -0.9 * z], [x, 0.0, z]);
    let mut sim = on_ground().fps(60.0).substeps(Substeps::Fixed(2));
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        sim = sim.collider(wall(x, z));
    }
    for k in 0..4 {
        let k = f64::from(k);
        let body = cube(5).youngs_modulus(1e6).translate([0.2 * k.sin(), 0.8 + 1.2 * k, 0.2 * k.cos()]);
        sim = sim.body(body.rotate([13.0 * k, 29.0 * k, 7.0 * k]).build().unwrap());
    }
    let mut sim = sim.build().unwrap();
    let mut frame = 0;
    while !sim.bodies().iter().all(Body::is_asleep) {
        sim.advance(1);
        frame += 1;
        assert!(frame < 600, "the pile is not at rest after 10 s");
    }
}

#[test]
fn fast_bodies_and_thin_plates_do_not_pass_each_other() {
    for cells in [[8, 8, 8], [1, 8, 8]] {
        let body = |x: f64| boxed(cells, 0.125).translate([x, 0.03 * x, 0.0]).rotate([0.0, 0.0, 3.0]);
        let mut sim = Simulation::builder().gravity([0.0; 3]).dt(1.0 / 60.0);
        for x in [-1.3, 1.3] {
            // 10 m/s relative to each other, 0.17 m or 1.3 cells in a step.
            sim = sim.body(body(x).velocity([-5.0 * x.signum(), 0.0, 0.0]).build().unwrap());
        }
        let mut sim = sim.build().unwrap();
        for step in 0..90 {
            sim.step();
            let [left, right] = [0, 1].map(|body| sim.bodies()[body].center_of_mass().x);
            assert!(left < right, "{cells:?} changed sides in step {step}: {left}, {right}");
        }
        let apart = sim.bodies()[1].center_of_mass().x - sim.bodies()[0].center_of_mass().x;
        assert!(apart > 1.2, "{cells:?} stuck: {apart}");
    }
}

#[test]
fn bodies_that_begin_in_each_other_are_reported_and_pushed_apart() {
    let depth = 1.5 * 0.125;
    let mut sim = Simulation::builder().gravity([0.0; 3]).dt(1.0 / 60.0).sleep(false);
    for x in [0.0, 1.0 - depth] {
        sim = sim.body(cube(8).translate([x, 0.02 * x, 0.01 * x]).build().unwrap());
    }
    let mut sim = sim.build().unwrap();
    let overlaps = sim.overlapping_bodies();
    assert!(matches!(overlaps[..], [(0, 1, found)] if (found - depth).abs() < 1e-6), "{overlaps:?}");
    let mass: f64 = sim.bodies().iter().map(Body::mass).sum();
    for _ in 0..30 {
        sim.step();
        assert!(totals(&sim).4 < 0.15 * mass, "{} J/kg", totals(&sim).4 / mass);
    }
    assert!(sim.overlapping_bodies().is_empty(), "{:?}", sim.overlapping_bodies());
}

#[test]
fn contact_can_be_left_out_for_a_pair_and_for_a_simulation() {
    let pair = |ignore: &str, contact: bool| {
        let first =
            cube(4).name("first").translate([-0.6, 0.0, 0.0]).velocity([2.0, 0.0, 0.0]).ignore(ignore);
        let second = cube(4).name("second").translate([0.6, 0.0, 0.0]).velocity([-2.0, 0.0, 0.0]);
        let sim = floating().contact(contact).body(first.build().unwrap()).body(second.build().unwrap());
        let mut sim = sim.build().unwrap();
        sim.steps(240);
        (sim.bodies()[0].center_of_mass().x > 1.0, sim.plan())
    };
    assert!(!pair("another", true).0);
    assert!(pair("second", true).0);
    assert!(pair("first", false).0);
}

#[test]
fn parts_of_a_body_touch_each_other_only_if_enabled() {
    // A horseshoe whose ends are pressed together.
    let mut cells: Vec<[i32; 3]> = Vec::new();
    for y in 0..4 {
        for z in 0..2 {
            cells.extend((0..10).map(|x| [x, y, z]).filter(|[x, y, _]| *x < 2 || *y == 0 || *y == 3));
        }
    }
    let run = |enabled: bool| {
        let lattice = Lattice::from_cells(&cells, 0.1, Point3::origin(), false).unwrap();
        let mut body = Body::from_lattice(lattice).youngs_modulus(3e4).self_contact(enabled).build().unwrap();
        let lower = Selection::Box { min: [0.75, -0.01, -1.0], max: [1.1, 0.11, 1.0] };
        body.pin(&Pin { goal: None, selection: lower, window: TimeWindow::default() }).unwrap();
        let upper = Selection::Box { min: [0.75, 0.39, -1.0], max: [1.1, 0.41, 1.0] };
        let keys = vec![Key::default(), Key { time: 1.0, translate: [0.0, -0.28, 0.0], ..Key::default() }];
        body.handle(&Handle {
            goal: None,
            selection: upper,
            motion: keys.into(),
            window: TimeWindow::default(),
        })
        .unwrap();
        let mut sim = Simulation::builder().body(body).gravity([0.0; 3]).dt(1.0 / 240.0).build().unwrap();
        sim.steps(10);
        assert_eq!(sim.contacts().len(), 0, "nothing touches at rest");
        sim.steps(230);
        let positions = sim.bodies()[0].positions();
        let lattice = sim.bodies()[0].lattice();
        // The inner sides of both ends, which face each other.
        let height = |y: i32| {
            let index = lattice.indices().iter().position(|index| *index == [9, y, 1]).unwrap();
            positions[index].y
        };
        (height(3) - height(1), sim.contacts().len())
    };
    let (gap, contacts) = run(true);
    assert!(gap > -0.005 && contacts > 0, "{gap} {contacts}");
    let (gap, contacts) = run(false);
    assert!(gap < -0.02 && contacts == 0, "{gap} {contacts}");
}

#[test]
fn deformed_bodies_do_not_touch_themselves_where_they_do_not_overlap() {
    let lattice = Lattice::from_cells(&block([8, 5, 5]), 1.0, Point3::origin(), false).unwrap();
    let deformations: [fn(Point3<f64>) -> Point3<f64>; 4] = [
        |p| p,
        |p| Point3::new(p.x, 0.1 * p.y, p.z),
        |p| Point3::new(-p.z, p.y, p.x),
        // A bend with the radius 8 of the middle line.
        |p| Point3::new((8.0 - p.y) * (p.x / 8.0).sin(), 8.0 - (8.0 - p.y) * (p.x / 8.0).cos(), p.z),
    ];
    for (index, deform) in deformations.into_iter().enumerate() {
        let body = Body::from_lattice(lattice.clone()).self_contact(true).build().unwrap();
        let mut sim = Simulation::builder().body(body).gravity([0.0; 3]).dt(1e-4).build().unwrap();
        let positions: Vec<_> = sim.bodies()[0].positions().into_iter().map(deform).collect();
        sim.body_mut(0).set_positions(&positions).unwrap();
        sim.step();
        assert_eq!(sim.contacts().len(), 0, "deformation {index}");
    }
}

#[test]
fn a_sheet_carries_a_ball_on_either_side() {
    let n = 12;
    let coordinate = |i: u32| 1.6 * (f64::from(i) / f64::from(n) - 0.5);
    let vertices: Vec<_> =
        (0..(n + 1) * (n + 1)).map(|k| [coordinate(k % (n + 1)), 0.0, coordinate(k / (n + 1))]).collect();
    let corners = |k: u32| {
        let a = k / n * (n + 1) + k % n;
        [a, a + n + 1, a + n + 2, a + 1]
    };
    for flipped in [false, true] {
        let faces: Vec<[u32; 4]> = (0..n * n)
            .map(corners)
            .map(|[a, b, c, d]| if flipped { [d, c, b, a] } else { [a, b, c, d] })
            .collect();
        let mut sheet = Body::builder(Mesh::new(vertices.clone(), &faces).unwrap()).cell_size(0.1);
        for side in [-1.0, 1.0] {
            let selection = Selection::Plane { point: [0.75 * side, 0.0, 0.0], normal: [side, 0.0, 0.0] };
            sheet = sheet.pin(Pin { goal: None, selection, window: TimeWindow::default() });
        }
        let ball = ball(0.3, 0.1).density(300.0).translate([0.0, 0.45, 0.0]);
        let sim = Simulation::builder().fps(60.0).substeps(Substeps::Fixed(4));
        let sim = sim.body(sheet.youngs_modulus(1e5).build().unwrap()).body(ball.build().unwrap());
        let mut sim = sim.build().unwrap();
        for frame in 0..90 {
            sim.advance(1);
            let ball = sim.bodies()[1].center_of_mass();
            let lowest = sim.bodies()[0].positions().iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
            assert!(ball.y > lowest + 0.1, "flipped {flipped}: the ball is through in frame {frame}");
        }
    }
}

/// Two boxes of one body, of which the upper one lies on the lower one, and a block that is cut in two halves.
fn stacks() -> [(&'static str, Body); 2] {
    let mut cells = block([6, 3, 6]);
    cells.extend(block([4, 3, 4]).into_iter().map(|[x, y, z]| [x + 1, y + 4, z + 1]));
    let lattice = Lattice::from_cells(&cells, 0.1, Point3::origin(), false).unwrap();
    let boxes = Body::from_lattice(lattice).youngs_modulus(1e5).self_contact(true);
    let mut halves =
        boxed([6, 6, 6], 0.1).translate([0.0, 0.3, 0.0]).velocity([3.0, 0.0, 0.0]).build().unwrap();
    halves.cut([0.0, 0.3, 0.0], [0.2, 1.0, 0.0]).unwrap();
    [("boxes", boxes.velocity([3.0, 0.0, 0.0]).build().unwrap()), ("halves", halves)]
}

fn on_floor(body: Body, friction: f64) -> Simulation {
    let mut floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    floor.friction = friction;
    Simulation::builder().body(body).collider(floor).fps(60.0).substeps(Substeps::Fixed(4)).build().unwrap()
}

#[test]
fn bodies_that_touch_themselves_slide_on_ice_without_falling_asleep() {
    for (name, body) in stacks() {
        let mut sim = on_floor(body, 0.0);
        let mut saved = None;
        for frame in 0..150 {
            sim.advance(1);
            let velocities = sim.bodies()[0].velocities();
            let speed = velocities.iter().map(|v| v.x).sum::<f64>() / velocities.len() as f64;
            assert!((speed - 3.0).abs() < 0.01, "{name}, frame {frame}: {speed} units per second");
            if frame == 60 {
                saved = Some(postcard::to_stdvec(&sim.state()).unwrap());
            }
        }
        assert!(!sim.contacts().is_empty(), "{name}: the parts touch each other");
        let end = sim.bodies()[0].positions();
        sim.restore(&postcard::from_bytes(&saved.unwrap()).unwrap()).unwrap();
        sim.advance(89);
        assert!(sim.bodies()[0].positions() == end, "{name}: the same bits after a restore");
    }
}

#[test]
fn a_cut_body_falls_asleep_where_friction_stops_it() {
    let [_, (_, mut halves)] = stacks();
    // Regions of one cell let vertices at the edges of the cut jump to and fro by 5e-4 cells a step.
    halves.set_accuracy(Accuracy::Fast);
    let mut sim = on_floor(halves, 0.5);
    let mut frame = 0;
    while !sim.bodies()[0].is_asleep() {
        sim.advance(1);
        frame += 1;
        assert!(frame < 300, "the halves are not at rest after 5 s");
    }
    // It slides for more than half a second before.
    assert!(frame > 60, "{frame}");
}

/// Contacts act however little of them is free: two blocks that lie side by side and are held entirely have the same ones as
/// free ones.
#[test]
fn held_bodies_keep_all_contacts() {
    let contacts = |is_held: bool| {
        let bodies = [-0.499, 0.499].map(|x| {
            let mut body = cube(4).translate([x, 0.0, 0.0]).build().unwrap();
            if is_held {
                body.pin(&Pin { goal: None, selection: everything(), window: TimeWindow::default() })
                    .unwrap();
            }
            body
        });
        let [first, second] = bodies;
        let mut sim = floating().body(first).body(second).build().unwrap();
        sim.step();
        contacts_between(&sim)
    };
    assert!(contacts(false) > 0);
    assert_eq!(contacts(true), contacts(false));
}
