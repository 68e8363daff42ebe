//! Numbers of the material that change along keyframes.

use nalgebra::Point3;
use supple::{
    Accuracy, Body, BodyBuilder, Curve, CurveKey, Elasticity, KeyedMaterial, Pin, Selection, Simulation,
    TimeWindow, Zone,
};
use supple_tests::{block, greatest_distance, lattice};

fn curve(keys: &[(f64, f64)]) -> Curve {
    Curve::new(keys.iter().map(|&(time, value)| CurveKey { time, value }).collect()).unwrap()
}

/// A bar of 8 x 2 x 2 cells of edge 1, pinned at its upper end.
fn bar() -> BodyBuilder {
    let top = Selection::Plane { point: [0.0, 7.5, 0.0], normal: [0.0, 1.0, 0.0] };
    let pin = Pin { selection: top, window: TimeWindow::default(), goal: None };
    Body::from_lattice(lattice(&block([2, 8, 2]))).density(1.0).accuracy(Accuracy::Exact).pin(pin)
}

fn simulation(body: BodyBuilder) -> Simulation {
    Simulation::builder().body(body.build().unwrap()).dt(1.0 / 240.0).build().unwrap()
}

fn lowest(simulation: &Simulation) -> f64 {
    simulation.body(0).positions().iter().map(|point| point.y).fold(f64::INFINITY, f64::min)
}

fn distance(a: &Simulation, b: &Simulation) -> f64 {
    greatest_distance(&a.body(0).positions(), &b.body(0).positions())
}

/// Keyframes of one value are a number: the body has no stage for them, and the same bits.
#[test]
fn keyframes_of_one_value_are_a_number() {
    let keyed = bar().youngs_modulus(curve(&[(0.0, 4000.0), (1.0, 4000.0)])).damping_ratio(0.3);
    let mut keyed = simulation(keyed);
    let mut constant = simulation(bar().youngs_modulus(4000.0).damping_ratio(0.3));
    assert!(keyed.body(0).keyed().is_none());
    keyed.steps(100);
    constant.steps(100);
    assert_eq!(keyed.body(0).positions(), constant.body(0).positions());
}

/// A body that softens hangs in the end like one that always was so soft, and before as one of the first modulus.
#[test]
fn a_body_hangs_with_the_modulus_of_the_keyframe() {
    let rested = |modulus: Curve| {
        let mut simulation = simulation(bar().youngs_modulus(modulus).damping_ratio(0.8));
        let before = {
            simulation.steps(4 * 240);
            lowest(&simulation)
        };
        let modulus = simulation.body(0).youngs_modulus().unwrap();
        simulation.steps(6 * 240);
        (simulation, before, modulus)
    };
    let (stiff, before, modulus) = rested(4000.0.into());
    let (soft, _, _) = rested(1500.0.into());
    let (keyed, keyed_before, keyed_modulus) = rested(curve(&[(0.0, 4000.0), (4.0, 4000.0), (5.0, 1500.0)]));
    // The steps reach both.
    assert!((modulus - 4000.0).abs() < 1.0 && (keyed_modulus - 4000.0).abs() < 1.0);
    assert!((keyed.body(0).youngs_modulus().unwrap() - 1500.0).abs() < 1.0);
    let change = lowest(&stiff) - lowest(&soft);
    assert!(change > 0.05, "{change}");
    assert!((keyed_before - before).abs() < 1e-3 * change, "{keyed_before} {before}");
    assert!(distance(&keyed, &soft) < 0.01 * change, "{} {change}", distance(&keyed, &soft));
}

/// Without damping a swinging body keeps its height; from a keyframe on it comes to rest.
#[test]
fn damping_that_is_keyed_from_zero_brings_a_body_to_rest() {
    let damping = curve(&[(0.0, 0.0), (3.0, 0.0), (3.5, 1.0)]);
    let mut simulation = simulation(bar().youngs_modulus(4000.0).damping_ratio(damping));
    let mut swing = |steps: usize| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..steps {
            simulation.step();
            let y = lowest(&simulation);
            (low, high) = (low.min(y), high.max(y));
        }
        high - low
    };
    let (first, second) = (swing(360), swing(360));
    assert!(second > 0.8 * first && first > 0.1, "{first} {second}");
    swing(600);
    let last = swing(240);
    assert!(last < 1e-3 * first, "{last} {first}");
}

