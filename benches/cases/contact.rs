//! Measures the cost of contact in a step: for a fine mesh at rest on a plane, and for a fine mesh that falls
//! far above a plane, each compared with the same mesh in a simulation without a plane; for a large cube on a plane, for a
//! rigid body, for bodies that touch no other body, and for a heap of bodies in a bin.

use std::time::Duration;

use supple::{
    Body, Collider, Lattice, Material, Mesh, Preservation, Simulation, SimulationBuilder, Substeps,
};
use supple_benches::Target::AtMost;
use supple_benches::bodies::{Statue, block};

use crate::frame::{LATTICE_VERTICES, QUADS};
use crate::measure::{Bench, Sampling, timed};
use crate::step::step_alternately;

/// Lattice vertices along each axis of the bodies that touch each other, or could: 729 in total.
const CUBE: i32 = 9;
/// Lattice vertices along each axis of the cube on a plane: 10,648 in total, of which 484 touch the plane.
const LARGE_CUBE: i32 = 22;
/// Quads along each edge of the cube from which the rigid statue is made.
const RIGID_QUADS: usize = 29;
/// Number of bodies that are far from each other.
const FAR: usize = 100;
/// Frames, at 60 frames per second, after which the heap has fallen together and is not at rest.
const FALL: u64 = 60;

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
    lying(bench);
    rigid(bench);
    far(bench);
    heaps(bench);
}

/// Measures a step of a large cube on a plane, relative to a step without gravity and plane.
fn lying(bench: &mut Bench) {
    bench.section("a cube of 10,648 lattice vertices on a plane, E = 1 MPa, edge 1 m, one thread, full step");
    let simulation = |gravity: f64, ground: Option<Collider>| {
        let body = Body::from_lattice(block([LARGE_CUBE; 3])).scale(1.0 / f64::from(LARGE_CUBE - 1));
        let body = body.youngs_modulus(1e6).volume(Preservation::Off).build().expect("the body is valid");
        let empty = Simulation::builder().gravity([0.0, gravity, 0.0]).fps(60.0).substeps(Substeps::Auto);
        let all =
            ground.into_iter().fold(empty.body(body).threads(1).sleep(false), SimulationBuilder::collider);
        let mut simulation = all.build().expect("the simulation is valid");
        simulation.advance(FALL);
        simulation
    };
    let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let simulations = || [simulation(-9.81, Some(ground.clone())), simulation(0.0, None)];
    let samples = bench.measure(["contact", "lying"], Sampling::Many, simulations, step_alternately);
    if let Some(samples) = samples {
        let comparison = comparison(&samples, "free");
        bench.row("on a plane, against free", (samples.ratio(0, 1), "times"), Some(AtMost(1.3)), comparison);
    }
}

/// Measures a step of a rigid body in flight, beside a collider and alone.
fn rigid(bench: &mut Bench) {
    bench.section("a rigid mesh of 5,048 vertices in flight, one thread, full step");
    let mesh = Statue::of_quads(RIGID_QUADS).mesh();
    let simulation = |collider: bool| {
        let body = Body::builder(mesh.clone()).rigid(true).spin([0.1, 0.2, 0.3]).build();
        let ground = collider.then(|| Collider::plane([0.0, -1e3, 0.0], [0.0, 1.0, 0.0]));
        let empty = Simulation::builder().gravity([0.0; 3]).dt(1.0 / 240.0).threads(1).sleep(false);
        let all = ground
            .into_iter()
            .fold(empty.body(body.expect("the body is valid")), SimulationBuilder::collider);
        all.build().expect("the simulation is valid")
    };
    let simulations = || [simulation(true), simulation(false)];
    let samples = bench.measure(["contact", "rigid"], Sampling::Many, simulations, step_alternately);
    if let Some(samples) = samples {
        let [beside, alone] = [0, 1].map(|k| samples.seconds(k) * 1e6);
        let comparison = format!("alone: {alone:.2} us");
        bench.row("rigid body, a collider far away", (beside, "us"), Some(AtMost(2.0)), comparison);
    }
}

