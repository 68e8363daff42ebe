//! Changes between steps (stiffness, damping, half-width, volume, constraints, threads), and states that keep
//! them.

use nalgebra::{Point3, Vector3};
use supple::{
    Body, ConstraintError, Elasticity, Error, Handle, Key, LatticeError, Material, RegionDamping, RegionSize,
    Selection, Simulation, Stiffness, TimeWindow, VolumeError, VolumeMeasure, VolumeOptions,
};
use supple_tests::{half_cells, momentum, without_gravity};

#[test]
fn material_set_later_equals_material_of_the_builder() {
    let build = || Body::from_lattice(half_cells()).material(Material::fast_lsm());
    let mut later = build().build().unwrap();
    later.set_stiffness(Stiffness::Frequency(3.0)).unwrap();
    later.set_region_damping(RegionDamping::Rate(2.0)).unwrap();
    later.set_region_size(RegionSize::Radius(1.6)).unwrap();
    assert_eq!(later.half_width(), 3);
    let given = build().frequency(3.0).region_damping_rate(2.0).half_width(3).build().unwrap();
    let run = |body: Body| {
        let mut simulation = without_gravity(body);
        let stretched: Vec<_> =
            simulation.body(0).positions().iter().map(|p| Point3::new(1.2 * p.x, p.y, p.z)).collect();
        simulation.body_mut(0).set_positions(&stretched).unwrap();
        simulation.steps(30);
        simulation.body(0).positions()
    };
    assert_eq!(run(later), run(given));
}

#[test]
fn settings_out_of_range_are_errors_and_change_nothing() {
    let mut body = Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap();
    let errors = [
        (body.set_stiffness(Stiffness::PerStep(1.5)), ("stiffness", 1.5)),
        (body.set_region_damping(RegionDamping::Rate(-1.0)), ("region_damping_rate", -1.0)),
        (body.set_region_size(RegionSize::Cells(0.into())), ("half_width", 0.0)),
    ];
    for (result, expected) in errors {
        let error = result.unwrap_err();
        assert_eq!((error.name, error.value), expected, "{error}");
    }
    assert_eq!(body.set_volume(VolumeMeasure::Mesh), Err(VolumeError::NoMesh));
    assert_eq!(body.volume_options(), VolumeOptions::default());
    assert_eq!(*body.material(), Material::fast_lsm());
    let missing = Err(ConstraintError::NoSuchConstraint { index: 0, count: 0 });
    assert_eq!(body.release(0), missing);
    assert_eq!(body.set_keys(0, &[Key::default()], None), missing);
}

#[test]
fn another_half_width_keeps_positions_velocities_and_momentum() {
    let mut simulation = without_gravity(
        Body::from_lattice(half_cells())
            .material(Material::fast_lsm())
            .spin([0.0, 2.0, 1.0])
            .build()
            .unwrap(),
    );
    simulation.body_mut(0).apply_force([300.0, 0.0, 0.0], &Selection::Vertices(vec![0])).unwrap();
    simulation.steps(20);
    let before = (simulation.body(0).positions(), simulation.body(0).velocities());
    let momentum_before = momentum(&simulation.body(0));
    for cells in [1, 4, 2] {
        simulation.body_mut(0).set_region_size(RegionSize::Cells(cells.into())).unwrap();
        let body = simulation.body(0);
        assert_eq!(
            (body.half_width(), body.material().elasticity),
            (cells.min(4).into(), Elasticity::REGIONS.with_region_size(RegionSize::Cells(cells.into())))
        );
        if cells == 1 {
            assert_eq!((body.positions(), body.velocities()), before);
        }
        simulation.steps(50);
        let body = simulation.body(0);
        let error = momentum(&body) - momentum_before;
        // The velocities are f32: each is half an ulp off at most.
        let speed = body.velocities().iter().map(Vector3::norm).fold(0.0, f64::max);
        assert!(error.norm() < 0.5 * f64::from(f32::EPSILON) * body.mass() * speed, "{error}");
    }
}

#[test]
fn a_half_width_set_later_equals_one_of_the_builder_for_an_inverted_body() {
    let build = |cells| {
        without_gravity(
            Body::from_lattice(half_cells())
                .material(Material::fast_lsm())
                .half_width(cells)
                .build()
                .unwrap(),
        )
    };
    let mut changed = build(2);
    let inside_out: Vec<_> =
        changed.body(0).positions().iter().map(|p| Point3::from(p.coords * -0.3)).collect();
    changed.body_mut(0).set_positions(&inside_out).unwrap();
    changed.steps(30);
    assert!(changed.body(0).unconverged_rotations() > 0);
    changed.body_mut(0).set_region_size(RegionSize::Cells(1.into())).unwrap();
    let mut built = build(1);
    built.restore(&changed.state()).unwrap();
    for steps in [1, 100] {
        changed.steps(steps);
        built.steps(steps);
        assert_eq!(changed.state(), built.state());
    }
}