/// A stretched bar becomes as thin as with the last Poisson's ratio.
#[test]
fn a_bar_has_the_poisson_ratio_of_the_keyframe() {
    let rested = |ratio: Curve| {
        let mut simulation = simulation(bar().youngs_modulus(1500.0).damping_ratio(0.8).poisson_ratio(ratio));
        simulation.steps(8 * 240);
        simulation
    };
    let keyed = rested(curve(&[(0.0, 0.0), (2.0, 0.0), (3.0, 0.45)]));
    let (thin, wide) = (rested(0.45.into()), rested(0.0.into()));
    assert_eq!(keyed.body(0).material().poisson_ratio, Some(0.45));
    let change = distance(&thin, &wide);
    assert!(change > 0.01, "{change}");
    assert!(distance(&keyed, &thin) < 0.02 * change, "{} {change}", distance(&keyed, &thin));
}

/// A cube on a tilted held plate stays as long as the friction is great enough, and then slides off.
#[test]
fn a_cube_slides_when_the_friction_of_a_keyframe_is_less_than_the_slope() {
    let friction = curve(&[(0.0, 1.0), (1.0, 1.0), (1.1, 0.0)]);
    let everything = Selection::Plane { point: [0.0, -100.0, 0.0], normal: [0.0, 1.0, 0.0] };
    let pin = Pin { selection: everything, window: TimeWindow::default(), goal: None };
    let tilt = [0.0, 0.0, -15.0];
    let plate =
        Body::from_lattice(lattice(&block([24, 2, 6]))).name("plate").rotate(tilt).friction(1.0).pin(pin);
    let cube = Body::from_lattice(lattice(&block([4; 3]))).name("cube").rotate(tilt).friction(friction);
    // On the plate, at its upper end.
    let angle = 15_f64.to_radians();
    let at = |x: f64, y: f64| [x * angle.cos() + y * angle.sin(), -x * angle.sin() + y * angle.cos(), 1.0];
    let cube = cube.translate(at(3.0, 2.02));
    let builder = Simulation::builder().body(plate.build().unwrap()).body(cube.build().unwrap());
    let mut simulation = builder.dt(1.0 / 240.0).build().unwrap();
    simulation.steps(120);
    let start = simulation.body(1).center_of_mass();
    simulation.steps(120);
    let rested = (simulation.body(1).center_of_mass() - start).norm();
    simulation.steps(240);
    let slid = (simulation.body(1).center_of_mass() - start).norm();
    // g sin(15°) t²/2 after about a second without friction is 1.3.
    assert!(rested < 0.02 && slid > 0.8, "{rested} {slid}");
}

/// A change wakes a body that sleeps.
#[test]
fn a_sleeping_body_wakes_for_a_keyframe() {
    let modulus = curve(&[(0.0, 4000.0), (6.0, 4000.0), (6.5, 1500.0)]);
    let mut simulation = simulation(bar().youngs_modulus(modulus).damping_ratio(1.0));
    simulation.steps(1440);
    assert!(simulation.body(0).is_asleep());
    let before = lowest(&simulation);
    simulation.steps(240);
    assert!(lowest(&simulation) < before - 0.01);
}

/// A state in the middle of the keyframes goes on bit by bit, also in a body that was built without them.
#[test]
fn a_state_goes_on_along_the_keyframes() {
    let modulus = || curve(&[(0.0, 1500.0), (1.0, 4000.0)]);
    let body = || bar().damping_ratio(curve(&[(0.0, 0.1), (1.0, 0.5)])).youngs_modulus(modulus());
    let mut first = simulation(body());
    first.steps(100);
    let state = first.state();
    first.steps(100);
    for other in [body(), bar().damping_ratio(0.1).youngs_modulus(1500.0)] {
        let mut second = simulation(other);
        second.restore(&state).unwrap();
        second.steps(100);
        assert_eq!(second.body(0).positions(), first.body(0).positions());
    }
}

/// So does one with keyframes of Poisson's ratio and of the friction, whose damping depends on the lowest mode.
#[test]
fn a_state_goes_on_along_the_keyframes_of_poissons_ratio_and_friction() {
    let ratio = || curve(&[(0.0, 0.0), (1.0, 0.45)]);
    let body = || {
        bar()
            .youngs_modulus(4000.0)
            .damping_ratio(0.2)
            .poisson_ratio(ratio())
            .friction(curve(&[(0.0, 1.0), (1.0, 0.2)]))
    };
    let mut first = simulation(body());
    first.steps(100);
    let state = first.state();
    first.steps(100);
    let mut second = simulation(body());
    second.restore(&state).unwrap();
    second.steps(100);
    assert_eq!(second.body(0).positions(), first.body(0).positions());
    // Asking for the frequency before the first step changes nothing.
    let mut third = simulation(body());
    third.body(0).lowest_frequency();
    third.steps(200);
    assert_eq!(third.body(0).positions(), first.body(0).positions());
}

