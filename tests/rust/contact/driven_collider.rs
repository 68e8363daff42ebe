//! Driven colliders: friction carries bodies, the motion is linear, counts steps, and is part of the state.

use nalgebra::{Point3, Vector3};
use supple::{Body, Collider, Error, Key, Lattice, Material, Simulation, euler_degrees};
use supple_tests::{block, half_cells, rms};

const DT: f64 = 1.0 / 120.0;
const GRAVITY: f64 = 10.0;
const FRICTION: f64 = 0.5;
const CELL: f64 = 0.5;

/// A box whose upper face is at y = 0.
fn platform() -> Collider {
    Collider { friction: FRICTION, ..Collider::cuboid([0.0, -1.0, 0.0], [30.0, 1.0, 30.0], [0.0; 3]) }
}

/// Returns a block of 4 x 2 x 4 cells at rest on a collider, with its corner at (`x`, 0, -1).
fn resting(x: f64, collider: Collider) -> Simulation {
    let corner = Point3::new(x, 0.0, -2.0 * CELL);
    let lattice = Lattice::from_cells(&block([4, 2, 4]), CELL, corner, false).unwrap();
    let body = Body::from_lattice(lattice)
        .material(Material::fast_lsm())
        .half_width(4)
        .region_damping(0.3)
        .damping_ratio(0.2)
        .build()
        .unwrap();
    let world = Simulation::builder().body(body).collider(collider).gravity([0.0, -GRAVITY, 0.0]);
    let mut simulation = world.dt(DT).threads(1).sleep(false).build().unwrap();
    simulation.steps(120);
    simulation
}

fn center(simulation: &Simulation) -> Vector3<f64> {
    let positions = simulation.body(0).positions();
    positions.iter().map(|p| p.coords).sum::<Vector3<f64>>() / positions.len() as f64
}

/// Returns the bits of the positions and velocities of the body.
fn bits(simulation: &Simulation) -> Vec<[u64; 3]> {
    let body = simulation.body(0);
    let positions = body.positions().into_iter().map(|p| p.coords);
    positions.chain(body.velocities()).map(|v| <[f64; 3]>::from(v).map(f64::to_bits)).collect()
}

#[test]
fn a_driven_platform_carries_a_resting_box_except_for_the_slip_of_coulomb_friction() {
    let mut simulation = resting(-1.0, platform());
    let start = center(&simulation);
    let (speed, seconds) = (1.0, 2.0);
    for step in 1..=(seconds / DT).round() as u32 {
        let x = speed * f64::from(step) * DT;
        simulation.collider_mut(0).move_to([x, 0.0, 0.0], [0.0; 3]).unwrap();
        assert!((simulation.collider(0).velocity()[0] - speed).abs() < 1e-9);
        simulation.step();
    }
    // The platform starts at full speed v. Friction accelerates the box by mu g, until after v / (mu g) it has
    // the speed of the platform, and has slipped by v^2 / (2 mu g).
    let slip = speed * speed / (2.0 * FRICTION * GRAVITY);
    let moved = center(&simulation) - start;
    // The sum over steps differs from the integral by at most v dt; 0.01 cells are for the deformation of the box.
    assert!((speed * seconds - moved.x - slip).abs() < speed * DT + 0.01 * CELL, "{moved}");
    assert!(moved.yz().norm() < 0.01 * CELL, "{moved}");
}

#[test]
fn a_platform_that_accelerates_within_the_friction_cone_carries_a_box_without_slip() {
    let mut simulation = resting(-1.0, platform());
    let start = center(&simulation);
    let acceleration = 0.5 * FRICTION * GRAVITY;
    let pose = |time: f64| [0.5 * acceleration * time * time, 0.0, 0.0];
    for step in 1..=240 {
        simulation.collider_mut(0).move_to(pose(f64::from(step) * DT), [0.0; 3]).unwrap();
        simulation.step();
    }
    let moved = center(&simulation) - start;
    let lag = pose(240.0 * DT)[0] - moved.x;
    assert!(lag.abs() < 0.01 * CELL, "{lag}");
    // Flesh sways for about a second.
    simulation.steps(360);
    let velocities = simulation.body(0).velocities();
    let speed = rms(velocities.iter().map(|v| v.norm()));
    assert_eq!(simulation.collider(0).velocity(), [0.0; 3]);
    assert!(speed < 0.01, "the box keeps the speed {speed} on a platform at rest");
}