/// Measures what contact between bodies costs bodies that are far from each other.
fn far(bench: &mut Bench) {
    bench.section("100 bodies of 729 lattice vertices far from each other, one thread, full step");
    let simulation = |contact: bool| {
        let bodies = (0..FAR).map(|k| cube().translate([20.0 * k as f64, 0.0, 0.0]).spin([0.1, 0.2, 0.3]));
        let empty = Simulation::builder().gravity([0.0; 3]).dt(1.0 / 240.0).contact(contact).threads(1);
        let all = bodies.fold(empty, |all, body| all.body(body.build().expect("the body is valid")));
        all.sleep(false).build().expect("the simulation is valid")
    };
    let simulations = || [simulation(true), simulation(false)];
    let samples = bench.measure(["contact", "far bodies"], Sampling::Many, simulations, step_alternately);
    if let Some(samples) = samples {
        let [with, without] = [0, 1].map(|k| samples.seconds(k) * 1e3);
        let comparison = format!("{with:.2} ms, {without:.2} ms");
        bench.row(
            "with contact between bodies, against without",
            (samples.ratio(0, 1), "times"),
            Some(AtMost(1.03)),
            comparison,
        );
    }
}

/// Measures a frame of cubes that fall together in a bin.
fn heaps(bench: &mut Bench) {
    bench.section("cubes of 729 lattice vertices that move in a bin, E = 0.1 MPa, edge 1 m, one thread, frame of 1/60 s");
    for (count, target) in [(10, 10.0), (30, 40.0)] {
        let start = || {
            let mut simulation = heap(count);
            simulation.advance(FALL);
            let state = simulation.state();
            (simulation, state)
        };
        // Each sample begins with the same state, so that no heap comes to rest.
        let frames = |(simulation, state): &mut (Simulation, _), count: u64| {
            let mut total = Duration::ZERO;
            for _ in 0..count {
                simulation.restore(state).expect("the state is that of the simulation");
                simulation.advance(1);
                total += timed(|| simulation.advance(1));
            }
            [total]
        };
        let samples = bench.measure(["contact", &format!("{count} cubes")], Sampling::Few, start, frames);
        if let Some(samples) = samples {
            let measured = (samples.seconds(0) * 1e3, "ms");
            bench.row(&format!("{count} cubes"), measured, Some(AtMost(target)), "");
        }
    }
}

/// Returns a cube of edge 1 m.
fn cube() -> supple::BodyBuilder {
    let lattice: Lattice = block([CUBE; 3]);
    Body::from_lattice(lattice).scale(1.0 / f64::from(CUBE - 1)).youngs_modulus(1e5).volume(Preservation::Off)
}

/// Builds cubes above a bin.
fn heap(count: usize) -> Simulation {
    let wall = |x: f64, z: f64| Collider::plane([-1.6 * x, 0.0, -1.6 * z], [x, 0.0, z]);
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let mut simulation = Simulation::builder().fps(60.0).substeps(Substeps::Auto).threads(1).collider(floor);
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        simulation = simulation.collider(wall(x, z));
    }
    for k in 0..count {
        let [column, layer] = [(k % 4) as f64, (k / 4) as f64];
        let place = |side: f64, shift: f64| 0.8 * side + 0.05 * shift - 0.5;
        let side = |is_high: bool| if is_high { 1.0 } else { -1.0 };
        let x = place(side(k % 2 == 1), column.sin());
        let z = place(side(k % 4 >= 2), layer.cos());
        let turn = [13.0, 7.0, 29.0].map(|degrees| degrees * k as f64);
        let body = cube().rotate(turn).translate([x, 1.0 + 1.5 * layer, z]).build();
        simulation = simulation.body(body.expect("the body is valid"));
    }
    simulation.build().expect("the simulation is valid")
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
