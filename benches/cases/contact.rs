//! What contact adds to a step: a fine mesh at rest on a plane, and one that falls and touches nothing.

use supple::{Body, Collider, Mesh, Preservation, Simulation};
use supple_benches::Target::AtMost;
use supple_benches::bodies::Statue;

use crate::frame::{LATTICE_VERTICES, QUADS};
use crate::measure::{Bench, Sampling};
use crate::step::in_turn;

/// A second and a half, until the statue stands still.
const SETTLING: u64 = 180;

pub(crate) fn bench(bench: &mut Bench) {
    bench.part("contact in a step: 1,000 lattice vertices, mesh of 60,002 vertices, one thread");
    let mesh = Statue::of_quads(QUADS).mesh();
    let simulation = |gravity: f64, ground: Option<f64>| stand(&mesh, gravity, ground);

    let pair = || {
        // The statue stands on its foot, at a height of 0.
        let mut resting = simulation(-9.81, Some(0.0));
        resting.steps(SETTLING);
        let mut floating = simulation(0.0, None);
        let places = resting.body(0).positions();
        floating.body_mut(0).set_positions(&places).expect("as many positions");
        [resting, floating]
    };
    let samples = bench.measure(["contact", "resting on a plane"], Sampling::Many, pair, in_turn);
    if let Some(samples) = samples {
        let beside = beside(&samples, "without contact");
        bench.row("resting on a plane", (samples.difference(0, 1) * 1e3, "ms"), Some(AtMost(0.10)), beside);
    }

    // So slow that it does not come near the ground in the longest run.
    let pair = || [simulation(-1e-3, Some(-1e9)), simulation(-1e-3, None)];
    if let Some(samples) = bench.measure(["contact", "falling"], Sampling::Many, pair, in_turn) {
        let beside = beside(&samples, "without a plane");
        bench.row(
            "falling, nothing touched",
            (samples.difference(0, 1) * 1e3, "ms"),
            Some(AtMost(0.01)),
            beside,
        );
    }
}

fn beside(samples: &crate::measure::Samples<2>, without: &str) -> String {
    let [with, other] = [0, 1].map(|rival| samples.seconds(rival) * 1e3);
    format!("step: {with:.3} ms, {without}: {other:.3} ms")
}

/// The statue where it is, damped as things are that come to rest.
fn stand(mesh: &Mesh, gravity: f64, ground: Option<f64>) -> Simulation {
    let body = Body::builder(mesh.clone())
        .lattice_vertices(LATTICE_VERTICES)
        .region_damping_rate(4.0)
        .volume(Preservation::Off)
        .build()
        .expect("a closed surface is a body");
    let mut simulation =
        Simulation::builder().body(body).gravity([0.0, gravity, 0.0]).dt(1.0 / 120.0).threads(1);
    if let Some(height) = ground {
        simulation = simulation.collider(Collider::plane([0.0, height, 0.0], [0.0, 1.0, 0.0]));
    }
    simulation.build().expect("numbers in range")
}
