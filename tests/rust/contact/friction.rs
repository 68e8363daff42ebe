//! Friction: sticking and sliding on slopes, and transport by moving colliders.

use crate::block_body::Block;
use nalgebra::{Matrix3, Point3, Vector3};
use supple::euler_degrees;
use supple::internals::Colliders;
use supple::{Body, Collider, Key, Preset, Simulation, Substeps};

const DT: f64 = 1.0 / 60.0;
const CELL: f64 = 0.3;

fn colliders(list: &[Collider]) -> Colliders {
    Colliders::new(list).unwrap()
}

fn ground() -> Collider {
    Collider::plane([0.0; 3], [0.0, 1.0, 0.0])
}

/// Returns the displacement and the speed down a slope of `degrees` of a block that starts at rest, after
/// `seconds`.
fn on_slope(degrees: f64, friction: f64, seconds: f64) -> (f64, f64) {
    let turn = euler_degrees([0.0, 0.0, degrees]);
    let (downhill, normal) = (turn * -Vector3::x(), turn * Vector3::y());
    let mut block = Block::new([4, 2, 4], CELL, None);
    block.place(&turn, Point3::origin());
    let slope = colliders(&[Collider { friction, ..Collider::plane([0.0; 3], normal.into()) }]);
    let start = block.center();
    block.damping = 0.3;
    for _ in 0..(seconds / DT).round() as u32 {
        block.step(&slope, DT, 1.0);
    }
    ((block.center() - start).dot(&downhill), block.mean_velocity().dot(&downhill))
}

#[test]
fn a_block_sticks_inside_the_friction_cone_and_accelerates_as_coulomb_outside_it() {
    for degrees in [10.0_f64, 20.0, 30.0] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let tangent = sine / cosine;
        let (settled, _) = on_slope(degrees, 1.2 * tangent, 2.0);
        let (moved, speed) = on_slope(degrees, 1.2 * tangent, 10.0);
        // Regression bounds: the block settles at first; then it does not creep.
        assert!(settled.abs() < 0.25 * CELL, "{degrees}: moved {settled}");
        assert!((moved - settled).abs() < 1e-3 * CELL && speed.abs() < 1e-3, "{degrees}: creeps {moved}");

        for part in [0.0, 0.5, 0.8] {
            // Coulomb: the acceleration is g (sin - mu cos).
            let expected = 9.81 * (sine - part * tangent * cosine);
            let (_, early) = on_slope(degrees, part * tangent, 1.5);
            let (_, late) = on_slope(degrees, part * tangent, 3.5);
            let measured = (late - early) / 2.0;
            assert!((measured / expected - 1.0).abs() < 1e-3, "{degrees} {part}: {measured} of {expected}");
        }
    }
}

#[test]
fn moving_colliders_carry_resting_bodies_at_their_own_velocity() {
    let key = |time, x, turn| Key { time, translate: [x, 0.0, 0.0], rotate: [0.0, turn, 0.0] };
    let belt = Collider {
        friction: 1.0,
        keys: vec![key(0.0, 0.0, 0.0), key(10.0, 8.0, 0.0)],
        ..Collider::cuboid([0.0, -1.0, 0.0], [30.0, 1.0, 30.0], [0.0; 3])
    };
    let mut block = Block::new([3, 2, 3], CELL, None);
    block.place(&Matrix3::identity(), Point3::origin());
    block.damping = 0.3;
    block.run(240, &colliders(std::slice::from_ref(&belt)), DT);
    assert!((block.mean_velocity() - Vector3::new(0.8, 0.0, 0.0)).norm() < 0.01, "{}", block.mean_velocity());

    // A turntable of a tenth of a turn per second turns the body with it.
    let table = Collider { keys: vec![key(0.0, 0.0, 0.0), key(10.0, 0.0, 360.0)], ..belt };
    let mut block = Block::new([3, 2, 3], CELL, None);
    block.place(&Matrix3::identity(), Point3::new(0.5, 0.0, 0.0));
    let table = colliders(&[table]);
    block.run(60, &table, DT);
    let start = block.center();
    block.run(150, &table, DT);
    let expected = euler_degrees([0.0, 90.0, 0.0]) * start.coords;
    let error = (block.center().coords - expected).norm();
    assert!(error < 0.2 * CELL, "{error}");

    // A plane that rises at 1.5 lifts a resting body at that speed.
    let lift = Collider {
        keys: vec![
            Key { time: 0.0, ..Key::default() },
            Key { time: 2.0, translate: [0.0, 3.0, 0.0], rotate: [0.0; 3] },
        ],
        ..ground()
    };
    let mut block = Block::new([2, 2, 2], CELL, None);
    block.damping = 0.3;
    block.place(&Matrix3::identity(), Point3::origin());
    block.run(90, &colliders(&[lift]), DT);
    let lowest = block.surface().iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!((lowest - 2.25).abs() < 0.05 * CELL);
    assert!((block.mean_velocity().y - 1.5).abs() < 0.03, "{}", block.mean_velocity());
}

