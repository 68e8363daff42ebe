//! The step beside the naive method: explicit sums over each region, in f64, on one thread.

use supple::Body;
use supple::reference::{self, Regions};
use supple_benches::Target::AtLeast;
use supple_benches::bodies::{block, deform, in_motion};

use crate::measure::{Bench, Effort, steps, timed};

/// Steps beside one evaluation of the naive sums.
const STEPS: u32 = 50;

pub(crate) fn bench(bench: &mut Bench) {
    bench.part("against the naive explicit sums, 1,000 lattice vertices, one thread");
    let lattice = block([10, 10, 10]);
    let mut body = Body::from_lattice(lattice.clone()).build().expect("a block is a body");
    deform(&mut body);
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
    for (half_width, target) in [(1, None), (3, Some(AtLeast(100.0)))] {
        let simulation = || in_motion(&lattice, half_width, 1);
        let name = format!("w={half_width}");
        let samples = bench.measure(["naive goals", &name], Effort::Few, simulation, |simulation, n| {
            let goals = || reference::goals(&lattice, &positions, half_width, Regions::Staircase);
            let naive = timed(|| (0..n).for_each(|_| drop(goals())));
            [naive, steps(simulation, n * u64::from(STEPS)) / STEPS]
        });
        if let Some(samples) = samples {
            let [naive, step] = [0, 1].map(|rival| samples.seconds(rival) * 1e9 / lattice.len() as f64);
            let beside = format!("goals alone: {naive:.0} ns, full step: {step:.1} ns a vertex");
            bench.row(&format!("w = {half_width}"), (samples.ratio(0, 1), "times"), target, beside);
        }
    }
}
