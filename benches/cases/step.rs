//! Times the full step of solid blocks and of the bust: region matching, integration and momentum tracker,
//! without the evaluation for display.

use std::time::Duration;

use supple::{Body, Display, Lattice, Material, Simulation, When};
use supple_benches::Target::{self, AtLeast, AtMost};
use supple_benches::bodies::{self, block, bust_lattice, in_motion};

use crate::bandwidth::Bandwidth;
use crate::measure::{Bench, Sampling, steps};
use crate::memory::allocated_by;

/// Lattice vertices of the large block along x, y and z; 1,000,000 in total.
const LARGE: [i32; 3] = [100, 100, 100];
/// Lattice vertices of the middle block along x, y and z; 97,336 in total.
pub(crate) const MIDDLE: [i32; 3] = [46, 46, 46];
/// Lattice vertices of the small block along x, y and z; 1,000 in total.
pub(crate) const SMALL: [i32; 3] = [10, 10, 10];

pub(crate) fn bench(bench: &mut Bench, bandwidth: Option<&Bandwidth>) {
    large(bench, bandwidth);
    middle(bench);
    small(bench);
    many(bench);
}

/// Measures a block of 1,000,000 lattice vertices: the time of a step on one and two threads, the memory
/// traffic, the allocated memory, and wide regions relative to narrow ones.
fn large(bench: &mut Bench, bandwidth: Option<&Bandwidth>) {
    bench.section("solid block, 1,000,000 lattice vertices, full step");
    let lattice = block(LARGE);
    let on_two_threads = |half_width| in_motion(&lattice, half_width, 2);
    let per_vertex = 1e9 / lattice.len() as f64;

    let simulations = || [on_two_threads(2), in_motion(&lattice, 2, 1)];
    let samples = bench.measure(["step 1,000,000", "w=2"], Sampling::Few, simulations, step_alternately);
    if let Some(samples) = samples {
        let [two_threads, one_thread] = [0, 1].map(|k| samples.seconds(k) * per_vertex);
        let comparison = format!("one thread: {one_thread:.1} ns");
        bench.row("w = 2, two threads", (two_threads, "ns/vertex"), Some(AtMost(22.0)), comparison);
        let comparison = format!("{one_thread:.1} ns, {two_threads:.1} ns");
        bench.row(
            "w = 2, two threads against one",
            (samples.ratio(1, 0), "times"),
            Some(AtLeast(1.7)),
            comparison,
        );
        let simulation = on_two_threads(2);
        bandwidth_bound(bench, &simulation, bandwidth, [(1, one_thread), (2, two_threads)]);
        drop(simulation);
        memory(bench, "total memory", Some(AtMost(200.0)), || {
            let mut simulation = on_two_threads(2);
            simulation.step();
            (simulation, Display::new())
        });
        memory(bench, "total memory with volume preservation and display", None, || {
            stepped_and_evaluated(&lattice)
        });
    }
    for (half_width, limit) in [(8, 1.5), (16, 2.0)] {
        let simulations = || [on_two_threads(half_width), on_two_threads(2)];
        let name = format!("w={half_width}");
        let samples = bench.measure(["step 1,000,000", &name], Sampling::Few, simulations, step_alternately);
        if let Some(samples) = samples {
            let [wide, narrow] = [0, 1].map(|k| samples.seconds(k) * per_vertex);
            let case = format!("w = {half_width} against w = 2, two threads");
            let comparison = format!("{wide:.1} ns, {narrow:.1} ns");
            bench.row(&case, (samples.ratio(0, 1), "times"), Some(AtMost(limit)), comparison);
        }
    }
}

/// Adds the lower bound of the time of a step that follows from the memory bandwidth. A step must at least
/// read all its buffers once and write the state (positions, velocities, rotations) once. `measured` contains
/// thread counts and the measured times of a step in ns per lattice vertex.
fn bandwidth_bound(
    bench: &mut Bench,
    simulation: &Simulation,
    bandwidth: Option<&Bandwidth>,
    measured: [(usize, f64); 2],
) {
    let body = &simulation.plan().bodies[0];
    let stages = || body.stages.iter().filter(|stage| stage.when == When::Step);
    let bytes = (2 * body.state_bytes + stages().map(|stage| stage.bytes).sum::<usize>()) as f64;
    let bytes = bytes / simulation.body(0).lattice().len() as f64;
    bench.row(
        "minimum memory traffic of a step",
        (bytes, "bytes/vertex"),
        None,
        "all buffers read once, the state written once",
    );
    let Some(bandwidth) = bandwidth else { return };
    for (threads, nanoseconds) in measured {
        let minimum = bytes / bandwidth.with_threads(threads) * 1e9;
        let case = format!("share of the memory bandwidth, threads: {threads}");
        bench.row(&case, (100.0 * minimum / nanoseconds, "%"), None, format!("minimum: {minimum:.1} ns"));
    }
}

