//! The cost of contact in a step: a fine mesh at rest on a plane, and one in free fall without contact.

use supple::{Body, Collider, Mesh, Preservation, Simulation};
use supple_benches::Target::AtMost;
use supple_benches::bodies::Statue;

use crate::frame::{LATTICE_VERTICES, QUADS};
use crate::measure::{Bench, Sampling};
use crate::step::interleaved;

/// Steps until the statue is at rest: 1.5 s.
const SETTLING: u64 = 180;

pub(crate) fn bench(bench: &mut Bench) {
    bench.part("contact in a step: 1,000 lattice vertices, mesh of 60,002 vertices, one thread");
    let mesh = Statue::of_quads(QUADS).mesh();
    let simulation = |gravity: f64, ground: Option<f64>| stand(&mesh, gravity, ground);

    let pair = || {
        // The lowest point of the statue is at height 0.
        let mut resting = simulation(-9.81, Some(0.0));
        resting.steps(SETTLING);
        let mut floating = simulation(0.0, None);
        let positions = resting.body(0).positions();
        floating.body_mut(0).set_positions(&positions).expect("one finite position per vertex");
        [resting, floating]
    };
    let samples = bench.measure(["contact", "resting on a plane"], Sampling::Many, pair, interleaved);
    if let Some(samples) = samples {
        let comparison = comparison(&samples, "without contact");
        bench.row(
            "resting on a plane",
            (samples.difference(0, 1) * 1e3, "ms"),
            Some(AtMost(0.10)),
            comparison,
        );
    }

    // Gravity is so small that the statue stays far from the ground in the longest run.
    let pair = || [simulation(-1e-3, Some(-1e9)), simulation(-1e-3, None)];
    if let Some(samples) = bench.measure(["contact", "falling"], Sampling::Many, pair, interleaved) {
        let comparison = comparison(&samples, "without a plane");
        bench.row(
            "falling, nothing touched",
            (samples.difference(0, 1) * 1e3, "ms"),
            Some(AtMost(0.01)),
            comparison,
        );
    }
}

fn comparison(samples: &crate::measure::Samples<2>, without: &str) -> String {
    let [with, other] = [0, 1].map(|k| samples.seconds(k) * 1e3);
    format!("step: {with:.3} ms, {without}: {other:.3} ms")
}

/// Builds a simulation of the statue, with damping so that it comes to rest.
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