#[test]
fn volume_options_set_later_equal_options_of_the_builder() {
    let build = |volume: VolumeOptions| {
        Body::from_lattice(half_cells()).material(Material::fast_lsm()).volume(volume).build().unwrap()
    };
    let cells = VolumeOptions { max_correction: 0.5, ..VolumeMeasure::Cells.into() };
    let mut changed = build(VolumeMeasure::Lattice.into());
    for options in [VolumeOptions::off(), cells, VolumeMeasure::Lattice.into()] {
        changed.set_volume(options).unwrap();
        let mut built = build(options);
        let stretched: Vec<_> =
            built.positions().iter().map(|p| Point3::new(1.2 * p.x, p.y, p.z + 0.1 * p.x)).collect();
        for body in [&mut changed, &mut built] {
            body.set_positions(&stretched).unwrap();
        }
        assert_eq!(changed.alone().corrected_positions(), built.alone().corrected_positions());
        assert_eq!(changed.alone().volume_report(), built.alone().volume_report());
        assert_eq!(changed.volume_options(), options);
    }
}

#[test]
fn handles_follow_new_keys_and_are_released() {
    let mut body = Body::from_lattice(half_cells()).material(Material::fast_lsm()).build().unwrap();
    let all = Selection::Vertices((0..60).collect());
    let keys = vec![Key::default()];
    body.handle(&Handle { goal: None, selection: all, motion: keys.into(), window: TimeWindow::default() })
        .unwrap();
    let rest = body.positions();
    let mut simulation = without_gravity(body);
    simulation.steps(5);
    let shifted = Key { time: 0.0, translate: [1.0, 0.0, 0.0], rotate: [0.0; 3] };
    simulation.body_mut(0).set_keys(0, &[shifted], None).unwrap();
    simulation.step();
    let shift = |simulation: &Simulation| simulation.body(0).positions()[7] - rest[7];
    assert!((shift(&simulation) - Vector3::x()).norm() < 1e-6);
    let released_at = shift(&simulation);
    simulation.body_mut(0).release(0).unwrap();
    simulation.set_gravity([0.0, -1.0, 0.0]).unwrap();
    simulation.steps(100);
    // Symplectic Euler from rest: g dt² n (n + 1)/2 with dt 0.01 and n = 100.
    let fallen = Vector3::new(0.0, -0.505, 0.0);
    let error = shift(&simulation) - released_at - fallen;
    assert!(error.norm() < 1e-5, "{error}");
}

#[test]
fn released_constraints_take_no_memory_and_keep_the_indices_of_the_others() {
    let pin = |vertex| supple::Pin {
        goal: None,
        selection: Selection::Vertices(vec![vertex]),
        window: TimeWindow { start: 0.0, end: 0.05 },
    };
    let build = || {
        Body::from_lattice(half_cells())
            .material(Material::fast_lsm())
            .pin(pin(0))
            .pin(pin(1))
            .pin(pin(2))
            .build()
            .unwrap()
    };
    let mut simulation = without_gravity(build());
    simulation.steps(2);
    let indices = |simulation: &Simulation| -> Vec<_> {
        simulation.body(0).constraints().map(|constraint| constraint.index()).collect()
    };
    let bytes = |simulation: &Simulation| simulation.body(0).memory();
    let before = bytes(&simulation);
    for index in 3..2000 {
        let body = simulation.body_mut(0);
        body.pin(&pin(5)).unwrap();
        if index % 100 == 0 {
            // Active when it is released.
            simulation.step();
        }
        simulation.body_mut(0).release(index).unwrap();
    }
    simulation.body_mut(0).release(1).unwrap();
    assert_eq!(indices(&simulation), [0, 2]);
    simulation.step();
    assert!(bytes(&simulation) < before, "{} {before}", bytes(&simulation));

    // After the end of their window, pins can still act if the time is set back.
    let captured = simulation.body(0).positions()[2];
    simulation.steps(10);
    assert_eq!(indices(&simulation), [0, 2]);
    assert!(!simulation.body(0).constraint(2).unwrap().is_active());
    simulation.set_time(0.0).unwrap();
    simulation.set_gravity([0.0, -9.81, 0.0]).unwrap();
    simulation.step();
    assert!(simulation.body(0).constraint(2).unwrap().is_active());
    assert!((simulation.body(0).positions()[2] - captured).norm() < 1e-6);

    let body = simulation.body_mut(0);
    let moved = [Key { time: 0.0, translate: [1.0, 0.0, 0.0], rotate: [0.0; 3] }];
    body.set_keys(2, &moved, None).unwrap();
    assert_eq!(body.constraint(2).unwrap().keys(), Some(&moved[..]));
    assert_eq!(body.constraint(0).unwrap().keys(), None);
    body.release(1).unwrap();
    let error = body.set_keys(1, &moved, None).unwrap_err();
    assert_eq!(error, ConstraintError::Released { index: 1 });
    assert_eq!(error.to_string(), "pin or handle 1 was released; add another one");
    assert_eq!(body.release(2000), Err(ConstraintError::NoSuchConstraint { index: 2000, count: 2000 }));
    assert_eq!(body.constraint_count(), 2000);
    body.pin(&pin(7)).unwrap();

    let mut twin = without_gravity(build());
    twin.restore(&simulation.state()).unwrap();
    assert_eq!(indices(&twin), [0, 2, 2000]);
    simulation.steps(5);
    twin.steps(5);
    assert_eq!(twin.state(), simulation.state());
}

