//! Regions of one cell: Young's modulus, Poisson's ratio and bending as asked at every thickness, even layers under plates
//! and between handles, partly filled cells.

use supple::reference::{Naive, Regions};
use supple::{
    Body, BodyRef, Collider, ElasticLaw, Elasticity, HalfWidth, Handle, Key, Material, Pin, RegionSize,
    Selection, Simulation, Stiffness, TimeWindow,
};
use supple_tests::{
    Random, ball, block, coordinates, lattice, points, rest, tolerance, without_gravity, worst,
};

use crate::poisson::{assert_keeps_momenta, body, deformed, layer, mean_position, pulled, strains};

/// Returns Young's modulus of cells at the greatest alpha.
fn modulus(body: &BodyRef<'_>, dt: f64, poisson_ratio: f64) -> f64 {
    let (density, cell_size) = (body.material().density, body.lattice().cell_size());
    let law = ElasticLaw { density, cell_size, dt, poisson_ratio };
    law.modulus(HalfWidth::CELL, law.greatest_alpha())
}

/// In the middle of a bar whose ends are held, pulled and pressed: the mean of both leaves out what the square of the strain
/// adds.
#[test]
fn poisson_ratio_and_youngs_modulus_are_as_asked_at_every_thickness() {
    for (length, thickness) in [(13, 1), (14, 2), (20, 4), (30, 6)] {
        for ratio in [0.0, 0.3, 0.45] {
            let measured = [0.002, -0.002].map(|strain| {
                let simulation = pulled([length, thickness], HalfWidth::CELL, ratio, strain);
                let body = simulation.body(0);
                let [along, across] = strains(&body, [length, thickness]);
                let force = body.hold_force(0).unwrap().unwrap().force.x.abs();
                let stress = force / f64::from(thickness * thickness);
                [-across / along, stress / along.abs() / modulus(&body, simulation.dt(), ratio)]
            });
            let [found, stiffness] = [0, 1].map(|k| (measured[0][k] + measured[1][k]) / 2.0);
            // Goal positions round by up to 1e-5 cells, which is 0.005 of the strain of one cell.
            let limit = 0.002 + 0.005 / f64::from(thickness);
            assert!((found - ratio).abs() <= limit, "{thickness}: {found} for {ratio}");
            assert!((stiffness - 1.0).abs() <= limit, "{thickness}, {ratio}: {stiffness}");
        }
    }
}

/// A beam that is held at one end sinks under its weight by q L⁴/(8 E I) at its tip and, by shear, by q L²/(2 5/6 G A), with
/// E I that is 1 + 2/t² times the one of a solid of t cells.
#[test]
fn bending_has_the_stiffness_of_the_law() {
    for thickness in [1, 2, 4] {
        let length = 16 * thickness;
        let lattice = lattice(&block([length, thickness, thickness]));
        let pin = Pin { goal: None, selection: layer(0.0), window: TimeWindow::default() };
        // The lowest mode of the free beam has 6.36 times the frequency of the held one.
        let body = body(&lattice, HalfWidth::CELL, 0.0).damping_ratio(1.0 / 6.36).pin(pin).build().unwrap();
        let (dt, density) = (1.0 / 60.0, body.material().density);
        let law = ElasticLaw { density, cell_size: 1.0, dt, poisson_ratio: 0.0 };
        let e = law.modulus(HalfWidth::CELL, 1.0);
        let (t, l) = (f64::from(thickness), f64::from(length));
        let inertia = t.powi(4) / 12.0 * (1.0 + 2.0 / (t * t));
        let per_load = l.powi(4) / (8.0 * e * inertia) + l.powi(2) / (2.0 * 5.0 / 6.0 * e / 2.0 * t * t);
        let expected = 0.01 * l;
        let gravity = expected / per_load / (density * t * t);
        let omega = 3.516 * (e * inertia / (density * t * t)).sqrt() / (l * l);
        let simulation = Simulation::builder().body(body).gravity([0.0, -gravity, 0.0]).dt(dt).sleep(false);
        let mut simulation = simulation.build().unwrap();
        simulation.steps((12.0 / omega / dt) as u64);
        let body = simulation.body(0);
        let tip =
            body.lattice().indices().iter().zip(body.positions()).filter(|(index, _)| index[0] == length);
        let sunk: Vec<f64> = tip.map(|(index, x)| f64::from(index[1]) - x.y).collect();
        let found = sunk.iter().sum::<f64>() / sunk.len() as f64 / expected;
        assert!((found - 1.0).abs() <= 0.01, "{thickness}: {found}");
    }
}

