//! Cases with bars that are held at one end and bend under their weight.
//!
//! The regions stiffen bending by (1 + 2/N²) (1 + 0.6 R²/t²), with their radius R and N cells across. Several held
//! layers stiffen the bar beside them: as if it were shorter by about R/6 (measured). Regions of one cell, with R =
//! 0.87 cells, have the factor 1 + 2/N² alone.

use nalgebra::Matrix3;
use supple::{Accuracy, Body, Pin, Preservation, Selection, Simulation, TimeWindow};

use crate::material::bodies::{FPS, automatic, bar, bar_vertices, block, region_radius, stepped};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};
use crate::material::theory::Bar;

/// Length of the bar, of which one unit is held.
const LENGTH: i32 = 5;

/// Young's modulus.
const MODULUS: f64 = 1e5;

/// Gravity across the bar, for a deflection of about 1 % of the length.
const GRAVITY: f64 = 0.01;

/// Decay rate, 1/s: about that of critical damping, 3.516 √(E/(12 ρ)) t/l² = 0.63/s.
const RATE: f64 = 0.6;

/// Time in seconds in which it comes to rest, up to exp(-0.6 x 20) (1 + 0.6 x 20) of the deflection.
const SECONDS: f64 = 20.0;

/// Lets a bar bend under its weight, and measures the deflection of its end.
fn bent(cells: i32, step_rate: f64, accuracy: Accuracy) -> Outcome {
    let selection = Selection::Plane { point: [0.0, 0.0, 1.0 + 1e-6], normal: [0.0, 0.0, -1.0] };
    let body = bar(cells, LENGTH)?.youngs_modulus(MODULUS).damping_rate(RATE).accuracy(accuracy);
    let body = body.pin(Pin { goal: None, selection, window: TimeWindow::default() }).build()?;
    let bar = Bar {
        thickness: 1.0,
        length: f64::from(LENGTH - 1),
        modulus: MODULUS,
        poisson_ratio: 0.0,
        density: body.material().density,
    };
    let rest = body.positions();
    let mut simulation = stepped(body, [-GRAVITY, 0.0, 0.0], 1.0 / step_rate).build()?;
    simulation.steps((SECONDS * step_rate) as u64);
    let body = &simulation.bodies()[0];
    let moved = rest.iter().zip(body.positions()).zip(body.lattice().indices());
    let end: Vec<f64> = moved
        .filter(|(_, index)| index[2] == LENGTH * cells)
        .map(|((before, now), _)| before.x - now.x)
        .collect();
    let deflection = end.iter().sum::<f64>() / end.len() as f64;
    Ok(vec![Measured::by_law(deflection, bar.deflection(GRAVITY))])
}

/// Lets a mesh bar of 1 x 1 x 4 bend with the automatic choice of regions and steps, held at the vertices below 0.4, and
/// measures the deflection of its end.
fn bent_mesh(vertices: usize, poisson_ratio: f64) -> Outcome {
    const HELD: f64 = 0.4;
    let body = Body::builder(block([1.0, 1.0, 4.0], &Matrix3::identity())?).lattice_vertices(vertices);
    let body = body.youngs_modulus(MODULUS).poisson_ratio(poisson_ratio).damping_rate(RATE);
    let mut body = body.volume(Preservation::Off).build()?;
    let held = (0_u32..).zip(body.positions()).filter(|(_, point)| point.z < HELD);
    let (held, heights): (Vec<_>, Vec<_>) = held.map(|(vertex, point)| (vertex, point.z)).unzip();
    body.pin(&Pin { goal: None, selection: Selection::Vertices(held), window: TimeWindow::default() })?;
    let bar = Bar {
        thickness: 1.0,
        length: 4.0 - heights.into_iter().fold(0.0, f64::max),
        modulus: MODULUS,
        poisson_ratio,
        density: body.material().density,
    };
    let end = |simulation: &Simulation| -> f64 {
        let surface = simulation.body(0).surface().positions;
        surface.iter().filter(|point| point.z > 3.9).map(|point| point.x).sum::<f64>() / 4.0
    };
    let mut simulation = automatic(body, [-GRAVITY, 0.0, 0.0]).sleep(false).build()?;
    let before = end(&simulation);
    simulation.advance((SECONDS * FPS) as u64);
    Ok(vec![Measured::by_law(before - end(&simulation), bar.deflection(GRAVITY))])
}

/// Returns the cases of the mesh bar.
fn mesh_cases() -> impl Iterator<Item = Case> {
    [1_000, 2_000, 4_000].into_iter().flat_map(|vertices| {
        [0.0, 0.45].map(|poisson_ratio| {
            let mut quantity = Quantity::new("deflection, m", Target::within(0.9, 1.1));
            if vertices == 1_000 {
                quantity = quantity.misses(
                    "5.25 of 6 cells across: those at its sides have a third of their material outside",
                );
            }
            let name = format!("mesh bar 1 x 1 x 4, {vertices} vertices, Poisson's ratio {poisson_ratio}");
            Case::new(name, [quantity], move || bent_mesh(vertices, poisson_ratio))
        })
    })
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let case = |(cells, step_rate, accuracy)| {
        let (width, length) = (f64::from(cells), f64::from(LENGTH - 1));
        let lattice = 1.0 + 2.0 / (width * width);
        let (radius, expected) = match accuracy {
            Accuracy::Exact => (0.75_f64.sqrt() / width, 1.0 / lattice),
            _ => {
                let radius = region_radius(cells, MODULUS, 1.0 / step_rate);
                let hold = (1.0 - radius / 6.0 / length).powi(4);
                (radius, hold / lattice / (1.0 + 0.6 * radius * radius))
            }
        };
        let mut quantity = Quantity::new("deflection, m", Target::within(0.95, 1.05));
        if expected < 0.95 {
            let reason = match accuracy {
                Accuracy::Exact => format!("the lattice gives {expected:.2}"),
                _ => format!("regions stiffen bending, and holds: they give about {expected:.2}"),
            };
            quantity = quantity.misses(reason);
        }
        let name = format!("{} vertices, R = {radius:.2} t", bar_vertices(cells, LENGTH));
        Case::new(name, [quantity], move || bent(cells, step_rate, accuracy))
    };
    let wide = [(5, 240.0), (8, 240.0), (16, 240.0), (20, 480.0)];
    let wide = wide.map(|(cells, rate)| (cells, rate, Accuracy::Fast));
    let cells = [(5, 240.0), (8, 240.0), (16, 480.0)].map(|(cells, rate)| (cells, rate, Accuracy::Exact));
    wide.into_iter().chain(cells).map(case).chain(mesh_cases()).collect()
}