/// A ball that rolls down a slope of 10 degrees has 5/7 of the acceleration of one that slides without friction;
/// rolling resistance takes less than 3 % of it by default. With a greater one, a ball on level ground that rolls a
/// tenth of its radius in a second comes to rest. The coefficient of a collider holds in place of that of the body.
#[test]
fn a_ball_rolls_down_a_slope_and_comes_to_rest_on_level_ground() {
    let (sin, cos) = 10.0_f64.to_radians().sin_cos();
    let run = |tilt: [f64; 2], velocity: f64, [own, floor]: [Option<f64>; 2], frames: u64| {
        let mesh = supple_tests::mesh_of(supple_tests::sphere([0.0; 3], 1.0, 40));
        let mut builder =
            Body::builder(mesh).preset(Preset::Rubber).lattice_vertices(3000).velocity([velocity, 0.0, 0.0]);
        if let Some(coefficient) = own {
            builder = builder.rolling_resistance(coefficient);
        }
        let plane = Collider::plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        let floor = Collider { friction: 1.0, rolling_resistance: floor, ..plane };
        let gravity = [9.81 * tilt[0], -9.81 * tilt[1], 0.0];
        let simulation =
            Simulation::builder().body(builder.build().unwrap()).collider(floor).gravity(gravity);
        let mut simulation = simulation.fps(30.0).substeps(Substeps::Auto).build().unwrap();
        simulation.advance(frames);
        let body = simulation.body(0);
        (body.center_of_mass().x, body.linear_momentum().x / body.mass(), body.is_asleep())
    };
    // It settles in the first second.
    let share = |coefficient| {
        let [early, late] = [30, 75].map(|frames| run([sin, cos], 0.0, [coefficient, None], frames).1);
        (late - early) / (1.5 * 9.81 * sin * 5.0 / 7.0)
    };
    let (free, slowed) = (share(Some(0.0)), share(None));
    // The ball is not round: its lowest cells have to be deformed.
    assert!((0.94..1.005).contains(&free), "{free}");
    assert!((0.97..1.0).contains(&(slowed / free)), "{slowed} of {free}");
    let (slowed, _, is_asleep) = run([0.0, 1.0], 0.1, [Some(0.1), None], 150);
    assert!(is_asleep && slowed > 0.01, "{slowed}");
    assert_eq!(run([0.0, 1.0], 0.1, [Some(0.0), Some(0.1)], 150).0, slowed);
    // Without resistance it goes on.
    let (free, speed, is_asleep) = run([0.0, 1.0], 0.1, [Some(0.0), None], 150);
    assert!(!is_asleep && speed > 0.02 && free > slowed, "{free} {speed}");
    assert_eq!(run([0.0, 1.0], 0.1, [Some(0.1), Some(0.0)], 150).0, free);
}
