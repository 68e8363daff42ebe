//! Stiffness that varies over a body.

use nalgebra::{Point3, Vector3};
use supple::reference::{Naive, Regions};
use supple::{
    Body, Elasticity, HalfWidth, Handle, Key, Pin, Selection, Simulation, Stiffness, Substeps, TimeWindow,
    Zone,
};
use supple_tests::{
    Random, bare, block, coordinates, difficult_lattices, lattice, points, rest, tolerance, worst,
};

/// Returns one factor per vertex from 0.01 to 100, evenly distributed by their logarithms.
fn random_factors(count: usize, random: &mut Random) -> Vec<f64> {
    (0..count).map(|_| 100_f64.powf(random.signed())).collect()
}

/// Returns a body whose stiffness alpha, times the greatest of its factors, is 1 or less.
fn varied(lattice: &supple::Lattice, half_width: impl Into<HalfWidth>, factors: &[f64]) -> Body {
    let mut body = bare(lattice, half_width);
    body.set_stiffness(Stiffness::PerStep(0.01)).unwrap();
    body.set_stiffness_factors(Some(factors)).unwrap();
    body
}

fn shaken(x: &[Vector3<f64>], random: &mut Random) -> Vec<Vector3<f64>> {
    let turn = random.rotation();
    x.iter().map(|x| turn * x + random.vector() * 0.2).collect()
}

#[test]
fn goals_and_steps_with_factors_equal_the_reference() {
    let mut random = Random(41);
    for (name, lattice) in difficult_lattices() {
        for half_width in [0.5, 1.0, 2.0, 4.0] {
            let factors = random_factors(lattice.len(), &mut random);
            let x = shaken(&rest(&lattice), &mut random);
            let extent = x.iter().map(|x| x.amax()).fold(1.0, f64::max);
            let mut body = varied(&lattice, half_width, &factors);
            body.set_positions(&points(&x)).unwrap();
            let naive = Naive::new(&lattice, half_width, Regions::Staircase).with_factors(factors);
            let goals = naive.goals(&naive.motions(&x));
            let error = worst(&coordinates(&body.goals()), &goals);
            // The goal positions lie near the vertices, so the weights of a mean do not multiply its error. The factors
            // round once more.
            assert!(error <= 2.0 * tolerance(extent), "{name}, w = {half_width}: {error:e} cells");

            let dt = 0.01;
            let mut sim = Simulation::builder().body(body).gravity([0.0; 3]).dt(dt).build().unwrap();
            sim.step();
            let rates = naive.vertex_factors().into_iter().map(|factor| 0.01 * factor / dt);
            let expected: Vec<_> =
                goals.iter().zip(&x).zip(rates).map(|((g, x), rate)| (g - x) * rate).collect();
            // alpha times a factor is at most 1, so the error of a velocity is at most that of a goal position, divided
            // by dt; the momentum correction adds the mean of these errors.
            let error = worst(&sim.body(0).velocities(), &expected) * dt;
            assert!(error <= 4.0 * tolerance(extent), "{name}, w = {half_width}: {error:e} cells per step");
        }
    }
}

#[test]
fn accelerations_with_factors_keep_both_momenta() {
    let mut random = Random(42);
    for (name, lattice) in difficult_lattices() {
        let factors = random_factors(lattice.len(), &mut random);
        let x = shaken(&rest(&lattice), &mut random);
        let naive = Naive::new(&lattice, 2, Regions::Staircase).with_factors(factors.clone());
        let mut body = varied(&lattice, 2, &factors);
        body.set_positions(&points(&x)).unwrap();
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        let (mut forces, mut torques) = (0.0, 0.0);
        let vertex_factors = naive.vertex_factors();
        for (((x, g), m), s) in x.iter().zip(&body.goals()).zip(body.masses()).zip(vertex_factors) {
            let f = (g.coords - x) * (m * s);
            (force, torque) = (force + f, torque + x.cross(&f));
            (forces, torques) = (forces + f.norm(), torques + x.cross(&f).norm());
        }
        // The momentum correction of the step, which would hide a fault, has not acted. A goal position has an error
        // of a few ulp of the coordinates, up to 16, beside distances of 0.2 cells.
        assert!(force.norm() < 1e-4 * forces, "{name}: {force:e} {forces:e}");
        assert!(torque.norm() < 1e-4 * torques, "{name}: {torque:e} {torques:e}");
    }
}

