//! Measures the cost of elastic damping in a step, and of a step of bodies at rest, which sleep.

use supple::{Body, Collider, Material, Preservation, Simulation, Substeps};
use supple_benches::Target::AtMost;
use supple_benches::bodies::{self, block};

use crate::measure::{Bench, Sampling, steps};
use crate::step::{MIDDLE, step_alternately};

/// Lattice vertices of a resting block along x, y and z; 500 in total.
const RESTING: [i32; 3] = [10, 5, 10];
/// Number of resting bodies.
const BODIES: usize = 100;
/// Number of frames, at 60 frames per second, after which the blocks sleep at the latest.
const SETTLING: u64 = 600;

pub(crate) fn bench(bench: &mut Bench) {
    damped(bench);
    resting(bench);
}

/// Measures the step of a block of 97,336 lattice vertices with elastic damping, relative to the undamped step. The rate
/// is so low that both bodies keep moving.
fn damped(bench: &mut Bench) {
    bench.section("elastic damping: solid block, 97,336 lattice vertices, w = 2, two threads, full step");
    let lattice = block(MIDDLE);
    let body = || Body::from_lattice(lattice.clone()).material(Material::fast_lsm()).half_width(2);
    let simulations =
        || [bodies::simulation([body().damping_rate(1e-3)], 2), bodies::simulation([body()], 2)];
    let samples = bench.measure(["step 100,000", "damped"], Sampling::Many, simulations, step_alternately);
    if let Some(samples) = samples {
        let [damped, undamped] = [0, 1].map(|k| samples.seconds(k) * 1e9 / lattice.len() as f64);
        let comparison = format!("{damped:.1} ns, {undamped:.1} ns");
        let ratio = (samples.ratio(0, 1), "times");
        bench.row("damped against undamped", ratio, Some(AtMost(1.15)), comparison);
    }
}

/// Measures a step of 100 bodies that sleep on the ground, and of the same bodies while they are awake.
fn resting(bench: &mut Bench) {
    bench.section("100 bodies of 500 lattice vertices at rest on the ground, two threads, full step");
    let simulations = || {
        let asleep = settled(true);
        assert!(asleep.bodies().iter().all(Body::is_asleep), "all bodies sleep");
        [asleep, settled(false)]
    };
    let alternately = |simulations: &mut [Simulation; 2], count| {
        // A step of awake bodies takes a thousand times as long, so one is enough.
        let [asleep, awake] = simulations;
        [steps(asleep, count), steps(awake, 1) * u32::try_from(count).unwrap_or(u32::MAX)]
    };
    let samples = bench.measure(["step 100 x 500", "at rest"], Sampling::Many, simulations, alternately);
    if let Some(samples) = samples {
        let [asleep, awake] = [0, 1].map(|k| samples.seconds(k) * 1e3);
        let comparison = format!("without sleep: {awake:.3} ms");
        bench.row("asleep", (asleep, "ms"), Some(AtMost(0.1)), comparison);
    }
}

/// Builds blocks of the default material that come to rest on the ground.
fn settled(sleep: bool) -> Simulation {
    let ground = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let simulation = Simulation::builder().collider(ground).fps(60.0).substeps(Substeps::Auto).sleep(sleep);
    let lattice = block(RESTING);
    let blocks = (0..BODIES).map(|index| {
        let [column, row] = [index % 10, index / 10].map(|i| 20.0 * i as f64);
        let body = Body::from_lattice(lattice.clone()).volume(Preservation::Off);
        body.translate([column, 0.0, row]).build().expect("the body options are valid")
    });
    let simulation = blocks.fold(simulation.threads(2), |simulation, body| simulation.body(body));
    let mut simulation = simulation.build().expect("the simulation parameters are valid");
    simulation.advance(SETTLING);
    simulation
}
