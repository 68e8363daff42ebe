//! External forces, and the limits of forces and keys.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, Error, Force, ForceDuration, HalfWidth, Handle, Key, Material, Pin, Selection, Simulation,
    TimeWindow,
};
use supple_tests::{block, half_cells, lattice, momentum, without_gravity};

#[test]
fn a_force_on_any_selection_gives_its_impulse_once() {
    let selections = [
        Selection::Vertices(vec![0, 7, 30]),
        Selection::Plane { point: [1.6, 0.0, 0.0], normal: [1.0, 0.0, 0.0] },
    ];
    for selection in selections {
        let mut simulation = without_gravity(
            Body::from_lattice(half_cells())
                .material(Material::fast_lsm())
                .region_damping(0.2)
                .build()
                .unwrap(),
        );
        let force = Vector3::new(300.0, -20.0, 50.0);
        simulation.body_mut(0).apply_force(<[f64; 3]>::from(force), &selection).unwrap();
        for steps in [1, 100] {
            simulation.steps(steps);
            let error = momentum(&simulation.body(0)) - force * 0.01;
            assert!(error.norm() < 1e-5 * force.norm() * 0.01, "{error}");
        }
    }
}

/// A force acts in all steps of a call, or for a time, also where it ends within a step; an impulse is the same at any
/// step length.
#[test]
fn durations_give_their_impulses_at_any_step_length() {
    let everywhere = Selection::Vertices((0..60).collect());
    let force = Vector3::new(200.0, -30.0, 10.0);
    for dt in [0.01, 0.004] {
        let gained = |duration: Option<ForceDuration>| {
            let body = Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap();
            let mut simulation = Simulation::builder().body(body).gravity([0.0; 3]).dt(dt).build().unwrap();
            let body = simulation.body_mut(0);
            match duration {
                Some(duration) => {
                    let force = Force { duration, ..<[f64; 3]>::from(force).into() };
                    body.apply_force(force, &everywhere).unwrap();
                }
                None => body.apply_impulse(<[f64; 3]>::from(force), &everywhere).unwrap(),
            }
            simulation.steps(7);
            simulation.steps(30);
            momentum(&simulation.body(0))
        };
        let expected = [
            (Some(ForceDuration::Call), 7.0 * dt),
            (Some(ForceDuration::Step), dt),
            (Some(ForceDuration::Seconds(0.05)), 0.05),
            (Some(ForceDuration::Seconds(0.055)), 0.055),
            (None, 1.0),
        ];
        for (duration, time) in expected {
            let error = gained(duration) - force * time;
            assert!(error.norm() < 1e-5 * force.norm() * time, "{dt} {duration:?}: {error}");
        }
    }
    let mut body = Body::from_lattice(half_cells()).build().unwrap();
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = body.apply_forces_for(&[(0, [1.0; 3])], ForceDuration::Seconds(wrong)).unwrap_err();
        assert!(error.to_string().contains("duration"), "{error}");
    }
}

/// A force at a point and a torque change the momentum by F t and the angular momentum by ((p - c) x F + T) t.
#[test]
fn forces_at_a_point_and_torques_give_their_angular_impulses() {
    let body = Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap();
    let mut simulation = without_gravity(body);
    let body = simulation.body_mut(0);
    let (center, point) = (body.center_of_mass(), Point3::new(2.0, 1.0, -0.5));
    let (force, torque) = (Vector3::new(1.0, 3.0, -2.0), Vector3::new(0.5, -1.0, 2.0));
    let applied =
        Force { point: Some(point.into()), torque: torque.into(), ..<[f64; 3]>::from(force).into() };
    body.apply_force(applied, &Selection::Vertices((0..60).collect())).unwrap();
    simulation.step();
    let dt = simulation.dt();
    let body = &simulation.bodies()[0];
    let expected = ((point - center).cross(&force) + torque) * dt;
    assert!((body.linear_momentum() - force * dt).norm() < 1e-6 * force.norm() * dt);
    let error = body.angular_momentum() - expected;
    assert!(error.norm() < 1e-5 * expected.norm(), "{error} of {expected}");

    let torque_on = |vertices: Vec<u32>| {
        let mut body = Body::from_lattice(half_cells()).build().unwrap();
        let force = Force { torque: [1.0, 2.0, 3.0], ..Force::default() };
        body.apply_force(force, &Selection::Vertices(vertices))
    };
    let error = torque_on(vec![7]).unwrap_err().to_string();
    assert!(error.contains("lie on a line or at a point"), "{error}");
    torque_on(vec![0, 7, 30]).unwrap();
}

#[test]
fn forces_on_one_vertex_add_up_and_an_invalid_list_applies_nothing() {
    let mut simulation =
        without_gravity(Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap());
    let body = simulation.body_mut(0);
    body.apply_forces(&[(3, [1.0, 0.0, 0.0]), (3, [0.0, 2.0, 0.0])]).unwrap();
    for wrong in [f64::NAN, f64::INFINITY] {
        let error = body.apply_forces(&[(3, [1.0, 0.0, 0.0]), (4, [wrong, 0.0, 0.0])]).unwrap_err();
        let bits = wrong.to_bits();
        assert!(
            matches!(&error, Error::Range(e) if e.name == "force" && e.value.to_bits() == bits),
            "{error}"
        );
    }
    simulation.step();
    let error = momentum(&simulation.body(0)) - Vector3::new(0.01, 0.02, 0.0);
    assert!(error.norm() < 1e-7, "{error}");
}

