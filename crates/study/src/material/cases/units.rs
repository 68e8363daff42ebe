//! Cases with a bust of the default material whose base is held: 34 units high under the gravity 981, and 0.34 units
//! high under 9.81.

use supple::{Body, Pin, Preservation, Selection, TimeWindow};

use crate::material::bodies::{automatic, bust};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};

/// Time in seconds in which the bust comes to rest: about 80 periods of its lowest mode.
const SECONDS: f64 = 4.0;

/// Returns by how much the crown sags, over the height of the bust.
fn sag(vertices: usize, height: f64, gravity: f64) -> Result<f64, Box<dyn std::error::Error>> {
    let mesh = bust()?;
    let (low, high) = mesh.bounds();
    let scale = height / (high.y - low.y);
    let base = low.y * scale + 0.05 * height;
    let selection = Selection::Plane { point: [0.0, base, 0.0], normal: [0.0, -1.0, 0.0] };
    let body = Body::builder(mesh).lattice_vertices(vertices).scale(scale).volume(Preservation::Off);
    let body = body.pin(Pin { goal: None, selection, window: TimeWindow::default() }).build()?;
    let mut simulation = automatic(body, [0.0, -gravity, 0.0]).build()?;
    let crown = |surface: supple::DisplayedSurface| {
        surface.positions.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max)
    };
    let before = crown(simulation.body(0).surface());
    while simulation.time() < SECONDS && !simulation.bodies()[0].is_asleep() {
        simulation.advance(1);
    }
    Ok((before - crown(simulation.body(0).surface())) / height)
}

/// Measures the sag in both units, and compares them.
fn in_both_units(vertices: usize) -> Outcome {
    let (small, large) = (sag(vertices, 0.34, 9.81)?, sag(vertices, 34.0, 981.0)?);
    Ok(vec![large.into(), Measured::by_law(large, small)])
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let quantities = || {
        [
            Quantity::new("sag/height", Target::at_most(0.02)),
            Quantity::new("sag/height, law: 0.34 units high", Target::within(0.99, 1.01)),
        ]
    };
    let case = |vertices: usize| {
        let name = format!("bust, 34 units high, {vertices} vertices");
        Case::new(name, quantities(), move || in_both_units(vertices))
    };
    [1_000, 20_000].map(case).into()
}
