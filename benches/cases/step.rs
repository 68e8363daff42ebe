//! The full step of solid blocks: matching, links, momentum tracker, integration; without evaluation.

use std::time::Duration;

use supple::{Body, Display, Lattice, Simulation, When};
use supple_benches::Target::{self, AtLeast, AtMost};
use supple_benches::bodies::{self, block, bust_lattice, in_motion};

use crate::bandwidth::Bandwidth;
use crate::measure::{Bench, Sampling, steps};
use crate::memory::allocated_by;

const LARGE: [i32; 3] = [100, 100, 100];
/// 97,336 lattice vertices.
pub(crate) const MIDDLE: [i32; 3] = [46, 46, 46];
const SMALL: [i32; 3] = [10, 10, 10];

pub(crate) fn bench(bench: &mut Bench, bandwidth: Option<&Bandwidth>) {
    large(bench, bandwidth);
    middle(bench);
    small(bench);
    many(bench);
}

/// Measures a million lattice vertices: time, memory, and the bandwidth limit.
fn large(bench: &mut Bench, bandwidth: Option<&Bandwidth>) {
    bench.part("solid block, 1,000,000 lattice vertices, full step");
    let lattice = block(LARGE);
    let two = |half_width| in_motion(&lattice, half_width, 2);
    let per_vertex = 1e9 / lattice.len() as f64;

    let pair = || [two(2), in_motion(&lattice, 2, 1)];
    if let Some(samples) = bench.measure(["step 1,000,000", "w=2"], Sampling::Few, pair, interleaved) {
        let [both, one] = [0, 1].map(|k| samples.seconds(k) * per_vertex);
        let comparison = format!("one thread: {one:.1} ns");
        bench.row("w = 2, two threads", (both, "ns/vertex"), Some(AtMost(22.0)), comparison);
        let comparison = format!("{one:.1} ns, {both:.1} ns");
        bench.row(
            "w = 2, two threads against one",
            (samples.ratio(1, 0), "times"),
            Some(AtLeast(1.7)),
            comparison,
        );
        let simulation = two(2);
        roofline(bench, &simulation, bandwidth, [(1, one), (2, both)]);
        drop(simulation);
        memory(bench, "total memory", Some(AtMost(200.0)), || {
            let mut simulation = two(2);
            simulation.step();
            (simulation, Display::new())
        });
        memory(bench, "total memory with volume preservation and display", None, || displayed(&lattice));
    }
    for (half_width, limit) in [(8, 1.5), (16, 2.0)] {
        let pair = || [two(half_width), two(2)];
        let name = format!("w={half_width}");
        if let Some(samples) = bench.measure(["step 1,000,000", &name], Sampling::Few, pair, interleaved) {
            let [wide, narrow] = [0, 1].map(|k| samples.seconds(k) * per_vertex);
            let case = format!("w = {half_width} against w = 2, two threads");
            let comparison = format!("{wide:.1} ns, {narrow:.1} ns");
            bench.row(&case, (samples.ratio(0, 1), "times"), Some(AtMost(limit)), comparison);
        }
    }
}

/// Adds the memory traffic limit: a step must at minimum read all its buffers once and write its state once.
fn roofline(
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
        let minimum = bytes / bandwidth.of(threads) * 1e9;
        let case = format!("share of the memory bandwidth, threads: {threads}");
        bench.row(&case, (100.0 * minimum / nanoseconds, "%"), None, format!("minimum: {minimum:.1} ns"));
    }
}

/// Adds the allocated bytes of a body and its display, compared with the bytes that they report.
fn memory(
    bench: &mut Bench,
    case: &str,
    target: Option<Target>,
    simulation: impl FnOnce() -> (Simulation, Display),
) {
    let ((simulation, display), bytes) = allocated_by(simulation);
    let lattice = simulation.body(0).lattice();
    let reported = simulation.plan().bodies[0].bytes() + display.bytes();
    let [bytes, reported] = [bytes, reported].map(|bytes| bytes as f64 / lattice.len() as f64);
    bench.row(case, (bytes, "bytes/vertex"), target, format!("plan and display report {reported:.0}"));
}

/// Builds a simulation with volume preservation, and runs one step and one evaluation.
fn displayed(lattice: &Lattice) -> (Simulation, Display) {
    let body = Body::from_lattice(lattice.clone()).build().expect("a block is a body");
    let mut simulation = Simulation::builder().body(body).build().expect("numbers in range");
    simulation.step();
    let mut display = Display::new();
    drop(display.evaluate(simulation.body(0)).positions());
    (simulation, display)
}

fn middle(bench: &mut Bench) {
    bench.part("solid block, 97,336 lattice vertices, full step");
    let lattice = block(MIDDLE);
    for (half_width, targets) in [(1, [22.0, 12.0]), (3, [30.0, 17.0])] {
        let pair = || [in_motion(&lattice, half_width, 1), in_motion(&lattice, half_width, 2)];
        let name = format!("w={half_width}");
        let Some(samples) = bench.measure(["step 100,000", &name], Sampling::Many, pair, interleaved) else {
            continue;
        };
        let times = [0, 1].map(|k| samples.seconds(k) * 1e9 / lattice.len() as f64);
        for (threads, word) in [(1, "one thread"), (2, "two threads")] {
            let other = format!("other thread count: {:.1} ns", times[2 - threads]);
            let target = Some(AtMost(targets[threads - 1]));
            bench.row(&format!("w = {half_width}, {word}"), (times[threads - 1], "ns/vertex"), target, other);
        }
    }
}

fn small(bench: &mut Bench) {
    bench.part("about 1,000 lattice vertices, w = 2, one thread, full step");
    for (name, lattice) in
        [("16x8x8", block([16, 8, 8])), ("10x10x10", block(SMALL)), ("bust", bust_lattice(1000))]
    {
        let simulation = || in_motion(&lattice, 2, 1);
        let once = |simulation: &mut Simulation, n| [steps(simulation, n)];
        if let Some(samples) = bench.measure(["step 1,000", name], Sampling::Many, simulation, once) {
            let case = format!("{name}: {} vertices", lattice.len());
            let comparison = format!("{:.1} ns/vertex", samples.seconds(0) * 1e9 / lattice.len() as f64);
            bench.row(&case, (samples.seconds(0) * 1e6, "us"), Some(AtMost(40.0)), comparison);
        }
    }
}

fn many(bench: &mut Bench) {
    const BODIES: usize = 100;
    bench.part("100 bodies of 1,000 lattice vertices, w = 2, full step");
    let lattice = block(SMALL);
    let bodies = |threads| {
        bodies::simulation((0..BODIES).map(|_| Body::from_lattice(lattice.clone()).half_width(2)), threads)
    };
    let pair = || [bodies(2), bodies(1)];
    if let Some(samples) = bench.measure(["step 100 x 1,000", "w=2"], Sampling::Many, pair, interleaved) {
        let [both, one] = [0, 1].map(|k| samples.seconds(k) * 1e9 / (BODIES * lattice.len()) as f64);
        let comparison = format!("one thread: {one:.1} ns");
        bench.row("two threads", (both, "ns/vertex"), Some(AtMost(25.0)), comparison);
    }
}

/// Times `count` steps of each of two simulations, one after the other.
pub(crate) fn interleaved(pair: &mut [Simulation; 2], count: u64) -> [Duration; 2] {
    pair.each_mut().map(|simulation| steps(simulation, count))
}
