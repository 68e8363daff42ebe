//! Soft goals of pins and handles.

use nalgebra::Vector3;
use supple::{
    Body, Curve, CurveKey, Goal, HalfWidth, Handle, Key, Pin, RegionSize, Selection, Simulation, StepReason,
    Substeps, TimeWindow,
};
use supple_tests::{block, lattice};

/// A cube of edge 1 of n³ cells, all of whose vertices a pin pulls.
fn pulled(n: i32, goal: Option<Goal>) -> Body {
    let lattice =
        supple::Lattice::from_cells(&block([n; 3]), 1.0 / f64::from(n), nalgebra::Point3::origin(), true)
            .unwrap();
    let everywhere = Selection::Vertices((0..lattice.len() as u32).collect());
    let pin = Pin { selection: everywhere, window: TimeWindow::default(), goal };
    Body::from_lattice(lattice).youngs_modulus(1e6).pin(pin).build().unwrap()
}

fn simulated(body: Body, gravity: f64, dt: f64) -> Simulation {
    Simulation::builder().body(body).gravity([0.0, gravity, 0.0]).dt(dt).build().unwrap()
}

fn height(simulation: &Simulation) -> f64 {
    simulation.bodies()[0].center_of_mass().y
}

/// The frequency is f sqrt(w/(1 - w)) on any lattice and at any step length.
#[test]
fn the_weight_gives_its_frequency_on_any_lattice_at_any_step() {
    for (weight, n, rate) in [(0.5, 2, 60.0), (0.5, 5, 240.0), (0.7, 3, 120.0), (0.2, 4, 60.0)] {
        let goal = Goal { weight: Curve::from(weight), frequency: 2.0, damping_ratio: 0.0 };
        let mut simulation = simulated(pulled(n, Some(goal)), 0.0, 1.0 / rate);
        let everywhere = Selection::Vertices((0..((n + 1) * (n + 1) * (n + 1)) as u32).collect());
        simulation.body_mut(0).apply_impulse([0.0, 300.0, 0.0], &everywhere).unwrap();
        let (mut crossings, mut before, mut time) = (Vec::new(), 0.0, 0.0);
        while crossings.len() < 10 {
            simulation.step();
            let now = height(&simulation) - 0.5;
            if before < 0.0 && now >= 0.0 {
                crossings.push(time + before / (before - now) / rate);
            }
            (before, time) = (now, time + 1.0 / rate);
        }
        let found = 9.0 / (crossings[9] - crossings[0]);
        let expected = 2.0 * (weight / (1.0 - weight)).sqrt();
        assert!((found / expected - 1.0).abs() < 0.01, "{weight} {n} {rate}: {found} {expected}");
    }
}

/// Under gravity a body hangs g/ω² below its goal, and the pin carries its weight. Then it sleeps.
#[test]
fn a_soft_pin_carries_the_weight_and_lets_the_body_sleep() {
    let goal = Goal { weight: 0.5.into(), frequency: 3.0, damping_ratio: 0.5 };
    let mut simulation = simulated(pulled(3, Some(goal)), -9.81, 1.0 / 120.0);
    simulation.steps(600);
    let omega = std::f64::consts::TAU * 3.0;
    // The factor of the scheme is 2 (1 - cos(ω h))/h², by (ω h)²/12 less than ω².
    let sag = 9.81 / (omega * omega) * (1.0 + (omega / 120.0).powi(2) / 12.0);
    assert!((0.5 - height(&simulation) - sag).abs() < 1e-3 * sag, "{} {sag}", height(&simulation));
    let force = simulation.body(0).hold_force(0).unwrap().unwrap().force;
    let weight = simulation.bodies()[0].mass() * 9.81;
    assert!((force - Vector3::new(0.0, weight, 0.0)).norm() < 2e-3 * weight, "{force}");
    assert!(simulation.bodies()[0].is_asleep());
}