/// Adds the bytes that remain allocated for the simulation and the display that `build` returns, and compares
/// them with the bytes that [`Simulation::plan`] and the display report.
fn memory(
    bench: &mut Bench,
    case: &str,
    target: Option<Target>,
    build: impl FnOnce() -> (Simulation, Display),
) {
    let ((simulation, display), bytes) = allocated_by(build);
    let lattice = simulation.body(0).lattice();
    let reported = simulation.plan().bodies[0].bytes() + display.bytes();
    let [bytes, reported] = [bytes, reported].map(|bytes| bytes as f64 / lattice.len() as f64);
    bench.row(case, (bytes, "bytes/vertex"), target, format!("plan and display report {reported:.0}"));
}

/// Builds a simulation with volume preservation, makes one step, and evaluates the body once for display.
fn stepped_and_evaluated(lattice: &Lattice) -> (Simulation, Display) {
    let body = Body::from_lattice(lattice.clone())
        .material(Material::fast_lsm())
        .build()
        .expect("the body options are valid");
    let simulation = Simulation::builder().sleep(false).body(body).build();
    let mut simulation = simulation.expect("the simulation parameters are valid");
    simulation.step();
    let mut display = Display::new();
    drop(display.evaluate(simulation.body(0)).positions());
    (simulation, display)
}

/// Measures a block of 97,336 lattice vertices, which fits the caches, on one and two threads.
fn middle(bench: &mut Bench) {
    bench.section("solid block, 97,336 lattice vertices, full step");
    let lattice = block(MIDDLE);
    for (half_width, targets) in [(1, [22.0, 12.0]), (3, [30.0, 17.0])] {
        let simulations = || [1, 2].map(|threads| in_motion(&lattice, half_width, threads));
        let name = format!("w={half_width}");
        let samples = bench.measure(["step 100,000", &name], Sampling::Many, simulations, step_alternately);
        let Some(samples) = samples else { continue };
        let times = [0, 1].map(|k| samples.seconds(k) * 1e9 / lattice.len() as f64);
        for (threads, label) in [(1, "one thread"), (2, "two threads")] {
            let comparison = format!("other thread count: {:.1} ns", times[2 - threads]);
            let target = Some(AtMost(targets[threads - 1]));
            let case = format!("w = {half_width}, {label}");
            bench.row(&case, (times[threads - 1], "ns/vertex"), target, comparison);
        }
    }
}

/// Measures two blocks and the bust with approximately 1,000 lattice vertices each, on one thread.
fn small(bench: &mut Bench) {
    bench.section("about 1,000 lattice vertices, w = 2, one thread, full step");
    for (name, lattice) in
        [("16x8x8", block([16, 8, 8])), ("10x10x10", block(SMALL)), ("bust", bust_lattice(1000))]
    {
        let simulation = || in_motion(&lattice, 2, 1);
        let work = |simulation: &mut Simulation, n| [steps(simulation, n)];
        if let Some(samples) = bench.measure(["step 1,000", name], Sampling::Many, simulation, work) {
            let case = format!("{name}: {} vertices", lattice.len());
            let comparison = format!("{:.1} ns/vertex", samples.seconds(0) * 1e9 / lattice.len() as f64);
            bench.row(&case, (samples.seconds(0) * 1e6, "us"), Some(AtMost(40.0)), comparison);
        }
    }
}

/// Measures a simulation of 100 bodies, which are distributed over the threads.
fn many(bench: &mut Bench) {
    const BODIES: usize = 100;
    bench.section("100 bodies of 1,000 lattice vertices, w = 2, full step");
    let lattice = block(SMALL);
    let bodies = |threads| {
        let body = |number: usize| {
            let body = Body::from_lattice(lattice.clone()).material(Material::fast_lsm()).half_width(2);
            // The bodies are apart from each other.
            body.translate([30.0 * number as f64, 0.0, 0.0])
        };
        bodies::simulation((0..BODIES).map(body), threads)
    };
    let simulations = || [bodies(2), bodies(1)];
    let samples = bench.measure(["step 100 x 1,000", "w=2"], Sampling::Many, simulations, step_alternately);
    if let Some(samples) = samples {
        let [two_threads, one_thread] =
            [0, 1].map(|k| samples.seconds(k) * 1e9 / (BODIES * lattice.len()) as f64);
        let comparison = format!("two threads: {two_threads:.1} ns");
        bench.row("one thread", (one_thread, "ns/vertex"), Some(AtMost(18.0)), comparison);
        let comparison = format!("{one_thread:.1} ns, {two_threads:.1} ns");
        bench.row("two threads against one", (samples.ratio(1, 0), "times"), Some(AtLeast(1.8)), comparison);
    }
}

/// Makes `count` steps of the first simulation, then `count` steps of the second, and returns both times.
/// Each sample calls this function once, so the simulations alternate from sample to sample.
pub(crate) fn step_alternately(simulations: &mut [Simulation; 2], count: u64) -> [Duration; 2] {
    simulations.each_mut().map(|simulation| steps(simulation, count))
}
