//! Material, damping and rest: the elastic law, the decay of elastic modes, undamped rigid motion, and sleep.

use std::collections::VecDeque;
use std::f64::consts::PI;

use nalgebra::{Point3, Vector3};
use supple::{
    Accuracy, Body, BodyBuilder, Collider, Damping, Elasticity, Handle, Key, Lattice, Pin, Preset, Selection,
    Simulation, Substeps, TimeWindow,
};

use supple_tests::{block, greatest_distance, mesh_of, sphere};

/// Returns a bar of 1 x 1 x 3 with its lower end at the origin, with `cells` cells per unit of length.
fn bar(cells: i32) -> BodyBuilder {
    let lattice = Lattice::from_cells(
        &block([cells, cells, 3 * cells]),
        1.0 / f64::from(cells),
        Point3::origin(),
        true,
    );
    Body::from_lattice(lattice.unwrap())
}

/// Returns the amplitudes of the lowest stretch mode of a free bar, step by step, in steps of 1/480 s.
fn stretch_amplitudes(body: BodyBuilder, steps: usize) -> Vec<f64> {
    let builder = Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]).dt(1.0 / 480.0);
    let mut simulation = builder.sleep(false).build().unwrap();
    let rest = simulation.body(0).positions();
    let mode = |p: &Point3<f64>| (PI * p.z / 3.0).cos();
    let start: Vec<_> = rest.iter().map(|p| p + Vector3::z() * (0.01 * mode(p))).collect();
    simulation.body_mut(0).set_positions(&start).unwrap();
    let amplitude = |simulation: &Simulation| {
        let positions = simulation.body(0).positions();
        let sum: f64 = positions.iter().zip(&rest).map(|(p, r)| (p.z - r.z) * mode(r)).sum();
        sum / rest.len() as f64
    };
    (0..steps).map(|_| (simulation.step(), amplitude(&simulation)).1).collect()
}

/// Returns the mean angular frequency between the first and the last zero.
fn angular_frequency(amplitudes: &[f64]) -> f64 {
    let zero = |k: usize| {
        let (a, b) = (amplitudes[k - 1], amplitudes[k]);
        (a * b < 0.0).then(|| k as f64 - 1.0 + a / (a - b))
    };
    let zeros: Vec<f64> = (1..amplitudes.len()).filter_map(zero).collect();
    PI * (zeros.len() - 1) as f64 * 480.0 / (zeros[zeros.len() - 1] - zeros[0])
}

/// The frequency of the lowest stretch mode is √(E/ρ)/(2 l) on every lattice. The leapfrog scheme and the regions at the
/// ends change it by less than 1 %.
#[test]
fn youngs_modulus_is_the_same_on_every_lattice() {
    let expected = PI / 3.0 * (1e6_f64 / 1000.0).sqrt();
    for cells in [5, 10, 16] {
        let found =
            angular_frequency(&stretch_amplitudes(bar(cells).youngs_modulus(1e6).damping_ratio(0.0), 480));
        assert!((found / expected - 1.0).abs() < 0.01, "{cells} cells: {found} for {expected}");
    }
}

/// A mode with an angular frequency well above c decays as exp(-c t): 33 rad/s for c = 2 and 4 per second.
#[test]
fn elastic_modes_decay_at_the_damping_rate() {
    for rate in [2.0, 4.0] {
        let amplitudes = stretch_amplitudes(bar(8).youngs_modulus(1e6).damping_rate(rate), 480);
        let peak = |from: usize, to: usize| {
            (from..to).max_by(|&a, &b| amplitudes[a].abs().total_cmp(&amplitudes[b].abs())).unwrap()
        };
        // Each window has more than half a period, 45 steps.
        let (first, last) = (peak(20, 75), peak(400, 455));
        let time = (last - first) as f64 / 480.0;
        let decay = (amplitudes[first] / amplitudes[last]).abs().ln() / time;
        assert!((decay / rate - 1.0).abs() < 0.05, "{decay} for {rate}");
    }
}