#[test]
fn a_weight_of_one_has_the_bits_of_a_prescribed_part() {
    let positions = |goal: Option<Goal>| {
        let lattice = lattice(&block([8, 2, 2]));
        let end = Selection::Plane { point: [2.5, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
        let keys = vec![
            Key { time: 0.0, translate: [0.0; 3], rotate: [0.0; 3] },
            Key { time: 1.0, translate: [0.0, 1.0, 0.0], rotate: [0.0, 0.0, 40.0] },
        ];
        let handle = Handle { selection: end, motion: keys.into(), window: TimeWindow::default(), goal };
        let body = Body::from_lattice(lattice).half_width(HalfWidth::CELL).damping_ratio(1.0);
        let body = body.handle(handle).build().unwrap();
        let mut simulation = simulated(body, 0.0, 1.0 / 240.0);
        simulation.steps(960);
        simulation.bodies()[0].positions()
    };
    let prescribed = positions(None);
    assert_eq!(positions(Some(Goal::from(1.0))), prescribed);
    // A weight near 1 ends at the same place, but does not prescribe it.
    let near = positions(Some(Goal::from(0.99)));
    let greatest = near.iter().zip(&prescribed).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(greatest > 1e-6 && greatest < 0.05, "{greatest}");
}

/// Weights that are keyed up to 1 end as a prescribed part, and weights that are keyed down let the part go.
#[test]
fn keyed_weights_take_hold_and_let_go() {
    let key = |time, value| CurveKey { time, value };
    let goal = |keys: Vec<CurveKey>| Some(Goal { weight: Curve::new(keys).unwrap(), ..Goal::default() });
    let mut simulation = simulated(pulled(2, goal(vec![key(0.0, 0.05), key(1.0, 1.0)])), -9.81, 1.0 / 120.0);
    let mut lowest = 0.5_f64;
    for _ in 0..60 {
        simulation.step();
        lowest = lowest.min(height(&simulation));
    }
    assert!(lowest < 0.5 - 0.01, "{lowest}");
    simulation.steps(62);
    let positions = simulation.bodies()[0].positions();
    assert_eq!(
        positions,
        Simulation::builder().body(pulled(2, None)).build().unwrap().bodies()[0].positions()
    );

    let mut simulation = simulated(pulled(2, goal(vec![key(0.5, 1.0), key(0.6, 0.01)])), -9.81, 1.0 / 120.0);
    simulation.steps(60);
    assert!((height(&simulation) - 0.5).abs() < 1e-6);
    simulation.steps(30);
    assert!(height(&simulation) < 0.5 - 1e-3);
}

#[test]
fn soft_goals_have_the_same_bits_after_a_restored_state() {
    let build = || simulated(pulled(3, Some(Goal::from(0.6))), -9.81, 1.0 / 100.0);
    let (mut one, mut other) = (build(), build());
    one.steps(17);
    other.restore(&one.state()).unwrap();
    one.steps(20);
    other.steps(20);
    assert_eq!(one.state(), other.state());
}

#[test]
fn automatic_steps_resolve_the_frequency_of_a_goal() {
    let chosen = |weight: f64| {
        let goal = Goal { frequency: 10.0, ..Goal::from(weight) };
        let mut body = pulled(2, Some(goal));
        body.set_region_size(RegionSize::Cells(1.into())).unwrap();
        let simulation = Simulation::builder().body(body).fps(24.0).substeps(Substeps::Auto).build().unwrap();
        let chosen = simulation.chosen_substeps().unwrap();
        (chosen.steps, chosen.reason)
    };
    // Six steps in a period of 1/10 s at 24 frames per second; at most eight steps per frame.
    assert_eq!(chosen(0.5), (3, StepReason::Goals));
    assert_eq!(chosen(0.999), (8, StepReason::Goals));
}

#[test]
fn a_weight_out_of_range_is_an_error() {
    let everywhere = Selection::Vertices(vec![0]);
    for wrong in [0.0, 1.5] {
        let pin =
            Pin { selection: everywhere.clone(), window: TimeWindow::default(), goal: Some(wrong.into()) };
        let error = Body::from_lattice(lattice(&block([1, 1, 1]))).pin(pin).build().unwrap_err().to_string();
        assert!(error.contains("weight = ") && error.contains("(0, 1]"), "{error}");
    }
}

/// A rigid body on soft goals has the frequency of their weight too.
#[test]
fn a_soft_pin_pulls_a_rigid_body() {
    let goal = Goal { weight: 0.5.into(), frequency: 3.0, damping_ratio: 0.5 };
    let lattice = lattice(&block([2, 2, 2]));
    let everywhere = Selection::Vertices((0..lattice.len() as u32).collect());
    let pin = Pin { selection: everywhere, window: TimeWindow::default(), goal: Some(goal) };
    let body = Body::from_lattice(lattice).rigid(true).pin(pin).build().unwrap();
    let before = body.center_of_mass().y;
    let mut simulation = simulated(body, -9.81, 1.0 / 120.0);
    simulation.steps(600);
    let omega = std::f64::consts::TAU * 3.0;
    let sag = 9.81 / (omega * omega) * (1.0 + (omega / 120.0).powi(2) / 12.0);
    assert!(
        (before - height(&simulation) - sag).abs() < 0.01 * sag,
        "{} {sag}",
        before - height(&simulation)
    );
}