#[test]
fn a_turning_platform_turns_what_lies_on_it() {
    let mut simulation = resting(1.0, platform());
    let before = simulation.body(0).positions();
    let start = center(&simulation);
    simulation.collider_mut(0).move_to_in([0.0; 3], [0.0, 90.0, 0.0], 2.5).unwrap();
    let rate = 36.0_f64.to_radians();
    assert!((Vector3::from(simulation.collider(0).spin()) - Vector3::new(0.0, rate, 0.0)).norm() < 1e-9);
    simulation.steps(300);
    assert_eq!(simulation.collider(0).rotation(), [0.0, 90.0, 0.0]);
    assert_eq!(simulation.collider(0).spin(), [0.0; 3]);

    let turn = euler_degrees([0.0, 90.0, 0.0]);
    let radius = start.xz().norm();
    let speed = rate * radius;
    // In the frame of the platform the Coriolis force is perpendicular to the velocity u of the box, so friction
    // and the centrifugal force give d|u|/dt <= -(mu g - rate^2 r). `r` exceeds the radius by less than the slip.
    let deceleration = FRICTION * GRAVITY - rate * rate * (radius + CELL);
    let slip = speed * speed / (2.0 * deceleration);
    assert!(slip < CELL);
    let error = (center(&simulation) - turn * start).norm();
    assert!(error < slip + speed * DT + 0.01 * CELL, "{error}");
    // Sliding and spinning relative to the platform end together (Farkas et al. 2003).
    let lag = rate * (speed / deceleration + DT);
    let edge = before[4] - before[0];
    let after = simulation.body(0).positions();
    let angle = (turn * edge).angle(&(after[4] - after[0]));
    assert!(edge.norm() > CELL && angle < lag, "{angle}");
}

#[test]
fn move_to_before_each_step_gives_the_bits_of_a_keyframe_for_each_step() {
    let pose = |step: u32| {
        let t = f64::from(step) * DT;
        ([0.3 * (6.0 * t).sin(), 0.05 * t, 0.4 * t * t], [3.0 * t, 400.0 * t, -2.0 * t])
    };
    let key = |step| {
        let (translate, rotate) = pose(step);
        Key { time: f64::from(step) * DT, translate, rotate }
    };
    let keys = Collider { keys: (0..=300).map(key).collect(), ..platform() };
    let build = |collider| {
        let lattice = Lattice::from_cells(&block([4, 2, 4]), CELL, Point3::origin(), false).unwrap();
        let world = Simulation::builder().body(Body::from_lattice(lattice).build().unwrap()).dt(DT);
        world.collider(collider).threads(1).build().unwrap()
    };
    let (mut keyed, mut driven) = (build(keys), build(platform()));
    for step in 1..=300 {
        let (translate, rotate) = pose(step);
        driven.collider_mut(0).move_to(translate, rotate).unwrap();
        assert_eq!(driven.collider(0).velocity(), keyed.collider(0).velocity());
        assert_eq!(driven.collider(0).spin(), keyed.collider(0).spin());
        keyed.step();
        driven.step();
        assert_eq!(bits(&driven), bits(&keyed), "step {step}");
        assert_eq!(driven.body(0).corrected_positions(), keyed.body(0).corrected_positions());
    }
}

