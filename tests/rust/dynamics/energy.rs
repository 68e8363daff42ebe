//! A free body gains no energy while its cells invert.

use nalgebra::{Point3, Vector3};
use supple::reference::{Naive, Regions};
use supple::{Body, Lattice, Material, Simulation};
use supple_tests::{Random, block, coordinates, lattice};

const DT: f64 = 1.0 / 60.0;

/// Returns the energy for alpha = 1, in cell masses times (cells per step)².
fn energy(naive: &Naive, body: &Body) -> f64 {
    let velocities: Vec<_> = body.velocities().iter().map(|v| v * DT).collect();
    naive.energy(&coordinates(&body.positions()), &velocities, 1.0)
}

/// Returns an undamped block whose vertex positions are shuffled.
fn shuffled(lattice: &Lattice, half_width: usize, threads: usize) -> Simulation {
    let mut body = Body::from_lattice(lattice.clone())
        .material(Material::fast_lsm())
        .half_width(half_width)
        .build()
        .unwrap();
    let mut random = Random(31);
    let mut positions = body.positions();
    for i in (1..positions.len()).rev() {
        positions.swap(i, (random.unit() * i as f64) as usize);
    }
    body.set_positions(&positions).unwrap();
    Simulation::builder().body(body).gravity([0.0; 3]).dt(DT).threads(threads).build().unwrap()
}

/// Returns an undamped block whose vertices coincide.
fn collapsed(lattice: &Lattice, half_width: usize) -> Simulation {
    let mut sim = shuffled(lattice, half_width, 1);
    let count = lattice.len();
    sim.body_mut(0).set_positions(&vec![Point3::from(Vector3::repeat(2.0)); count]).unwrap();
    sim
}

#[test]
fn shuffled_and_collapsed_bodies_gain_no_energy() {
    let lattice = lattice(&block([8, 6, 5]));
    for (name, half_width, mut sim) in
        [("shuffled", 1, shuffled(&lattice, 1, 1)), ("collapsed", 4, collapsed(&lattice, 4))]
    {
        let naive = Naive::new(&lattice, half_width, Regions::Staircase).listed();
        let start = energy(&naive, &sim.body(0));
        for _ in 0..40 {
            sim.steps(50);
            let now = energy(&naive, &sim.body(0));
            // Regression bounds.
            assert!(now < 1.02 * start, "{name}: {start} became {now} in {} steps", sim.step_count());
            assert!(now > 0.5 * start, "{name}: {start} became {now} in {} steps", sim.step_count());
        }
        assert!(sim.body(0).unconverged_rotations() > 1000, "{name}");
    }
}

#[test]
fn shuffled_bodies_have_the_same_bits_for_any_number_of_threads() {
    let lattice = lattice(&block([20, 19, 18]));
    let after = |threads| {
        let mut sim = shuffled(&lattice, 1, threads);
        sim.steps(20);
        assert!(sim.body(0).unconverged_rotations() > 1000);
        (sim.body(0).positions(), sim.body(0).velocities())
    };
    let alone = after(1);
    assert!(after(2) == alone && after(3) == alone);
}

#[test]
fn shuffled_bodies_continue_from_a_state_bit_for_bit() {
    let lattice = lattice(&block([8, 6, 5]));
    let mut sim = shuffled(&lattice, 1, 1);
    sim.steps(200);
    let state = sim.state();
    sim.steps(200);
    let mut again = shuffled(&lattice, 1, 1);
    again.restore(&state).unwrap();
    again.steps(200);
    assert!(sim.state() == again.state());
}
