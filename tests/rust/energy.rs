//! A body on which nothing acts gains no energy, however it is turned inside out.

use crate::common::{Random, block, coordinates, lattice};
use nalgebra::{Point3, Vector3};
use supple::reference::{Naive, Regions};
use supple::{Body, Lattice, Simulation};

const DT: f64 = 1.0 / 60.0;

/// In cell masses times (cells per step)², for alpha 1.
fn energy(naive: &Naive, body: &Body) -> f64 {
    let velocities: Vec<_> = body.velocities().iter().map(|v| v * DT).collect();
    naive.energy(&coordinates(&body.positions()), &velocities, 1.0)
}

/// An undamped block whose vertices have changed places.
fn shuffled(lattice: &Lattice, half_width: usize, threads: usize) -> Simulation {
    let mut body = Body::from_lattice(lattice.clone()).half_width(half_width).build().unwrap();
    let mut random = Random(31);
    let mut positions = body.positions();
    for i in (1..positions.len()).rev() {
        positions.swap(i, (random.unit() * i as f64) as usize);
    }
    body.set_positions(&positions).unwrap();
    Simulation::builder().body(body).gravity([0.0; 3]).dt(DT).threads(threads).build().unwrap()
}

/// An undamped block in one point.
fn collapsed(lattice: &Lattice, half_width: usize) -> Simulation {
    let mut sim = shuffled(lattice, half_width, 1);
    let count = lattice.len();
    sim.body_mut(0).set_positions(&vec![Point3::from(Vector3::repeat(2.0)); count]).unwrap();
    sim
}

#[test]
fn a_body_that_is_turned_inside_out_again_and_again_gains_no_energy() {
    let lattice = lattice(&block([8, 6, 5]));
    for (name, half_width, mut sim) in
        [("shuffled", 1, shuffled(&lattice, 1, 1)), ("collapsed", 4, collapsed(&lattice, 4))]
    {
        let naive = Naive::new(&lattice, half_width, Regions::Staircase).listed();
        let start = energy(&naive, &sim.body(0));
        for _ in 0..40 {
            sim.steps(50);
            let now = energy(&naive, &sim.body(0));
            assert!(now < 1.02 * start, "{name}: {start} became {now} in {} steps", sim.step_count());
            assert!(now > 0.5 * start, "{name}: {start} became {now} in {} steps", sim.step_count());
        }
        assert!(sim.body(0).unsettled_rotations() > 1000, "{name}");
    }
}

#[test]
fn it_has_the_same_bits_for_any_number_of_threads() {
    let lattice = lattice(&block([20, 19, 18]));
    let after = |threads| {
        let mut sim = shuffled(&lattice, 1, threads);
        sim.steps(20);
        assert!(sim.body(0).unsettled_rotations() > 1000);
        (sim.body(0).positions(), sim.body(0).velocities())
    };
    let alone = after(1);
    assert!(after(2) == alone && after(3) == alone);
}

#[test]
fn it_goes_on_from_a_state_bit_for_bit() {
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