#[test]
fn a_factor_for_all_vertices_is_another_youngs_modulus() {
    let (pin, handle) = held_bar(40.0, 1.0);
    let moved = |modulus: f64, factor: Option<f64>| {
        let mut body = Body::from_lattice(lattice(&block([40, 4, 4])))
            .youngs_modulus(modulus)
            .pin(pin.clone())
            .handle(handle.clone())
            .build()
            .unwrap();
        let factors = factor.map(|factor| vec![factor; body.lattice().len()]);
        body.set_stiffness_factors(factors.as_deref()).unwrap();
        let world = Simulation::builder().body(body).gravity([0.0, -9.81, 0.0]).fps(30.0);
        let mut sim = world.substeps(Substeps::Auto).build().unwrap();
        sim.advance(10);
        let body = sim.body(0);
        (sim.substeps(), body.half_width(), body.lowest_frequency().unwrap(), coordinates(&body.positions()))
    };
    for factor in [0.2, 7.0] {
        let (plain, varied) = (moved(3e6 * factor, None), moved(3e6, Some(factor)));
        assert_eq!((plain.0, plain.1), (varied.0, varied.1), "steps per frame and half-width");
        assert!((varied.2 / plain.2 - 1.0).abs() < 0.01, "{} {}", varied.2, plain.2);
        // Rounding errors of 10 frames of smooth motion of a few cells; the two moduli differ by 1 / factor.
        let error = worst(&varied.3, &plain.3);
        assert!(error < 1e-2, "{error:e} cells");
        let unchanged = moved(3e6, None);
        assert!(worst(&unchanged.3, &plain.3) > 0.1);
    }
}

/// Returns a pin of the left end of a bar along x, and a handle that moves its right end by `distance` in 0.3 s.
fn held_bar(length: f64, distance: f64) -> (Pin, Handle) {
    let end = |x: f64| Selection::Plane { point: [x, 0.0, 0.0], normal: [x - length / 2.0, 0.0, 0.0] };
    let key = |time, x| Key { time, translate: [x, 0.0, 0.0], rotate: [0.0; 3] };
    let (window, keys) = (TimeWindow::default(), vec![key(0.0, 0.0), key(0.3, distance)]);
    (
        Pin { goal: None, selection: end(0.0), window },
        Handle { goal: None, selection: end(length), motion: keys.into(), window },
    )
}

#[test]
fn the_strains_of_two_halves_are_inverse_to_their_factors() {
    for factor in [0.1, 4.0] {
        let (pin, handle) = held_bar(60.0, 2.0);
        let selection = Selection::Plane { point: [30.0, 0.0, 0.0], normal: [1.0, 0.0, 0.0] };
        let body = Body::from_lattice(lattice(&block([60, 3, 3])))
            .youngs_modulus(1e6)
            // About the angular frequency of the slowest motion along the bar.
            .damping_rate(0.8)
            .zone(Zone::new(selection, factor))
            .pin(pin)
            .handle(handle);
        let world = Simulation::builder().body(body.build().unwrap()).gravity([0.0; 3]);
        let mut sim = world.fps(30.0).substeps(Substeps::Fixed(8)).build().unwrap();
        sim.advance(400);
        let x = sim.body(0).positions();
        let mean = |from: f64| {
            let positions = sim.body(0).lattice().indices().iter().zip(&x);
            let plane: Vec<f64> =
                positions.filter(|(index, _)| f64::from(index[0]) == from).map(|(_, x)| x.x).collect();
            plane.iter().sum::<f64>() / plane.len() as f64
        };
        // Away from the ends and from the border by more than two half-widths.
        let w = 2 * sim.body(0).half_width().cells() as i32;
        let strain = |from: i32, to: i32| {
            let (from, to) = (f64::from(from), f64::from(to));
            (mean(to) - mean(from)) / (to - from) - 1.0
        };
        let (left, right) = (strain(1 + w, 29 - w), strain(31 + w, 59 - w));
        assert!(left > 0.0 && (left / right / factor - 1.0).abs() < 0.02, "{left} {right} {factor}");
    }
}

