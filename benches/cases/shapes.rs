//! Times a step of the bust and of thin, branching shapes. The time per lattice vertex is divided by that of
//! a solid block.

use supple_benches::Target::AtMost;
use supple_benches::bodies::{Figure, block, bust_lattice, in_motion};

use crate::measure::{Bench, Sampling};
use crate::step::{MIDDLE, step_alternately};

/// Approximate number of lattice vertices of each shape.
const VERTICES: usize = 100_000;

pub(crate) fn bench(bench: &mut Bench) {
    bench.section("other shapes, about 100,000 lattice vertices, step time per vertex relative to the block");
    let shapes: [(&str, f64, &dyn Fn() -> supple::Lattice); 4] = [
        ("bust", 1.35, &|| bust_lattice(VERTICES)),
        ("body with limbs", 1.35, &|| Figure::Limbs.lattice(VERTICES)),
        ("spiky star", 1.8, &|| Figure::Star.lattice(VERTICES)),
        ("octopus", 1.8, &|| Figure::Octopus.lattice(VERTICES)),
    ];
    for (name, limit, shape) in shapes {
        let lattices = [shape(), block(MIDDLE)];
        for half_width in [1, 3] {
            for threads in [1, 2] {
                let simulations =
                    || lattices.each_ref().map(|lattice| in_motion(lattice, half_width, threads));
                let case = format!("{name}, w = {half_width}, threads: {threads}");
                let samples = bench.measure(["shapes", &case], Sampling::Many, simulations, step_alternately);
                let Some(samples) = samples else { continue };
                let counts = lattices.each_ref().map(|lattice| lattice.len() as f64);
                let [shape, block] = [0, 1].map(|k| samples.seconds(k) * 1e9 / counts[k]);
                let ratio = samples.ratio(0, 1) * counts[1] / counts[0];
                let comparison = format!("{shape:.1} ns, block: {block:.1} ns");
                bench.row(&case, (ratio, "times"), Some(AtMost(limit)), comparison);
            }
        }
    }
}
