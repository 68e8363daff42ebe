//! Measures the cost of fracture: of a step in which a body could break and does not, and of an event.

use std::time::Duration;

use nalgebra::{Point3, Vector3};
use supple::{Body, BreakLimit, Display, FractureOptions, Lattice, Material, Simulation, SimulationState};
use supple_benches::Target::AtMost;
use supple_benches::bodies::{self, block, bust};

use crate::measure::{Bench, Sampling, steps, timed};
use crate::step::{MIDDLE, SMALL, step_alternately};

pub(crate) fn bench(bench: &mut Bench) {
    armed(bench);
    events(bench);
}

/// Measures the step of deformed blocks that break at ten times their length, relative to blocks that cannot break.
fn armed(bench: &mut Bench) {
    for (name, size, threads) in [
        ("97,336 lattice vertices, two threads", MIDDLE, 2),
        ("1,000 lattice vertices, one thread", SMALL, 1),
    ] {
        bench.section(&format!("fracture: solid block, {name}, w = 2, full step"));
        let lattice = block(size);
        let simulations =
            || [true, false].map(|is_armed| bodies::simulation([breakable(&lattice, is_armed)], threads));
        let group = format!("step {}", lattice.len());
        let samples =
            bench.measure([&group, "fracture, whole"], Sampling::Many, simulations, step_alternately);
        let Some(samples) = samples else { continue };
        let [with, without] = [0, 1].map(|k| samples.seconds(k) * 1e9 / lattice.len() as f64);
        let ratio = (samples.ratio(0, 1), "times");
        let comparison = format!("{with:.1} ns, {without:.1} ns");
        bench.row(
            "could break and does not, against a body that cannot",
            ratio,
            Some(AtMost(1.3)),
            comparison,
        );
    }
}

fn breakable(lattice: &Lattice, is_armed: bool) -> supple::BodyBuilder {
    let body = Body::from_lattice(lattice.clone()).material(Material::fast_lsm()).half_width(2);
    if is_armed { body.fracture(FractureOptions::new(BreakLimit::Strain(9.0))) } else { body }
}

/// Measures cuts of the bust. An event of a growing crack does the same: it rebuilds what depends on the topology. The
/// step that follows prepares the contacts between the pieces, and the next frame cuts the mesh.
fn events(bench: &mut Bench) {
    bench.section("fracture: a cut through the bust, one thread");
    for (vertices, target) in [(1_000, 3.0), (10_000, 20.0)] {
        let state = || CutBust::new(vertices);
        let name = format!("bust of {vertices}");
        let samples = bench.measure(["cut", &name], Sampling::Few, state, CutBust::cut_and_show);
        let Some(samples) = samples else { continue };
        let [event, step, ordinary, display] = [0, 1, 2, 3].map(|k| samples.seconds(k) * 1e3);
        let label = |part: &str| format!("{vertices} vertices, {part}");
        bench.row(&label("event"), (event, "ms"), Some(AtMost(target)), "");
        bench.row(
            &label("next step"),
            (step, "ms"),
            None,
            format!("step of the whole body: {ordinary:.2} ms"),
        );
        bench.row(&label("first frame"), (display, "ms"), None, "mesh of the pieces, correction, surface");
    }
}

/// A bust that is cut, displayed and made whole again.
struct CutBust {
    simulation: Simulation,
    whole: SimulationState,
    center: Point3<f64>,
}

impl CutBust {
    fn new(vertices: usize) -> Self {
        let body = Body::builder(bust()).lattice_vertices(vertices).material(Material::fast_lsm());
        let body = body.build().expect("the mesh and the body options are valid");
        let center = body.center_of_mass();
        let simulation = Simulation::builder().sleep(false).gravity([0.0; 3]).threads(1).body(body).build();
        let mut simulation = simulation.expect("the simulation parameters are valid");
        simulation.step();
        let whole = simulation.state();
        Self { simulation, whole, center }
    }

    /// Times a cut, the next step, a step of the whole body, and the display of the pieces.
    fn cut_and_show(&mut self, count: u64) -> [Duration; 4] {
        let mut times = [Duration::ZERO; 4];
        for _ in 0..count {
            self.simulation.restore(&self.whole).expect("the state is that of this simulation");
            // The first step after a state is restored prepares the contacts.
            self.simulation.step();
            times[2] += steps(&mut self.simulation, 1);
            let normal = Vector3::new(0.3, 1.0, 0.2);
            let body = self.simulation.body_mut(0);
            times[0] += timed(|| body.cut(self.center.into(), normal.into()).expect("the plane is valid"));
            times[1] += steps(&mut self.simulation, 1);
            let mut display = Display::new();
            times[3] += timed(|| display.evaluate(self.simulation.body(0)).surface());
        }
        times
    }
}