#[test]
fn flight_and_spin_are_undamped() {
    let body = bar(4).damping_ratio(1.0).velocity([1.0, 2.0, 3.0]).spin([0.0, 0.0, 5.0]).build().unwrap();
    let builder = Simulation::builder().body(body).gravity([0.0; 3]).fps(60.0).substeps(Substeps::Auto);
    let mut simulation = builder.build().unwrap();
    let before = (simulation.bodies()[0].linear_momentum(), simulation.bodies()[0].angular_momentum());
    simulation.advance(300);
    let after = (simulation.bodies()[0].linear_momentum(), simulation.bodies()[0].angular_momentum());
    assert!((after.0 - before.0).norm() < 1e-6 * before.0.norm(), "{before:?} {after:?}");
    assert!((after.1 - before.1).norm() < 1e-6 * before.1.norm(), "{before:?} {after:?}");
    assert!(!simulation.bodies()[0].is_asleep());
}

/// A bar that lies on the ground, with a plate far away that comes down at 10 s.
fn resting() -> Simulation {
    let keys = vec![
        Key { time: 10.0, ..Key::default() },
        Key { time: 11.0, translate: [0.0, 0.0, -10.0], ..Key::default() },
    ];
    let plate = Collider { keys, ..Collider::cuboid([0.5, 0.5, 13.5], [1.0, 1.0, 0.5], [0.0; 3]) };
    let builder = Simulation::builder().body(bar(4).translate([0.0, 0.0, 0.01]).build().unwrap());
    let builder = builder.gravity([0.0, 0.0, -9.81]).collider(Collider::plane([0.0; 3], [0.0, 0.0, 1.0]));
    let mut simulation = builder.collider(plate).fps(30.0).substeps(Substeps::Auto).build().unwrap();
    let frames = (0..240).position(|_| {
        simulation.advance(1);
        simulation.bodies()[0].is_asleep()
    });
    assert!(frames.is_some_and(|frames| frames >= 15), "asleep after {frames:?} frames");
    simulation
}

#[test]
fn a_body_at_rest_sleeps_without_motion_until_something_moves_it() {
    let mut simulation = resting();
    let before = simulation.bodies()[0].positions();
    simulation.advance(10);
    assert_eq!(simulation.bodies()[0].positions(), before);
    assert_eq!(simulation.bodies()[0].kinetic_energy(), 0.0);

    type Change = fn(&mut Simulation);
    let wakes: [(&str, Change); 7] = [
        ("force", |s| s.body_mut(0).apply_forces(&[(0, [1.0, 0.0, 0.0])]).unwrap()),
        ("gravity", |s| s.set_gravity([0.0, 0.0, -5.0]).unwrap()),
        ("material", |s| s.body_mut(0).set_elasticity(Elasticity::Preset(Preset::Jelly)).unwrap()),
        ("colliders", |s| s.set_colliders(&[]).unwrap()),
        ("driven collider", |s| s.collider_mut(0).move_to([0.0, 0.0, 0.1], [0.0; 3]).unwrap()),
        ("velocities", |s| {
            let velocities = vec![Vector3::x(); s.bodies()[0].positions().len()];
            s.body_mut(0).set_velocities(&velocities).unwrap();
        }),
        ("handle", |s| {
            let selection = Selection::Vertices(vec![0, 1]);
            let keys = vec![Key::default(), Key { time: 100.0, translate: [9.0; 3], ..Key::default() }];
            s.body_mut(0)
                .handle(&Handle { goal: None, selection, motion: keys.into(), window: TimeWindow::default() })
                .unwrap();
        }),
    ];
    for (name, wake) in wakes {
        let mut simulation = resting();
        wake(&mut simulation);
        simulation.step();
        assert!(!simulation.bodies()[0].is_asleep(), "{name}");
    }
}

/// Steps a simulation, with a force on each vertex that `force` returns for the time and the velocity. Returns the number
/// of the step after which the body sleeps, from 1.
fn sleeps_in_step(
    simulation: &mut Simulation,
    steps: usize,
    force: impl Fn(f64, Vector3<f64>) -> Vector3<f64>,
) -> Option<usize> {
    (1..=steps).find(|_| {
        let (time, velocities) = (simulation.time(), simulation.bodies()[0].velocities());
        let forces: Vec<_> = (0..).zip(velocities).map(|(i, v)| (i, force(time, v).into())).collect();
        simulation.body_mut(0).apply_forces(&forces).unwrap();
        simulation.step();
        simulation.bodies()[0].is_asleep()
    })
}