#[test]
fn a_zone_ends_smoothly_over_a_cell_and_zones_multiply() {
    let (h, edge) = (0.5, 3.0);
    let lattice = supple::Lattice::from_cells(&block([10, 1, 1]), h, Point3::origin(), true).unwrap();
    let cut = |x: f64| Selection::Box { min: [x, -9.0, -9.0], max: [99.0, 9.0, 9.0] };
    // The body lies along y: zones are in world space.
    let along_y = Selection::Box { min: [-9.0, edge + 0.2, -9.0], max: [9.0, 99.0, 9.0] };
    let build = |turn, zones: Vec<Zone>| {
        let body = Body::from_lattice(lattice.clone()).rotate([0.0, 0.0, turn]);
        zones.into_iter().fold(body, |body, zone| body.zone(zone)).build()
    };
    let body = build(90.0, vec![Zone::new(along_y, 8.0)]).unwrap();
    for (index, &factor) in body.lattice().indices().iter().zip(body.stiffness_factors().unwrap()) {
        let outside = (edge + 0.2 - h * f64::from(index[0])).max(0.0);
        let expected = 8_f64.powf((1.0 - outside / h).max(0.0));
        assert!((factor - expected).abs() < 1e-9, "{index:?}: {factor} {expected}");
    }
    let listed = Zone::new(Selection::Vertices(vec![3, 5]), 0.25);
    let body = build(0.0, vec![Zone::new(cut(0.0), 100.0), listed.clone(), listed]).unwrap();
    let factors = body.stiffness_factors().unwrap();
    assert!((factors[3] - 6.25).abs() < 1e-9 && factors[4] == 100.0 && (factors[5] - 6.25).abs() < 1e-9);

    let message = |zones| build(0.0, zones).unwrap_err().to_string();
    let outside = message(vec![Zone::new(cut(50.0), 2.0)]);
    assert!(outside.contains("selects nothing") && outside.contains("45.000000 outside"), "{outside}");
    let high = message(vec![Zone::new(cut(0.0), 100.5)]);
    assert_eq!(high, "factor = 100.5 is out of range: it must be in (0, 100]");
    let product = message(vec![Zone::new(cut(0.0), 50.0), Zone::new(cut(2.0), 4.0)]);
    assert!(product.starts_with("product of the factors of zones = 200"), "{product}");
    assert!(message(vec![Zone::new(cut(0.0), 0.0)]).contains("(0, 100]"));
}

#[test]
fn wrong_factors_are_errors_and_change_nothing() {
    let mut body = bare(&lattice(&block([2, 2, 2])), 1);
    let mut message = |factors: &[f64]| {
        let message = body.set_stiffness_factors(Some(factors)).unwrap_err().to_string();
        assert_eq!(body.stiffness_factors(), None);
        message
    };
    assert_eq!(message(&[1.0; 26]), "stiffness_factors has 26 entries; the body has 27 lattice vertices");
    for bad in [0.0, -1.0, 100.5, f64::NAN, f64::INFINITY] {
        let mut factors = [1.0; 27];
        factors[7] = bad;
        assert!(message(&factors).contains("(0, 100]"), "{bad}");
    }
    let product = message(&[2.0; 27]);
    assert!(product.contains("stiffness x the greatest stiffness factor = 2"), "{product}");
    body.set_stiffness(Stiffness::PerStep(0.5)).unwrap();
    body.set_stiffness_factors(Some(&[2.0; 27])).unwrap();
    assert!(body.set_stiffness(Stiffness::PerStep(0.6)).is_err());
    let Elasticity::Regions { stiffness, .. } = body.material().elasticity else { panic!() };
    assert_eq!(stiffness, Stiffness::PerStep(0.5));
}

#[test]
fn a_body_without_factors_is_that_of_before_and_takes_no_memory_for_them() {
    let cells = block([9, 5, 4]);
    let mut body = bare(&lattice(&cells), 2);
    body.set_stiffness(Stiffness::PerStep(0.5)).unwrap();
    let before = body.memory();
    let count = body.lattice().len();
    body.set_stiffness_factors(Some(&vec![1.5; count])).unwrap();
    // Three f32 for each lane and one f64 for each vertex.
    assert!(body.memory() >= before + 20 * count, "{} {before}", body.memory());
    body.set_stiffness_factors(None).unwrap();
    assert_eq!(body.memory(), before);
    let x = shaken(&rest(&lattice(&cells)), &mut Random(43));
    let run = |mut body: Body| {
        body.set_positions(&points(&x)).unwrap();
        let mut sim = Simulation::builder().body(body).gravity([0.0; 3]).build().unwrap();
        sim.steps(20);
        sim.body(0).positions()
    };
    let mut plain = bare(&lattice(&cells), 2);
    plain.set_stiffness(Stiffness::PerStep(0.5)).unwrap();
    assert_eq!(run(body), run(plain));
}