/// Handles hold a layer of cells at each end of a bar and pull it to 1.5 times its length: the free layers stretch evenly.
#[test]
fn layers_between_handles_stretch_evenly() {
    let lattice = lattice(&block([12, 4, 4]));
    let end = |low: f64, high: f64| Selection::Box { min: [low, -1.0, -1.0], max: [high, 5.0, 5.0] };
    let keys = vec![
        Key { time: 0.0, translate: [0.0; 3], rotate: [0.0; 3] },
        Key { time: 1.0, translate: [6.0, 0.0, 0.0], rotate: [0.0; 3] },
    ];
    let window = TimeWindow::default();
    let pin = Pin { goal: None, selection: end(-0.1, 1.1), window };
    let handle = Handle { goal: None, selection: end(10.9, 12.1), motion: keys.into(), window };
    let body = body(&lattice, HalfWidth::CELL, 0.0).damping_ratio(1.0).pin(pin).handle(handle);
    let mut simulation = without_gravity(body.build().unwrap());
    simulation.steps(60 * 20);
    let body = simulation.body(0);
    let mean = |layer: i32| mean_position(&body, 0, |index| index[0] == layer);
    // Ten free layers of cells share the six cells by which the bar is longer.
    for layer in 1..11 {
        let stretch = mean(layer + 1) - mean(layer);
        assert!((stretch - 1.6).abs() <= 0.002, "{layer}: {stretch}");
    }
}

/// A cube between plates without friction that is pressed to 0.6: every layer has this height, and the force is that of the
/// solid.
#[test]
fn layers_under_plates_have_the_height_of_all() {
    let lattice = lattice(&block([8, 8, 8]));
    let keys = vec![
        Key { time: 0.0, translate: [0.0; 3], rotate: [0.0; 3] },
        Key { time: 4.0, translate: [0.0, -3.2, 0.0], rotate: [0.0; 3] },
    ];
    let ground = Collider { friction: 0.0, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let plate = Collider { friction: 0.0, keys, ..Collider::plane([0.0, 8.0, 0.0], [0.0, -1.0, 0.0]) };
    let body = body(&lattice, HalfWidth::CELL, 0.0).damping_ratio(1.0).build().unwrap();
    let simulation = Simulation::builder().body(body).collider(ground).collider(plate).gravity([0.0; 3]);
    let mut simulation = simulation.dt(1.0 / 60.0).build().unwrap();
    simulation.steps(60 * 12);
    let body = simulation.body(0);
    let mean = |layer: i32| mean_position(&body, 1, |index| index[1] == layer);
    for layer in 0..8 {
        let height = mean(layer + 1) - mean(layer);
        assert!((height - 0.6).abs() <= 0.005, "{layer}: {height}");
    }
    let forces = simulation.contacts();
    let force: f64 = forces.iter().map(|contact| contact.force[1].abs()).sum::<f64>() / 2.0;
    let expected = modulus(&body, simulation.dt(), 0.0) * 64.0 * 0.4;
    assert!((force / expected - 1.0).abs() <= 0.02, "{force} for {expected}");
}

#[test]
fn goals_of_partly_filled_cells_equal_the_reference() {
    let mut random = Random(61);
    for ratio in [0.0, 0.4] {
        let elasticity = Elasticity::Regions {
            size: RegionSize::Cells(HalfWidth::CELL),
            stiffness: Stiffness::PerStep(0.3),
        };
        let material = Material { elasticity, poisson_ratio: Some(ratio), ..Material::fast_lsm() };
        let mut body = Body::builder(ball(1.0)).cell_size(0.31).material(material).build().unwrap();
        let shares = body.cell_shares();
        assert!(shares.iter().any(|&share| share < 0.5) && shares.contains(&1.0));
        let x = deformed(&rest(body.lattice()), [1.2, 0.9, -0.8], 0.05, &mut random);
        body.set_positions(&points(&x)).unwrap();
        let (x, lattice) = (coordinates(&body.positions()), body.lattice().clone());
        let naive = Naive::new(&lattice, 0.5, Regions::Staircase).with_material_of(&body);
        let error = worst(&coordinates(&body.goals()), &naive.goals(&naive.motions(&x)));
        assert!(error <= 20.0 * 0.31 * tolerance(8.0), "{ratio}: {error:e}");
    }
}

#[test]
fn cells_keep_both_momenta() {
    let mut random = Random(62);
    let body = Body::builder(ball(1.0)).cell_size(0.25).material(Material::fast_lsm()).half_width(0.5);
    let body = body.stiffness(0.9).build().unwrap();
    let x = deformed(&rest(body.lattice()), [1.2, 0.8, 1.0], 0.05, &mut random);
    assert_keeps_momenta(body, &x);
}
