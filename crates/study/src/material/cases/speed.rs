//! Cases that measure run times: of bodies at rest, and of elastic damping. Two threads.

use std::time::Instant;

use nalgebra::Point3;
use supple::{Body, Material, Preservation, Simulation, Substeps};

use crate::material::bodies::{FPS, bar, bar_vertices, ground};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};
use crate::timing::Spread;

/// Number of resting bodies.
const BODIES: usize = 100;

/// Frames after which they sleep at the latest.
const SETTLING: u64 = 600;

/// Pairs of samples of the damped and the undamped step.
const SAMPLES: usize = 31;

/// Returns the time of a step in ms, as the mean of `count` steps.
fn time(simulation: &mut Simulation, count: u32) -> f64 {
    let start = Instant::now();
    simulation.steps(u64::from(count));
    start.elapsed().as_secs_f64() * 1e3 / f64::from(count)
}

/// Measures a step of bodies of 500 vertices that sleep on the ground.
fn at_rest() -> Outcome {
    let block: Vec<_> =
        (0..9).flat_map(|z| (0..4).flat_map(move |y| (0..9).map(move |x| [x, y, z]))).collect();
    let lattice = supple::Lattice::from_cells(&block, 0.1, Point3::origin(), false)?;
    let mut simulation =
        Simulation::builder().collider(ground()).fps(FPS).substeps(Substeps::Auto).threads(2);
    for index in 0..BODIES {
        let [column, row] = [index % 10, index / 10].map(|i| 2.0 * i as f64);
        let body = Body::from_lattice(lattice.clone()).volume(Preservation::Off);
        simulation = simulation.body(body.translate([column, 0.0, row]).build()?);
    }
    let mut simulation = simulation.build()?;
    simulation.advance(SETTLING);
    let awake = simulation.bodies().iter().filter(|body| !body.is_asleep()).count();
    let times = (0..SAMPLES).map(|_| time(&mut simulation, 100));
    Ok(vec![Spread::of(times).median.into(), (awake as f64).into()])
}

/// Measures the step of a damped and of an undamped cube that keep moving, alternately, in samples of a million steps
/// of a vertex.
fn damped(cells: i32) -> Outcome {
    let steps = (1_000_000 / bar_vertices(cells, 1)) as u32;
    let simulation = |rate: f64| -> Result<Simulation, supple::Error> {
        let body = bar(cells, 1)?.material(Material::fast_lsm()).half_width(2);
        let mut body = body.damping_rate(rate).build()?;
        let stretched: Vec<_> = body
            .positions()
            .iter()
            .map(|p| Point3::new(p.x + 0.2 * p.y, 1.1 * p.y, p.z - 0.1 * p.x))
            .collect();
        body.set_positions(&stretched)?;
        Simulation::builder().body(body).gravity([0.0; 3]).sleep(false).threads(2).build()
    };
    // The rate is so low that both keep moving.
    let mut simulations = [simulation(1e-3)?, simulation(0.0)?];
    simulations.iter_mut().for_each(|simulation| simulation.steps(10));
    let samples: Vec<[f64; 2]> =
        (0..SAMPLES).map(|_| simulations.each_mut().map(|simulation| time(simulation, steps))).collect();
    let median = |k: usize| Spread::of(samples.iter().map(|sample| sample[k])).median;
    let ratio = Spread::of(samples.iter().map(|[damped, undamped]| damped / undamped)).median;
    // The law is the undamped step; the ratio is the median of the ratios.
    Ok(vec![Measured::by_law(median(0), median(0) / ratio)])
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let quantities = [
        Quantity::new("step, ms", Target::at_most(0.1)),
        Quantity::new("bodies awake", Target::at_most(0.0)),
    ];
    let mut cases = vec![Case::new("100 bodies of 500 vertices at rest", quantities, at_rest).timed()];
    for cells in [20, 45] {
        let vertices = bar_vertices(cells, 1);
        let quantity = Quantity::new("step, ms; law: undamped", Target::at_most(1.15));
        let name = format!("damped cube of {vertices} vertices");
        cases.push(Case::new(name, [quantity], move || damped(cells)).of_vertices(vertices).timed());
    }
    cases
}