#[test]
fn an_undamped_body_with_factors_gains_no_energy() {
    let (cells, mut random) = (lattice(&block([8, 6, 5])), Random(44));
    let factors = random_factors(cells.len(), &mut random);
    let naive = Naive::new(&cells, 2, Regions::Staircase).with_factors(factors.clone()).listed();
    for collapsed in [false, true] {
        // At a point all rotations are optimal: the energy limiter acts.
        let scale = if collapsed { 1e-3 } else { 1.0 };
        let x: Vec<_> = shaken(&rest(&cells), &mut random).iter().map(|x| x * scale).collect();
        let mut body = varied(&cells, 2, &factors);
        body.set_positions(&points(&x)).unwrap();
        let mut sim =
            Simulation::builder().body(body).gravity([0.0; 3]).dt(1.0).sleep(false).build().unwrap();
        let energy = |sim: &Simulation| {
            naive.energy(&coordinates(&sim.body(0).positions()), &sim.body(0).velocities(), 0.01)
        };
        let first = energy(&sim);
        let elastic = sim.body(0).elastic_energy().unwrap();
        // The body is at rest, and a full cell weighs 1000.
        assert!((elastic / 1000.0 / first - 1.0).abs() < 1e-3, "{elastic} {first}");
        let mut most = 0.0_f64;
        for _ in 0..40 {
            sim.steps(25);
            most = most.max(energy(&sim));
        }
        // The energy that the leapfrog method keeps for harmonic motions varies with the rotations of the regions.
        assert!(most < 1.05 * first && most > 0.5 * first, "collapsed {collapsed}: {most} {first}");
    }
}

#[test]
fn a_saved_state_has_the_factors() {
    let cells = lattice(&block([6, 4, 4]));
    let factors = random_factors(cells.len(), &mut Random(45));
    let build = || {
        let body =
            Body::from_lattice(cells.clone()).youngs_modulus(1e5).spin([0.0, 5.0, 1.0]).build().unwrap();
        Simulation::builder().body(body).gravity([0.0; 3]).build().unwrap()
    };
    let (mut sim, mut other) = (build(), build());
    sim.bodies_mut()[0].set_stiffness_factors(Some(&factors)).unwrap();
    sim.steps(10);
    other.restore(&sim.state()).unwrap();
    assert_eq!(other.body(0).stiffness_factors(), Some(&factors[..]));
    sim.steps(10);
    other.steps(10);
    assert_eq!(sim.body(0).positions(), other.body(0).positions());
    let plain = build();
    sim.restore(&plain.state()).unwrap();
    assert_eq!(sim.body(0).stiffness_factors(), None);
}

#[test]
fn the_stiffest_zone_determines_steps_and_regions_and_is_reported_where_out_of_reach() {
    let cells = lattice(&block([12, 6, 6]));
    let selection = Selection::Box { min: [-1.0, -1.0, -1.0], max: [4.0, 9.0, 9.0] };
    let build = |modulus: f64, factor: f64| {
        let body = Body::from_lattice(cells.clone()).youngs_modulus(modulus);
        body.zone(Zone::new(selection.clone(), factor)).build().unwrap()
    };
    let auto = |body: Body| {
        let mut sim = Simulation::builder().body(body).fps(30.0).substeps(Substeps::Auto).build().unwrap();
        sim.step();
        assert_eq!(sim.body(0).softened(), None);
        (sim.substeps(), sim.body(0).half_width())
    };
    assert_eq!(auto(build(1e6, 9.0)), auto(build(9e6, 1e-3)));
    assert_ne!(auto(build(1e6, 9.0)), auto(build(1e6, 1.0)));

    // alpha of the stiffest regions is 1; the others keep their modulus.
    let world = Simulation::builder().body(build(1e8, 100.0)).fps(30.0).substeps(Substeps::Fixed(8));
    let mut sim = world.build().unwrap();
    sim.step();
    let softened = sim.body(0).softened().unwrap();
    assert_eq!((softened.key, softened.factor), ("youngs_modulus", 100.0));
    assert!((softened.specified / 1e10 - 1.0).abs() < 1e-9 && softened.in_force < 1e10);
    let modulus = sim.body(0).youngs_modulus().unwrap();
    assert!((modulus / 1e8 - 1.0).abs() < 1e-9 || modulus < softened.in_force * 1.001, "{modulus}");
    assert!(sim.body(0).positions().iter().all(|x| x.coords.iter().all(|x| x.is_finite())));
}
