//! Compares a full step with the naive goal positions: explicit sums over each region in f64, on one thread.

use nalgebra::Vector3;
use supple::reference::{self, Naive, Regions};
use supple::{Body, Material, Simulation};
use supple_benches::Target::AtLeast;
use supple_benches::bodies::{block, deform, in_motion};

use crate::measure::{Bench, Sampling, steps, timed};

/// Number of timed steps for each evaluation of the naive goal positions.
const STEPS: u32 = 50;

pub(crate) fn bench(bench: &mut Bench) {
    bench.section("against the naive explicit sums, 1,000 lattice vertices, one thread");
    let lattice = block([10, 10, 10]);
    let mut body = Body::from_lattice(lattice.clone())
        .material(Material::fast_lsm())
        .build()
        .expect("the body options are valid");
    deform(&mut body);
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
    for (half_width, target) in [(1, None), (3, Some(AtLeast(100.0)))] {
        let state = || {
            (
                in_motion(&lattice, half_width, 1),
                Naive::new(&lattice, half_width, Regions::Staircase).listed(),
            )
        };
        let name = format!("w={half_width}");
        let work = |(simulation, listed): &mut (Simulation, Naive), n: u64| {
            let goals = || reference::goals(&lattice, &positions, half_width, Regions::Staircase);
            let time = |goals: &dyn Fn() -> Vec<Vector3<f64>>| timed(|| (0..n).for_each(|_| drop(goals())));
            let step = steps(simulation, n * u64::from(STEPS)) / STEPS;
            [time(&goals), time(&|| listed.goals(&listed.motions(&positions))), step]
        };
        let Some(samples) = bench.measure(["naive goals", &name], Sampling::Few, state, work) else {
            continue;
        };
        let times: [f64; 3] = std::array::from_fn(|k| samples.seconds(k) * 1e9 / lattice.len() as f64);
        // The target applies to `supple::reference`, which searches the regions each time. Regions that are
        // listed beforehand show how much of its time is the search.
        let cases = [("`supple::reference`", target), ("the same with its regions listed beforehand", None)];
        for (variant, (case, target)) in cases.into_iter().enumerate() {
            let comparison =
                format!("goals alone: {:.0} ns, full step: {:.1} ns per vertex", times[variant], times[2]);
            bench.row(
                &format!("w = {half_width}, {case}"),
                (samples.ratio(variant, 2), "times"),
                target,
                comparison,
            );
        }
    }
}
