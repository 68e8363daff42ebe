//! Cases with bars that are held at one end and bend under their weight.
//!
//! The regions stiffen bending by (1 + 2/N²) (1 + 0.6 R²/t²), with their radius R and N cells across. Several held
//! layers stiffen the bar beside them: as if it were shorter by about R/6 (measured). Regions of one cell, with R = 0.87 cells,
//! have the factor 1 + 2/N² alone.

use supple::{Accuracy, Pin, Selection, TimeWindow};

use crate::material::bodies::{bar, bar_vertices, region_radius, stepped};
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
    let body = body.pin(Pin { selection, window: TimeWindow::default() }).build()?;
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
    wide.into_iter().chain(cells).map(case).collect()
}
