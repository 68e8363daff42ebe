//! Measures the cost of plasticity in a step.

use supple::{Body, Lattice, Material, Plasticity, Simulation};
use supple_benches::Target::AtMost;
use supple_benches::bodies::{self, block};

use crate::measure::{Bench, Sampling};
use crate::step::{MIDDLE, SMALL, step_alternately};

pub(crate) fn bench(bench: &mut Bench) {
    for (name, size, threads) in [
        ("97,336 lattice vertices, two threads", MIDDLE, 2),
        ("1,000 lattice vertices, one thread", SMALL, 1),
    ] {
        bench.section(&format!("plasticity: solid block, {name}, w = 2, full step"));
        let lattice = block(size);
        for (label, plastic) in
            [("never yielded", never_yielded as fn() -> _), ("dented", dented), ("flowing", flowing)]
        {
            let simulations =
                || [simulation(&lattice, Some(plastic()), threads), simulation(&lattice, None, threads)];
            let group = format!("step {}", lattice.len());
            let name = format!("plastic, {label}");
            let samples = bench.measure([&group, &name], Sampling::Many, simulations, step_alternately);
            let Some(samples) = samples else { continue };
            let [with, without] = [0, 1].map(|k| samples.seconds(k) * 1e9 / lattice.len() as f64);
            let comparison = format!("{with:.1} ns, {without:.1} ns");
            let case = format!("plastic, {label}, against elastic");
            // Bodies flow for moments only.
            let target = (label != "flowing").then_some(AtMost(1.15));
            bench.row(&case, (samples.ratio(0, 1), "times"), target, comparison);
        }
    }
}

/// The plasticity of a body before and after the first steps.
type Change = [Plasticity; 2];

/// A high yield strain, below which nothing flows.
fn never_yielded() -> Change {
    [Plasticity { yield_strain: 1.0, ..Plasticity::default() }; 2]
}

/// Every region gets a plastic shape in the first steps, and does not flow afterwards.
fn dented() -> Change {
    [Plasticity { yield_strain: 1e-3, ..Plasticity::default() }, never_yielded()[1]]
}

/// With a low yield strain and a slow creep, every region flows in every step, and keeps moving.
fn flowing() -> Change {
    [Plasticity { yield_strain: 1e-3, creep: 1e-2, ..Plasticity::default() }; 2]
}

/// Builds a simulation of a deformed block that keeps moving.
fn simulation(lattice: &Lattice, plastic: Option<Change>, threads: usize) -> Simulation {
    let material = Material { plastic: plastic.map(|[first, _]| first), ..Material::fast_lsm() };
    let body = Body::from_lattice(lattice.clone()).material(material).half_width(2);
    let mut simulation = bodies::simulation([body], threads);
    simulation.steps(5);
    if let Some([_, then]) = plastic {
        simulation.body_mut(0).set_plastic(Some(then)).expect("the parameters are valid");
    }
    simulation
}