/// A simulation that is reset after its keyframes begins as one that is built.
#[test]
fn a_reset_begins_the_keyframes_again() {
    let body = || {
        let body = bar()
            .damping_ratio(curve(&[(0.0, 0.5), (0.5, 0.1)]))
            .poisson_ratio(curve(&[(0.0, 0.4), (0.5, 0.0)]));
        body.youngs_modulus(curve(&[(0.0, 4000.0), (0.5, 1500.0)]))
    };
    let builder = |body: BodyBuilder| {
        let steps = supple::Substeps::Auto;
        Simulation::builder().body(body.build().unwrap()).fps(30.0).substeps(steps).build().unwrap()
    };
    let mut again = builder(body());
    again.advance(30);
    again.reset();
    let mut new = builder(body());
    assert_eq!(again.substeps(), new.substeps());
    again.advance(10);
    new.advance(10);
    assert_eq!(again.substeps(), new.substeps());
    assert_eq!(again.body(0).positions(), new.body(0).positions());
}

/// Only the friction of a rigid body may have keyframes.
#[test]
fn a_rigid_body_has_keyframes_of_its_friction_alone() {
    let block = || Body::from_lattice(lattice(&block([2; 3]))).rigid(true);
    let friction = curve(&[(0.0, 1.0), (1.0, 0.0)]);
    let mut simulation = simulation(block().friction(friction.clone()));
    simulation.steps(240);
    assert_eq!(simulation.body(0).touching().friction, 0.0);
    let keyed = KeyedMaterial { youngs_modulus: Some(friction.clone()), ..KeyedMaterial::default() };
    let keyed = KeyedMaterial { youngs_modulus: Some(curve(&[(0.0, 1.0), (1.0, 2.0)])), ..keyed };
    assert!(block().keyed(keyed.clone()).build().is_err());
    let mut body = block().build().unwrap();
    assert!(body.set_keyed(keyed).is_err());
}

/// Another elasticity replaces the keyframes; the factors of zones apply to the modulus of the keyframe.
#[test]
fn keyframes_of_a_number_end_when_it_is_set() {
    let mut body =
        bar().youngs_modulus(curve(&[(0.0, 1500.0), (1.0, 4000.0)])).friction(0.2).build().unwrap();
    assert_eq!(body.material().elasticity, Elasticity::YoungsModulus(4000.0));
    let damping =
        KeyedMaterial { damping_ratio: Some(curve(&[(0.0, 0.1), (1.0, 0.5)])), ..KeyedMaterial::default() };
    let both = body.keyed().unwrap().clone().replaced_by(damping);
    body.set_keyed(both).unwrap();
    assert_eq!(body.keyed().unwrap().names().collect::<Vec<_>>(), ["youngs_modulus", "damping_ratio"]);
    body.set_elasticity(Elasticity::YoungsModulus(2000.0)).unwrap();
    assert_eq!(body.keyed().unwrap().names().collect::<Vec<_>>(), ["damping_ratio"]);
    body.set_damping(None).unwrap();
    assert!(body.keyed().is_none());
    let wrong = bar().damping_ratio(curve(&[(0.0, 0.1), (1.0, 1.5)])).build().unwrap_err().to_string();
    assert!(wrong.contains("1.5") && wrong.contains("damping"), "{wrong}");
}

/// Steps in which a zone is as stiff as the steps allow stay stable while the modulus grows.
#[test]
fn a_stiff_zone_stays_stable_while_the_modulus_grows() {
    let stiff = Selection::Plane { point: [0.0, 4.0, 0.0], normal: [0.0, 1.0, 0.0] };
    let body = bar().youngs_modulus(curve(&[(0.0, 1e2), (2.0, 1e6)])).zone(Zone::new(stiff, 50.0));
    let mut simulation = simulation(body);
    for _ in 0..600 {
        simulation.step();
        let far = |point: &Point3<f64>| point.coords.amax() > 30.0;
        assert!(!simulation.body(0).positions().iter().any(far));
    }
}