/// The forces on a vertex: a tenth of its mean weight sideways, which friction holds, and a drag towards a wind.
#[test]
fn forces_that_do_not_change_let_a_body_sleep() {
    let mut simulation = resting();
    let body = &simulation.bodies()[0];
    let mass = body.mass() / body.lattice().len() as f64;
    let (before, push) = (body.center_of_mass(), Vector3::new(1.0 * mass, 0.0, 0.0));
    let wind = Vector3::new(0.0, 2.0, 0.0);
    let constant = |_: f64, _: Vector3<f64>| push;
    let drag = |_: f64, velocity: Vector3<f64>| (wind - velocity) * mass;
    let rising = |time: f64, _: Vector3<f64>| push * time;

    assert!(sleeps_in_step(&mut simulation, 6000, constant).is_some_and(|step| step > 10));
    let leaning = simulation.bodies()[0].center_of_mass();
    assert!(leaning.x > before.x + 1e-4, "{leaning} after {before}");
    // Asleep, it stays where it is, and the forces of the steps are not summed up.
    for _ in 0..30 {
        assert_eq!(sleeps_in_step(&mut simulation, 1, constant), Some(1));
    }
    assert_eq!(simulation.bodies()[0].center_of_mass(), leaning);
    let restored = simulation.state();
    simulation.step();
    assert!(!simulation.bodies()[0].is_asleep(), "without the force that it leans against");
    simulation.restore(&restored).unwrap();
    assert_eq!(sleeps_in_step(&mut simulation, 1, constant), Some(1), "a restored state");
    simulation.body_mut(0).apply_forces(&[(5, [0.0, 0.0, 1e-6 * mass])]).unwrap();
    simulation.step();
    assert!(!simulation.bodies()[0].is_asleep(), "other forces");

    assert!(sleeps_in_step(&mut resting(), 6000, drag).is_some());
    // It grows by 0.1 times the weight per second, so that every half second of rest has changes.
    assert_eq!(sleeps_in_step(&mut resting(), 400, rising), None);
}

#[test]
fn a_collider_wakes_a_body_only_when_it_comes_near() {
    let mut simulation = resting();
    while simulation.time() < 10.5 {
        simulation.advance(1);
        assert!(simulation.bodies()[0].is_asleep(), "at {} s", simulation.time());
    }
    // The plate stops above the bar at 11 s.
    simulation.advance(15);
    assert!(!simulation.bodies()[0].is_asleep());
}

/// The body hangs from the pin until 6 s.
#[test]
fn a_pinned_body_sleeps_until_the_pin_ends() {
    let top = Selection::Plane { point: [0.0, 0.0, 2.7], normal: [0.0, 0.0, 1.0] };
    let pin = Pin { goal: None, selection: top, window: TimeWindow { start: 0.0, end: 6.0 } };
    let builder = Simulation::builder().body(bar(4).pin(pin).build().unwrap()).gravity([0.0, 0.0, -9.81]);
    let mut simulation = builder.fps(30.0).substeps(Substeps::Auto).build().unwrap();
    simulation.advance(175);
    assert!(simulation.bodies()[0].is_asleep());
    simulation.advance(10);
    assert!(!simulation.bodies()[0].is_asleep());
}