#[test]
fn a_duration_gives_a_linear_motion_in_whole_steps_and_then_rest() {
    let end = Key { time: 60.0 * DT, translate: [1.0, -2.0, 3.0], rotate: [0.0, 900.0, 10.0] };
    let keys = vec![Key::default(), end];
    let mut keyed = resting(0.0, Collider { keys, ..platform() });
    keyed.set_time(0.0).unwrap();
    let mut driven = resting(0.0, platform());
    driven.collider_mut(0).move_to_in(end.translate, end.rotate, end.time).unwrap();
    for step in 1..=70 {
        keyed.step();
        driven.step();
        // Each of n steps rounds the remaining time and the pose: at most n^2 2^-52 of the way in all.
        let bound = 900.0 * 3600.0 * f64::EPSILON;
        for (a, b) in [
            (driven.collider(0).translation(), keyed.collider(0).translation()),
            (driven.collider(0).rotation(), keyed.collider(0).rotation()),
        ] {
            let error = (Vector3::from(a) - Vector3::from(b)).amax();
            assert!(error < bound, "step {step}: {error:e}");
        }
        assert_eq!(driven.collider(0).translation() == end.translate, step >= 60, "step {step}");
        assert_eq!(driven.collider(0).velocity() == [0.0; 3], step >= 60, "step {step}");
    }

    // Durations of whole steps take that number of steps in spite of rounding; others are rounded up.
    for (dt, duration, count) in
        [(1.0 / 240.0, 1.0 / 60.0, 4), (0.01, 10.0, 1000), (0.1, 0.25, 3), (0.1, 0.01, 1)]
    {
        driven.set_dt(dt).unwrap();
        driven.collider_mut(0).move_to_in([0.0; 3], [0.0; 3], duration).unwrap();
        let steps = (1..=count + 1).find(|_| {
            driven.step();
            driven.collider(0).translation() == [0.0; 3]
        });
        assert_eq!(steps, Some(count), "{duration} s in steps of {dt} s");
        driven.collider_mut(0).move_to([0.0, -5.0, 0.0], [0.0; 3]).unwrap();
        driven.step();
    }
    driven.set_dt(0.1).unwrap();
    driven.collider_mut(0).move_to_in([0.0, -6.0, 0.0], [0.0; 3], 0.25).unwrap();
    let mut speeds = [0.0; 4];
    for speed in &mut speeds {
        *speed = -driven.collider(0).velocity()[1];
        driven.step();
    }
    let error = (nalgebra::Vector4::from(speeds) - nalgebra::Vector4::new(4.0, 4.0, 2.0, 0.0)).amax();
    assert!(error < 1e-12, "{speeds:?}");
}

#[test]
fn the_last_of_several_calls_counts_and_the_first_of_several_steps_takes_the_motion() {
    let mut one = resting(0.0, platform());
    let mut two = resting(0.0, platform());
    one.collider_mut(0).move_to_in([9.0, 9.0, 9.0], [90.0; 3], 4.0).unwrap();
    one.collider_mut(0).move_to([0.01, 0.02, 0.0], [0.0, 5.0, 0.0]).unwrap();
    two.collider_mut(0).move_to([0.01, 0.02, 0.0], [0.0, 5.0, 0.0]).unwrap();
    one.steps(3);
    two.step();
    assert_eq!(two.collider(0).translation(), [0.01, 0.02, 0.0]);
    assert_eq!((two.collider(0).velocity(), two.collider(0).spin()), ([0.0; 3], [0.0; 3]));
    two.steps(2);
    assert_eq!(bits(&one), bits(&two));

    // The angles are interpolated: from 350 to 10 degrees the platform turns back, to 370 degrees forward.
    for (target, halfway) in [(350.0, 177.5), (10.0, 180.0), (350.0, 180.0), (370.0, 360.0)] {
        one.collider_mut(0).move_to_in([0.0; 3], [0.0, target, 0.0], 2.0 * DT).unwrap();
        one.step();
        assert_eq!(one.collider(0).rotation(), [0.0, halfway, 0.0]);
        one.step();
    }
}

