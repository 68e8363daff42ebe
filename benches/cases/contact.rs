//! Measures the cost of contact in a step: for a fine mesh at rest on a plane, and for a fine mesh that falls
//! far above a plane. Each is compared with the same mesh in a simulation without a plane.

use supple::{Body, Collider, Material, Mesh, Preservation, Simulation};
use supple_benches::Target::AtMost;
use supple_benches::bodies::Statue;

use crate::frame::{LATTICE_VERTICES, QUADS};
use crate::measure::{Bench, Sampling};
use crate::step::step_alternately;

/// Number of steps after which the statue is at rest; they cover 1.5 s.
const SETTLING: u64 = 180;

pub(crate) fn bench(bench: &mut Bench) {
    bench.section("contact in a step: 1,000 lattice vertices, mesh of 60,002 vertices, one thread");
    let mesh = Statue::of_quads(QUADS).mesh();
    let simulation = |gravity: f64, ground: Option<f64>| simulate(&mesh, gravity, ground);

    let simulations = || {
        // The lowest point of the statue is at height 0.
        let mut resting = simulation(-9.81, Some(0.0));
        resting.steps(SETTLING);
        // Without gravity and ground, the same pose stays at rest without contact.
        let mut without_ground = simulation(0.0, None);
        let positions = resting.body(0).positions();
        without_ground.body_mut(0).set_positions(&positions).expect("positions are finite, one per vertex");
        [resting, without_ground]
    };
    compare(bench, ["resting on a plane", "resting on a plane", "without contact"], 0.10, simulations);

    // Gravity is so weak that the statue stays far above the ground in the longest run.
    let simulations = || [simulation(-1e-3, Some(-1e9)), simulation(-1e-3, None)];
    compare(bench, ["falling", "falling, nothing touched", "without a plane"], 0.01, simulations);
}

/// Measures how much longer a step of the first simulation takes than a step of the second one.
///
/// `names`: of the case, of its row, and of the second simulation. `target`: upper bound in milliseconds.
fn compare(bench: &mut Bench, names: [&str; 3], target: f64, simulations: impl Fn() -> [Simulation; 2]) {
    let [case, row, second] = names;
    let samples = bench.measure(["contact", case], Sampling::Many, simulations, step_alternately);
    if let Some(samples) = samples {
        let comparison = comparison(&samples, second);
        bench.row(row, (samples.difference(0, 1) * 1e3, "ms"), Some(AtMost(target)), comparison);
    }
}

/// Formats the times of both simulations; `label` describes the second one.
fn comparison(samples: &crate::measure::Samples<2>, label: &str) -> String {
    let [with_plane, without_plane] = [0, 1].map(|k| samples.seconds(k) * 1e3);
    format!("step: {with_plane:.3} ms, {label}: {without_plane:.3} ms")
}

/// Builds a simulation of the statue, with damping so that it comes to rest. `gravity` is along y; `ground`
/// is the height of a horizontal plane, if there is one.
fn simulate(mesh: &Mesh, gravity: f64, ground: Option<f64>) -> Simulation {
    let body = Body::builder(mesh.clone())
        .material(Material::fast_lsm())
        .lattice_vertices(LATTICE_VERTICES)
        .region_damping_rate(4.0)
        .volume(Preservation::Off)
        .build()
        .expect("the mesh and the body options are valid");
    let mut simulation =
        Simulation::builder().sleep(false).body(body).gravity([0.0, gravity, 0.0]).dt(1.0 / 120.0).threads(1);
    if let Some(height) = ground {
        simulation = simulation.collider(Collider::plane([0.0, height, 0.0], [0.0, 1.0, 0.0]));
    }
    simulation.build().expect("the simulation parameters are valid")
}
