//! Gravity along keyframes.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, Collider, Curve, CurveKey, Interpolation, Lattice, Preset, Simulation, SimulationBuilder, Substeps,
};
use supple_tests::block;

const DT: f64 = 1.0 / 120.0;

fn cube() -> Body {
    let lattice = Lattice::from_cells(&block([4; 3]), 0.25, Point3::new(0.0, 1.0, 0.0), true).unwrap();
    Body::from_lattice(lattice).preset(Preset::Rubber).build().unwrap()
}

fn curve(keys: &[(f64, [f64; 3])]) -> Curve<[f64; 3]> {
    Curve::new(keys.iter().map(|&(time, value)| CurveKey { time, value }).collect()).unwrap()
}

fn falling(gravity: impl Into<Curve<[f64; 3]>>) -> SimulationBuilder {
    Simulation::builder().body(cube()).gravity(gravity).dt(DT).threads(1)
}

fn bits(simulation: &Simulation) -> Vec<[u64; 3]> {
    let body = simulation.body(0);
    let vectors = body.positions().into_iter().map(|p| p.coords).chain(body.velocities());
    vectors.map(|v| <[f64; 3]>::from(v).map(f64::to_bits)).collect()
}

/// A step of length h begins with gravity g(t), so that after n steps the velocity is the sum of g(k h) h.
#[test]
fn a_free_body_gets_the_sum_of_the_gravity_at_the_starts_of_the_steps() {
    let keys = curve(&[(0.25, [0.0, -8.0, 0.0]), (0.75, [4.0, 0.0, 2.0]), (1.5, [0.0, 6.0, 0.0])]);
    for gravity in [keys.clone(), keys.interpolated(Interpolation::Smooth)] {
        let mut simulation = falling(gravity.clone()).build().unwrap();
        let mut expected = Vector3::zeros();
        for step in 0..240 {
            let time = f64::from(step) * DT;
            assert_eq!(simulation.gravity(), gravity.value(time), "at {time} s");
            expected += Vector3::from(gravity.value(time)) * DT;
            simulation.step();
            let mean = simulation.body(0).linear_momentum() / simulation.body(0).mass();
            // The positions and velocities are f32.
            assert!((mean - expected).norm() < 1e-5 * (1.0 + expected.norm()), "{mean:?} {expected:?}");
        }
        assert_eq!(simulation.gravity_curve(), &gravity);
    }
}

#[test]
fn the_gravity_energy_has_the_gravity_in_force() {
    let mut simulation =
        falling(curve(&[(0.0, [0.0, -10.0, 0.0]), (1.0, [0.0, 10.0, 0.0])])).build().unwrap();
    let center = |simulation: &Simulation| simulation.body(0).center_of_mass().y;
    let energy = |simulation: &Simulation| simulation.body(0).gravity_energy().unwrap();
    let mass = simulation.body(0).mass();
    assert!((energy(&simulation) - mass * 10.0 * center(&simulation)).abs() < 1e-9 * mass);
    simulation.steps(90);
    assert!((energy(&simulation) + mass * 5.0 * center(&simulation)).abs() < 1e-9 * mass);
    simulation.set_time(0.5).unwrap();
    assert_eq!((simulation.gravity(), energy(&simulation).abs()), ([0.0; 3], 0.0));
}

/// Keyframes that are all the same give the bits of a number, and so does a curve of one keyframe.
#[test]
fn gravity_that_does_not_change_has_the_bits_of_a_vector() {
    let g = [0.5, -9.81, 0.25];
    let run = |gravity: Curve<[f64; 3]>| {
        let mut simulation =
            falling(gravity).collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0])).build().unwrap();
        simulation.steps(120);
        bits(&simulation)
    };
    let expected = run(g.into());
    assert_eq!(run(curve(&[(3.0, g)])), expected);
    assert_eq!(run(curve(&[(0.1, g), (0.3, g), (0.7, g)])), expected);
}

#[test]
fn a_sleeping_body_wakes_up_when_gravity_changes_and_sleeps_while_it_does_not() {
    let gravity = curve(&[(0.0, [0.0, -9.81, 0.0]), (3.0, [0.0, -9.81, 0.0]), (3.5, [0.0, 4.0, 0.0])]);
    let mut simulation =
        falling(gravity).collider(Collider::plane([0.0, 1.0, 0.0], [0.0, 1.0, 0.0])).build().unwrap();
    simulation.steps(360);
    assert!(simulation.body(0).is_asleep());
    let saved = simulation.state();
    simulation.steps(1);
    assert!(!simulation.body(0).is_asleep());
    simulation.steps(119);
    let lowest = simulation.body(0).positions().iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!(lowest > 1.2, "{lowest}");
    // The state has the keyframes, and the time.
    let expected = bits(&simulation);
    simulation.set_gravity([0.0; 3]).unwrap();
    simulation.restore(&saved).unwrap();
    assert_eq!(simulation.gravity(), [0.0, -9.81, 0.0]);
    simulation.steps(120);
    assert_eq!(bits(&simulation), expected);
    let mut other =
        falling([0.0; 3]).collider(Collider::plane([0.0, 1.0, 0.0], [0.0, 1.0, 0.0])).build().unwrap();
    other.restore(&saved).unwrap();
    other.steps(120);
    assert_eq!(bits(&other), expected);
    // A reset goes on along the keyframes.
    simulation.reset();
    simulation.steps(480);
    assert_eq!(bits(&simulation), expected);
}

#[test]
fn the_greatest_gravity_of_a_keyframe_chooses_the_steps() {
    let steps = |gravity: Curve<[f64; 3]>| {
        let builder = Simulation::builder().body(cube()).gravity(gravity).fps(30.0).substeps(Substeps::Auto);
        builder.collider(Collider::plane([0.0, -9.0, 0.0], [0.0, 1.0, 0.0])).build().unwrap().substeps()
    };
    let (low, high) = ([0.0, -1.0, 0.0], [0.0, -100.0, 0.0]);
    assert!(steps(low.into()) < steps(high.into()));
    assert_eq!(steps(curve(&[(0.0, low), (9.0, high), (10.0, low)])), steps(high.into()));
}

#[test]
fn a_number_out_of_range_is_an_error() {
    let gravity = curve(&[(0.0, [0.0; 3]), (1.0, [0.0, 2e12, 0.0])]);
    let error = falling(gravity.clone()).build().unwrap_err().to_string();
    assert!(error.contains("gravity = 2000000000000"), "{error}");
    let mut simulation = falling([0.0, -1.0, 0.0]).build().unwrap();
    simulation.set_gravity(gravity).unwrap_err();
    assert_eq!(simulation.gravity(), [0.0, -1.0, 0.0]);
}