#[test]
fn driving_replaces_keyframes_from_the_current_pose_on() {
    let key = |time, x| Key { time, translate: [x, 0.0, 0.0], rotate: [0.0; 3] };
    let mut simulation = resting(0.0, Collider { keys: vec![key(0.0, 0.0), key(4.0, 4.0)], ..platform() });
    let before = simulation.state();
    assert_eq!(simulation.collider(0).translation(), [1.0, 0.0, 0.0]);
    let speed = simulation.collider(0).velocity()[0];
    assert!((speed - 1.0).abs() < 1e-9, "{speed}");
    simulation.collider_mut(0).move_to_in([1.0, 0.5, 0.0], [0.0; 3], 2.0 * DT).unwrap();
    simulation.step();
    assert_eq!(simulation.collider(0).translation(), [1.0, 0.25, 0.0]);
    // Neither the time nor its changes act on the motion.
    simulation.set_time(77.0).unwrap();
    simulation.steps(50);
    assert_eq!(simulation.collider(0).translation(), [1.0, 0.5, 0.0]);
    assert_eq!(simulation.collider(0).description().keys.len(), 2);

    // A state from before brings the keyframes back. New colliders are not driven.
    simulation.restore(&before).unwrap();
    simulation.steps(120);
    assert_eq!(simulation.collider(0).translation(), [2.0, 0.0, 0.0]);
    simulation.collider_mut(0).move_to([7.0; 3], [0.0; 3]).unwrap();
    simulation.set_colliders(&[platform(), platform()]).unwrap();
    simulation.step();
    assert_eq!(simulation.collider_count(), 2);
    assert_eq!(simulation.collider(1).translation(), [0.0; 3]);
}

#[test]
fn a_state_in_mid_motion_continues_bit_for_bit() {
    let mut one = resting(0.0, platform());
    one.collider_mut(0).move_to_in([0.7, 0.3, 0.0], [10.0, 200.0, 0.0], 0.7).unwrap();
    one.steps(33);
    let mut other = resting(0.0, platform());
    other.collider_mut(0).move_to([4.0; 3], [0.0; 3]).unwrap();
    other.restore(&one.state()).unwrap();
    for _ in 0..5 {
        one.steps(20);
        other.steps(20);
        assert_eq!(bits(&one), bits(&other));
        assert_eq!(one.state(), other.state());
    }

    let body = |x| Body::from_lattice(half_cells()).translate([x, 0.0, 0.0]).build().unwrap();
    let mut driven =
        Simulation::builder().body(body(0.0)).collider(platform()).collider(platform()).build().unwrap();
    driven.collider_mut(1).move_to([1.0; 3], [0.0; 3]).unwrap();
    let mut fewer = Simulation::builder().body(body(0.0)).collider(platform()).build().unwrap();
    let error = fewer.restore(&driven.state()).unwrap_err().to_string();
    let expected = "the state does not match the simulation: the simulation has 1 colliders, but in the state \
                    collider 1 is driven";
    assert_eq!(error, expected);
}

#[test]
fn invalid_targets_are_errors_with_the_argument_and_change_nothing() {
    let mut simulation = resting(0.0, platform());
    let before = simulation.state();
    let finite = "finite and at most 1e15 in magnitude";
    let seconds = "a time in seconds, finite and greater than 0";
    let no = [0.0; 3];
    for (translate, rotate, duration, message) in [
        ([0.0, f64::NAN, 0.0], no, 1.0, format!("translate = NaN is out of range: it must be {finite}")),
        ([-2e15, 0.0, 0.0], no, 1.0, format!("translate = -2e15 is out of range: it must be {finite}")),
        (no, [0.0, 0.0, f64::INFINITY], 1.0, format!("rotate = inf is out of range: it must be {finite}")),
        (no, no, 0.0, format!("duration = 0 is out of range: it must be {seconds}")),
        (no, no, -1.0, format!("duration = -1 is out of range: it must be {seconds}")),
        (no, no, f64::NAN, format!("duration = NaN is out of range: it must be {seconds}")),
    ] {
        let error = simulation.collider_mut(0).move_to_in(translate, rotate, duration).unwrap_err();
        assert!(matches!(error, Error::Range(_)));
        assert_eq!(error.to_string(), message);
    }
    assert_eq!(simulation.state(), before);
}