/// A body at rest on a slope below the angle of friction stays where it is, without damping too, and while it vibrates at
/// several centimeters per second: no force on it leaves the cone of friction.
#[test]
fn an_undamped_body_at_rest_on_a_slope_does_not_creep() {
    let cell = 0.25;
    let lattice = Lattice::from_cells(&block([4, 2, 4]), cell, Point3::origin(), true).unwrap();
    let body = Body::from_lattice(lattice).rotate([0.0, 0.0, 27.0]).build().unwrap();
    let normal = supple::euler_degrees([0.0, 0.0, 27.0]) * Vector3::y();
    let slope = Collider { friction: 1.0, ..Collider::plane([0.0; 3], normal.into()) };
    let builder = Simulation::builder().body(body).collider(slope).gravity([0.0, -9.81, 0.0]).dt(1.0 / 120.0);
    let mut simulation = builder.sleep(false).build().unwrap();
    simulation.steps(600);
    let body = simulation.body_mut(0);
    body.set_damping(Some(Damping::Ratio(0.0))).unwrap();
    let kick = |vertex: usize| Vector3::from_fn(|c, _| 0.2 * ((7 * vertex + 3 * c) as f64).sin());
    let velocities: Vec<_> = body.velocities().iter().enumerate().map(|(k, v)| v + kick(k)).collect();
    body.set_velocities(&velocities).unwrap();
    let center = |simulation: &Simulation| {
        let positions = simulation.body(0).positions();
        positions.iter().map(|p| p.coords).sum::<Vector3<f64>>() / positions.len() as f64
    };
    let start = center(&simulation);
    simulation.steps(3000);
    let moved = (center(&simulation) - start).norm() / cell;
    assert!(moved < 0.02, "{moved} cells");
    let energy = simulation.body(0).kinetic_energy() / simulation.body(0).mass();
    assert!((2.0 * energy).sqrt() > 0.02, "it still vibrates: {energy}");
}

/// Bodies fall asleep at the beginning of a frame. The change of the steps per frame after 7 steps begins one.
#[test]
fn frames_begin_where_the_steps_per_frame_were_set() {
    let builder =
        Simulation::builder().body(bar(4).build().unwrap()).gravity([0.0, 0.0, -9.81]).dt(1.0 / 240.0);
    let ground = Collider::plane([0.0; 3], [0.0, 0.0, 1.0]);
    let mut simulation = builder.collider(ground).substeps(Substeps::Fixed(3)).build().unwrap();
    simulation.steps(7);
    simulation.set_substeps(Substeps::Fixed(50)).unwrap();
    let awake = (0..4000).take_while(|_| {
        simulation.step();
        !simulation.bodies()[0].is_asleep()
    });
    let awake = awake.count();
    assert!(awake < 4000 && awake % 50 == 0, "asleep in step {awake} after the change");
}

/// The automatic steps keep the slip of the touching layer below half a cell, and the weight compresses a cube of jelly
/// (E = 20 ρ L g) by 1/20 at its base. So the next layer, one cell higher at rest, is 0.45 cells above the ground.
#[test]
fn inner_vertices_of_a_soft_body_with_many_cells_stay_above_the_ground() {
    let cell = 1.0 / 15.0;
    let lattice = Lattice::from_cells(&block([15; 3]), cell, Point3::origin(), true).unwrap();
    let jelly = Elasticity::Preset(Preset::Jelly);
    let body = Body::from_lattice(lattice).elasticity(jelly).damping_ratio(0.5).build().unwrap();
    let ground = Collider::plane([0.0; 3], [0.0, 0.0, 1.0]);
    let builder = Simulation::builder().body(body).collider(ground).gravity([0.0, 0.0, -9.81]);
    let mut simulation = builder.fps(30.0).substeps(Substeps::Auto).build().unwrap();
    simulation.advance(60);
    let body = simulation.body(0);
    let indices = body.lattice().indices();
    let heights = body
        .positions()
        .iter()
        .zip(indices)
        .filter(|(_, index)| index[2] > 0)
        .map(|(p, _)| p.z / cell)
        .collect::<Vec<_>>();
    let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((0.45..1.0).contains(&lowest), "{lowest} cells");
}

/// A ball that came to rest moves by less than 1e-4 cells in a step, and overlaps with the floor by less than a sample moves in
/// such a step, whatever its material and its regions.
#[test]
fn a_resting_ball_is_still() {
    let mesh = mesh_of(sphere([0.0; 3], 1.0, 40));
    for preset in [Preset::Flesh, Preset::Jelly, Preset::Rubber] {
        for (ratio, accuracy) in
            [(0.0, Accuracy::Fast), (0.45, Accuracy::Fast), (0.0, Accuracy::Exact), (0.45, Accuracy::Exact)]
        {
            let builder =
                Body::builder(mesh.clone()).lattice_vertices(1000).preset(preset).poisson_ratio(ratio);
            let body = builder.accuracy(accuracy).translate([0.0, 1.02, 0.0]).build().unwrap();
            let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
            let simulation = Simulation::builder().body(body).collider(floor).fps(30.0).sleep(false);
            let mut simulation = simulation.substeps(Substeps::Auto).build().unwrap();
            simulation.advance(300);
            let cell_size = simulation.body(0).lattice().cell_size();
            for _ in 0..40 {
                let before = simulation.body(0).positions();
                simulation.step();
                let moved = greatest_distance(&simulation.body(0).positions(), &before);
                assert!(moved < 1e-4 * cell_size, "{preset:?}, {ratio}, {accuracy:?}: {}", moved / cell_size);
                let contacts = simulation.contacts();
                assert!(
                    !contacts.is_empty() && contacts.iter().all(|contact| contact.depth < 1e-4 * cell_size)
                );
            }
        }
    }
}

