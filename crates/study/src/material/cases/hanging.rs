//! Cases with bars that hang from their upper end.
//!
//! The law is the elongation ρ g l²/(2 E) of the length l between the lowest held vertices and the lower end. The
//! masses of the lattice give it exactly: the cell j above the end carries j + 1/2 layers.

use supple::{Pin, Selection, TimeWindow};

use crate::material::bodies::{GRAVITY, bar, bar_vertices, stepped};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};
use crate::material::theory::Bar;

/// Length of the bar.
const LENGTH: i32 = 3;

/// Young's modulus.
const MODULUS: f64 = 1e5;

/// Decay rate, 1/s: about that of critical damping, π/2 √(E/ρ)/l.
const RATE: f64 = 5.0;

/// Time in seconds in which it comes to rest, up to exp(-5 x 4) (1 + 5 x 4) of the elongation.
const SECONDS: f64 = 4.0;

/// Lets a bar hang from the vertices above `held` below the upper end, and measures the elongation and the force of the
/// hold.
fn hung(cells: i32, held: f64, step_rate: f64) -> Outcome {
    let h = 1.0 / f64::from(cells);
    let upper = f64::from(LENGTH);
    let selection = Selection::Plane { point: [0.0, 0.0, upper - held], normal: [0.0, 0.0, 1.0] };
    let body = bar(cells, LENGTH)?.youngs_modulus(MODULUS).damping_rate(RATE);
    let body = body.pin(Pin { goal: None, selection, window: TimeWindow::default() }).build()?;
    let density = body.material().density;
    let mut simulation = stepped(body, [0.0, 0.0, -GRAVITY], 1.0 / step_rate).build()?;
    let end: Vec<usize> = {
        let indices = simulation.bodies()[0].lattice().indices().iter().enumerate();
        indices.filter(|(_, index)| index[2] == 0).map(|(vertex, _)| vertex).collect()
    };
    simulation.steps((SECONDS * step_rate) as u64);
    let positions = simulation.bodies()[0].positions();
    let elongation = -end.iter().map(|&vertex| positions[vertex].z).sum::<f64>() / end.len() as f64;
    // The lowest held layer is the first one above the plane.
    let length = h * ((upper - held) / h - 1e-9).ceil();
    let law =
        Bar { thickness: 1.0, length, modulus: MODULUS, poisson_ratio: 0.0, density }.elongation(GRAVITY);
    let hold = simulation.body(0).hold_force(0)?.unwrap_or_default();
    let weight = simulation.body(0).mass() * GRAVITY;
    Ok(vec![Measured::by_law(elongation, law), Measured::by_law(hold.force.z, weight)])
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (cells, step_rate) in [(4, 120.0), (8, 120.0), (16, 120.0), (16, 480.0), (30, 120.0), (30, 480.0)] {
        for (name, held) in [("held 0.3 deep", 0.3), ("held by one layer", 0.5 / f64::from(cells))] {
            let elongation = Quantity::new("elongation, m", Target::within(0.95, 1.1));
            let force = Quantity::new("force of the hold, law: weight", Target::within(0.99, 1.01));
            let vertices = bar_vertices(cells, LENGTH);
            let name = format!("{vertices} vertices, {name}, {step_rate} steps/s");
            let case = Case::new(name, [elongation, force], move || hung(cells, held, step_rate));
            cases.push(case.of_vertices(vertices));
        }
    }
    cases
}
