//! `Simulation::reset`: back to frame 0, with the bits of a simulation that is built anew.

use supple::{
    Body, BreakLimit, Collider, Curve, CurveKey, FractureOptions, Handle, Key, Lattice, Pin, Placement,
    Plasticity, Selection, Simulation, Substeps, TimeWindow, Zone,
};
use supple_io::saved_state::save;

use supple_tests::half_cells;

/// Returns a body with a name at a height.
fn body(name: &str, height: f64) -> supple::BodyBuilder {
    Body::from_lattice(half_cells()).name(name).translate([0.05 * height, height, 0.0])
}

/// Returns blocks that fall on each other and on a ground that moves.
fn pile(threads: usize) -> Simulation {
    let placement = Placement { translate: [0.2, 3.2, 0.0], spin: [0.0, 0.0, 2.0], ..Placement::default() };
    let top = Body::from_lattice(half_cells()).name("top").placement(placement);
    let keys =
        [(0.0, 0.0), (0.5, 0.3)].map(|(time, x)| Key { time, translate: [x, 0.0, 0.0], ..Key::default() });
    let mut ground = Collider::plane([0.0, 1.95, 0.0], [0.0, 1.0, 0.0]);
    ground.keys = keys.to_vec();
    let builder = Simulation::builder().fps(60.0).substeps(Substeps::Auto).threads(threads).collider(ground);
    let builder = builder.body(body("low", 0.0).build().unwrap()).body(top.build().unwrap());
    builder.build().unwrap()
}

/// Checks that a simulation that was reset has the states of a new one, at once and later.
fn assert_new(simulation: &mut Simulation, new: &mut Simulation) {
    simulation.reset();
    assert_eq!((simulation.time(), simulation.step_count()), (0.0, 0));
    assert!(save(simulation) == save(new), "at once");
    for steps in [1, 2, 20, 40] {
        simulation.steps(steps);
        new.steps(steps);
        assert!(save(simulation) == save(new), "after {steps} more steps");
    }
}

#[test]
fn a_reset_pile_has_the_bits_of_a_new_one_for_any_number_of_threads() {
    for steps in [0, 1, 25, 400] {
        let (mut simulation, mut new) = (pile(2), pile(1));
        simulation.steps(steps);
        assert_new(&mut simulation, &mut new);
    }
}

#[test]
fn driven_colliders_forces_and_a_set_time_are_reset() {
    let (mut simulation, mut new) = (pile(1), pile(1));
    simulation.steps(10);
    simulation.collider_mut(0).move_to_in([0.0, 0.5, 0.0], [0.0; 3], 0.1).unwrap();
    simulation.body_mut(0).apply_force([5.0, 0.0, 0.0], &Selection::Vertices(vec![0])).unwrap();
    simulation.set_time(3.0).unwrap();
    simulation.steps(5);
    simulation.body_mut(1).apply_force([5.0, 0.0, 0.0], &Selection::Vertices(vec![0])).unwrap();
    assert_new(&mut simulation, &mut new);
}

#[test]
fn plastic_shapes_broken_joints_and_captured_poses_are_reset() {
    let bar = |cut: bool| {
        let cells: Vec<[i32; 3]> = (0..8).map(|x| [x, 0, 0]).collect();
        let lattice = Lattice::from_cells(&cells, 0.25, nalgebra::Point3::origin(), true).unwrap();
        let keys = [(0.05, 0.0), (0.3, 0.6)].map(|(time, x)| Key {
            time,
            translate: [x, 0.0, 0.0],
            ..Key::default()
        });
        let curve = [(0.0, 1.0), (0.4, 1.4)].map(|(time, value)| CurveKey { time, value });
        let side = |x| Selection::Box { min: [x, -1.0, -1.0], max: [x + 0.3, 1.0, 1.0] };
        let zone = Zone::new(side(0.5), 0.5).inflated(Curve::new(curve.to_vec()).unwrap());
        let body = Body::from_lattice(lattice).name("bar").half_width(1).plastic(Plasticity::default());
        let body = if cut { body } else { body.fracture(FractureOptions::new(BreakLimit::Strain(0.1))) };
        let handle = Handle {
            goal: None,
            selection: side(1.9),
            motion: keys.to_vec().into(),
            window: TimeWindow { start: 0.05, end: f64::INFINITY },
        };
        let body = body
            .zone(zone)
            .pin(Pin { goal: None, selection: side(-0.2), window: TimeWindow::default() })
            .handle(handle)
            .build()
            .unwrap();
        let ground = Collider::plane([0.0, -0.1, 0.0], [0.0, 1.0, 0.0]);
        Simulation::builder().body(body).collider(ground).dt(1.0 / 240.0).build().unwrap()
    };
    for cut in [false, true] {
        let (mut simulation, mut new) = (bar(cut), bar(cut));
        simulation.steps(90);
        if cut {
            simulation.body_mut(0).cut([1.1, 0.0, 0.0], [1.0, 0.0, 0.0]).unwrap();
            simulation.steps(20);
        }
        assert!(simulation.bodies()[0].broken_joints() > 0 && simulation.bodies()[0].pieces() > 1);
        assert!(simulation.bodies()[0].plastic_strain().iter().any(|&strain| strain > 1e-3));
        assert_new(&mut simulation, &mut new);
    }
}

#[test]
fn settings_that_were_changed_stay() {
    let build = |density: f64| {
        let body = body("a", 0.0).half_width(1).density(density).build().unwrap();
        Simulation::builder().body(body).dt(1.0 / 120.0).build().unwrap()
    };
    let (mut simulation, mut new) = (build(1000.0), build(500.0));
    simulation.steps(10);
    simulation.body_mut(0).set_density(500.0).unwrap();
    simulation.set_gravity([1.0, 0.0, 0.0]).unwrap();
    new.set_gravity([1.0, 0.0, 0.0]).unwrap();
    let pin = Pin { goal: None, selection: Selection::Vertices(vec![0, 1]), window: TimeWindow::default() };
    simulation.body_mut(0).pin(&pin).unwrap();
    new.body_mut(0).pin(&pin).unwrap();
    simulation.steps(10);
    assert_new(&mut simulation, &mut new);
}