/// Lattice vertices outside the surface have little mass, and keep trembling by more than the limit where this bust touches the
/// floor. It sleeps because its mesh stays within the limit.
#[test]
fn a_bust_that_lies_sleeps_when_its_surface_is_still() {
    let mesh = supple_tests::bust();
    let (low, high) = mesh.bounds();
    let extent = (high - low).max();
    // Turned by 90 degrees about x, z points down.
    let builder = Body::builder(mesh).lattice_vertices(4000).scale(1.0 / extent).rotate([90.0, 0.0, 0.0]);
    let body = builder.translate([0.0, 0.3 + high.z / extent, 0.0]).build().unwrap();
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let builder = Simulation::builder().body(body).collider(floor);
    let mut simulation = builder.fps(60.0).substeps(Substeps::Auto).build().unwrap();
    // The last half second, at the beginnings of frames.
    let mut seen: VecDeque<Vec<Point3<f64>>> = VecDeque::new();
    while !simulation.bodies()[0].is_asleep() {
        assert!(simulation.time() < 8.0, "awake after 8 s");
        seen.push_back(simulation.body(0).surface().positions);
        if seen.len() > 29 {
            seen.pop_front();
        }
        simulation.advance(1);
    }
    let moved = seen.iter().map(|positions| greatest_distance(positions, &seen[0])).fold(0.0, f64::max);
    // All frames are within a thousandth of L, which is less than the extent, of one place.
    assert!(seen.len() == 29 && moved < 2e-3, "{moved}");
}

/// The place of a body is checked at the beginnings of frames: time counts only if the body stayed there, however long a frame.
#[test]
fn a_sliding_body_does_not_sleep_in_long_frames() {
    let block = Lattice::from_cells(&block([3, 3, 3]), 0.3, Point3::origin(), true).unwrap();
    let body = Body::from_lattice(block).velocity([1.0, 0.0, 0.0]).build().unwrap();
    let ice = Collider { friction: 0.0, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let builder = Simulation::builder().body(body).collider(ice).fps(1.0).substeps(Substeps::Fixed(60));
    let mut simulation = builder.build().unwrap();
    simulation.advance(3);
    assert!(!simulation.body(0).is_asleep());
    let speed = simulation.body(0).center_of_mass().x - 0.45;
    assert!((speed / 3.0 - 1.0).abs() < 0.01, "{speed} in 3 s");
}

/// What a small overlap adds to the velocities does not grow as steps become shorter: it is at most 12 times the overlap in a
/// second.
#[test]
fn a_small_overlap_is_removed_slowly_at_any_step() {
    for dt in [1.0 / 60.0, 1.0 / 1800.0] {
        let cell = Lattice::from_cells(&block([1, 1, 1]), 1.0, Point3::new(0.0, -0.009, 0.0), true).unwrap();
        let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        let builder = Simulation::builder().body(Body::from_lattice(cell).build().unwrap()).collider(ground);
        let mut simulation = builder.gravity([0.0; 3]).dt(dt).sleep(false).build().unwrap();
        let mut fastest = 0.0_f64;
        for _ in 0..60 {
            simulation.step();
            let speeds = simulation.body(0).velocities();
            fastest = speeds.iter().map(Vector3::norm).fold(fastest, f64::max);
        }
        assert!(fastest > 0.0 && fastest < 12.0 * 0.009 * 1.01, "steps of {dt}: {fastest}");
    }
}