#[test]
fn forces_are_order_independent_and_act_in_all_steps_of_a_call() {
    let run = |forces: &[(u32, [f64; 3])]| {
        let mut simulation =
            without_gravity(Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap());
        for force in [forces, &[]] {
            simulation.body_mut(0).apply_forces(force).unwrap();
            simulation.steps(3);
        }
        (simulation.body(0).positions(), simulation.body(0).corrected_positions())
    };
    let (a, b, c) = (1e3, [0.0, 2e3, 0.0], [0.0, 0.0, -5e2]);
    let sorted = run(&[(3, [a, 2e3, 0.0]), (17, c), (59, b)]);
    assert_eq!(run(&[(59, b), (3, [a, 0.0, 0.0]), (17, c), (3, b)]), sorted);
    assert_ne!(run(&[]), sorted);
}

#[test]
fn a_force_on_a_vertex_out_of_range_is_an_error_and_applies_nothing() {
    let mut body = Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap();
    let error = body.apply_forces(&[(0, [1.0; 3]), (60, [1.0; 3])]).unwrap_err();
    assert!(
        error.to_string().contains("vertex 60 is out of range: the lattice has 60 vertices, 0 to 59"),
        "{error}"
    );
    let stepped = |body| {
        let mut simulation = Simulation::builder().body(body).build().unwrap();
        simulation.step();
        simulation.body(0).velocities()
    };
    assert_eq!(
        stepped(body),
        stepped(Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap())
    );
}

#[test]
fn forces_and_keys_beyond_the_limits_are_errors_and_within_them_results_stay_finite() {
    let mut body = Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap();
    // Cells of 0.5.
    let limit = 0.5e15 * body.masses()[0];
    body.apply_forces(&[(0, [limit, -limit, 0.0])]).unwrap();
    for force in [1.001 * limit, 1e300, f64::NAN, f64::NEG_INFINITY] {
        let error = body.apply_forces(&[(1, [0.0, 1.0, 0.0]), (0, [0.0, 0.0, force])]).unwrap_err();
        assert!(matches!(&error, Error::Range(range) if range.name == "force"), "{error}");
    }
    let keys = |height| vec![Key { time: 0.0, translate: [0.0, height, 0.0], rotate: [0.0; 3] }];
    let handle = |height| {
        let selection = Selection::Vertices(vec![0, 1]);
        Handle { goal: None, selection, motion: keys(height).into(), window: TimeWindow::default() }
    };
    body.handle(&handle(-5e14)).unwrap();
    let error = body.handle(&handle(1e39)).unwrap_err().to_string();
    assert!(error.contains("key 0: translate is 1e39, too far: the limit is 5.000e14"), "{error}");
    body.set_keys(0, &keys(5e14), None).unwrap();
    let error = body.set_keys(0, &keys(-5.1e14), None).unwrap_err().to_string();
    assert!(error.contains("key 0: translate is -5.1e14, too far: the limit is 5.000e14"), "{error}");
    assert_eq!(body.constraint_count(), 1);
    let mut sim = Simulation::builder().body(body).dt(1e6).threads(1).build().unwrap();
    sim.steps(10);
    let positions = sim.body(0).positions();
    // The handle holds its vertices where the last valid keys put them.
    for (vertex, position) in positions[..2].iter().enumerate() {
        let expected = half_cells().rest_position(vertex as u32) + Vector3::new(0.0, 5e14, 0.0);
        assert!((position - expected).amax() <= 5e14 * f64::from(f32::EPSILON), "{position}");
    }
    let all = positions.into_iter().chain(sim.body(0).corrected_positions());
    assert!(all.flat_map(<[f64; 3]>::from).all(f64::is_finite));
}

/// A steady force stretches a held bar by as much at any damping.
#[test]
fn damping_takes_nothing_of_a_steady_force() {
    let stretch = |ratio: f64| {
        let held = Selection::Plane { point: [0.1, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
        let lattice = lattice(&block([6, 3, 3]));
        let ends: Vec<u32> =
            (0..lattice.len() as u32).filter(|&v| lattice.indices()[v as usize][0] == 6).collect();
        let body = Body::from_lattice(lattice).half_width(HalfWidth::CELL).damping_ratio(ratio);
        let mut simulation = without_gravity(
            body.pin(Pin { goal: None, selection: held, window: TimeWindow::default() }).build().unwrap(),
        );
        let end = |simulation: &Simulation| {
            let positions = simulation.body(0).positions();
            ends.iter().map(|&v| positions[v as usize].x).sum::<f64>() / ends.len() as f64 - 6.0
        };
        let mut sum = 0.0;
        for step in 0..1200 {
            simulation.body_mut(0).apply_force([2e5, 0.0, 0.0], &Selection::Vertices(ends.clone())).unwrap();
            simulation.step();
            // With little damping, the mean over the last oscillations.
            sum += if step >= 600 { end(&simulation) / 600.0 } else { 0.0 };
        }
        sum
    };
    let expected = stretch(0.05);
    assert!(expected > 0.05, "{expected}");
    for ratio in [0.3, 1.0] {
        let found = stretch(ratio);
        assert!((found / expected - 1.0).abs() < 0.01, "{ratio}: {found} for {expected}");
    }
}
