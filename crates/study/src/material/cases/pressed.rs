//! Cases with a cube as a mesh and the automatic choice of regions and steps: how far it sinks under its weight, and
//! what it resists with between plates. The contacts have no friction, so that the stress in a layer is uniform.

use nalgebra::Matrix3;
use supple::{Body, BodyBuilder, Collider, Key, Preservation, Simulation, Touched};

use crate::material::bodies::{FPS, GRAVITY, automatic, block};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};

/// Young's modulus of the cube in Pa: that of a cube of `flesh`.
const MODULUS: f64 = 80.0 * DENSITY * GRAVITY;

/// Density in kg/m³.
const DENSITY: f64 = 1_000.0;

/// Strain by the plates, and time in seconds in which they reach it.
const STRAIN: f64 = 0.05;
const CLOSING: f64 = 1.0;

/// Time in seconds after which the damped cube is at rest.
const SECONDS: f64 = 5.0;

fn cube(vertices: usize, poisson_ratio: f64) -> Result<BodyBuilder, supple::Error> {
    let body = Body::builder(block([1.0; 3], &Matrix3::identity())?).lattice_vertices(vertices);
    let body = body.density(DENSITY).youngs_modulus(MODULUS).poisson_ratio(poisson_ratio).damping_ratio(1.0);
    Ok(body.volume(Preservation::Off))
}

fn plate(height: f64, up: f64) -> Collider {
    Collider { friction: 0.0, ..Collider::plane([0.0, height, 0.0], [0.0, up, 0.0]) }
}

/// Lets a cube of 1 m stand on the ground, and measures how far its highest layer sinks.
fn sunk(vertices: usize, poisson_ratio: f64) -> Outcome {
    let body = cube(vertices, poisson_ratio)?.build()?;
    let mut simulation =
        automatic(body, [0.0, -GRAVITY, 0.0]).sleep(false).collider(plate(0.0, 1.0)).build()?;
    let heights = |simulation: &Simulation| -> Vec<f64> {
        simulation.bodies()[0].positions().iter().map(|point| point.y).collect()
    };
    let before = heights(&simulation);
    simulation.advance((SECONDS * FPS) as u64);
    let highest = before.iter().copied().fold(0.0, f64::max);
    let after = heights(&simulation);
    let sinks = before.iter().zip(after).filter(|(before, _)| **before > highest - 1e-6).map(|(p, q)| p - q);
    let (count, sum) = sinks.fold((0.0, 0.0), |(count, sum), sink| (count + 1.0, sum + sink));
    let sink = sum / count;
    Ok(vec![Measured::by_law(sink, DENSITY * GRAVITY / (2.0 * MODULUS))])
}

/// Presses a cube of 1 m by 5 % between two plates, and measures the force on the lower one.
fn pressed(vertices: usize, poisson_ratio: f64) -> Outcome {
    let body = cube(vertices, poisson_ratio)?.build()?;
    let key = |time, y| Key { time, translate: [0.0, y, 0.0], ..Key::default() };
    let upper = Collider { keys: vec![key(0.0, 0.0), key(CLOSING, -STRAIN)], ..plate(1.0, -1.0) };
    let simulation = automatic(body, [0.0; 3]).sleep(false).collider(plate(0.0, 1.0)).collider(upper);
    let mut simulation = simulation.build()?;
    simulation.advance(((CLOSING + SECONDS) * FPS) as u64);
    let contacts = simulation.contacts();
    let below = contacts.iter().filter(|contact| contact.other == Touched::Collider(0));
    let force: f64 = below.map(|contact| contact.force.y).sum();
    Ok(vec![Measured::by_law(force, MODULUS * STRAIN)])
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for vertices in [216, 1_000, 4_000, 10_000] {
        for poisson_ratio in [0.0, 0.45] {
            let tolerance = if vertices < 1_000 { 0.2 } else { 0.1 };
            let mut quantities = ["sink under its weight, m", "force at 5 %, N"]
                .map(|name| Quantity::new(name, Target::within(1.0 - tolerance, 1.0 + tolerance)));
            if vertices > 4_000 {
                quantities = quantities.map(|quantity| {
                    quantity.misses("regions of two cells: the layer that touches yields too much")
                });
            }
            let name = format!("mesh cube, {vertices} vertices, Poisson's ratio {poisson_ratio}");
            let run =
                move || Ok([sunk(vertices, poisson_ratio)?, pressed(vertices, poisson_ratio)?].concat());
            cases.push(Case::new(name, quantities, run));
        }
    }
    cases
}