#[test]
fn a_lattice_is_scaled_about_the_origin() {
    let body = Body::from_lattice(half_cells()).material(Material::fast_lsm()).scale(2.0).build().unwrap();
    let unscaled = half_cells();
    for (vertex, position) in (0..60).zip(body.positions()) {
        assert!((position - unscaled.rest_position(vertex) * 2.0).norm() < 1e-6);
    }
    let error =
        Body::from_lattice(half_cells()).material(Material::fast_lsm()).scale(0.0).build().unwrap_err();
    assert!(matches!(&error, Error::Lattice(LatticeError::CellSize(0.0))), "{error}");
}

#[test]
fn threads_changed_between_steps_change_no_bit() {
    let run = |threads: [usize; 2]| {
        let mut simulation = without_gravity(
            Body::from_lattice(half_cells())
                .material(Material::fast_lsm())
                .spin([0.0, 1.0, 2.0])
                .build()
                .unwrap(),
        );
        for threads in threads {
            simulation.abandon_threads();
            simulation.set_threads(threads).unwrap();
            simulation.steps(10);
        }
        let error = simulation.set_threads(1_000_000).unwrap_err();
        assert!(matches!(&error, Error::Range(e) if (e.name, e.value) == ("threads", 1e6)), "{error}");
        simulation.body(0).positions()
    };
    assert_eq!(run([1, 1]), run([2, 3]));
}

#[test]
fn a_state_with_an_active_pin_continues_in_a_body_whose_pin_was_never_active() {
    let pin = |end| supple::Pin {
        goal: None,
        selection: Selection::Vertices(vec![0, 1, 20]),
        window: TimeWindow { start: 0.05, end },
    };
    let build = || {
        Body::from_lattice(half_cells())
            .material(Material::fast_lsm())
            .spin([0.0, 1.0, 0.0])
            .pin(pin(0.25))
            .build()
            .unwrap()
    };
    let (mut one, mut free) = (without_gravity(build()), without_gravity(build()));
    free.steps(3);
    let start = free.state();
    one.steps(15);
    let mut other = without_gravity(build());
    other.restore(&one.state()).unwrap();
    for _ in 0..3 {
        // Through the active window and past its end.
        one.steps(15);
        other.steps(15);
        assert_eq!(other.state(), one.state());
    }
    // Back to the time before the window.
    other.restore(&start).unwrap();
    for steps in [1, 30] {
        free.steps(steps);
        other.steps(steps);
        assert_eq!(other.state(), free.state());
    }
}

#[test]
fn a_state_keeps_all_settings_that_changed_between_steps() {
    let build = || {
        Body::from_lattice(half_cells()).material(Material::fast_lsm()).spin([0.0, 1.0, 0.0]).build().unwrap()
    };
    let collider = || supple::Collider::sphere([2.0, 1.0, 3.5], 1.2);
    let world = |body| {
        Simulation::builder().body(body).gravity([0.0; 3]).dt(0.01).collider(collider()).build().unwrap()
    };
    let mut one = world(build());
    one.steps(3);
    one.set_dt(0.008).unwrap();
    one.set_gravity([0.0, -9.0, 0.0]).unwrap();
    let body = one.body_mut(0);
    body.set_stiffness(Stiffness::PerStep(0.6)).unwrap();
    body.set_region_damping(RegionDamping::PerStep(0.1)).unwrap();
    body.set_region_size(RegionSize::Cells(3.into())).unwrap();
    body.set_volume(VolumeMeasure::Lattice).unwrap();
    let pin =
        supple::Pin { goal: None, selection: Selection::Vertices(vec![0, 1]), window: TimeWindow::default() };
    body.pin(&pin).unwrap();
    one.steps(40);
    one.body_mut(0).apply_force([5.0, 0.0, 0.0], &Selection::Vertices(vec![20])).unwrap();

    let mut other = world(build());
    other.restore(&one.state()).unwrap();
    assert_eq!(other.state(), one.state());
    for _ in 0..2 {
        assert_eq!(other.body(0).corrected_positions(), one.body(0).corrected_positions());
        one.steps(10);
        other.steps(10);
    }
    assert_eq!(other.state(), one.state());
}
