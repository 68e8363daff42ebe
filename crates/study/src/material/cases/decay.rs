//! Cases with bodies that oscillate, and lose their amplitude at the damping rate that was asked for.

use nalgebra::{Matrix3, Vector3};
use supple::{Body, Pin, Preservation, Selection, TimeWindow};

use super::modes::Oscillation;
use crate::material::bodies::{automatic, bar, bust};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};
use crate::material::theory::Mode;
use crate::material::trace::{decay_of_extrema, decay_of_samples};

/// Young's modulus of the bars.
const MODULUS: f64 = 1e6;

/// Steps per second of the bars.
const STEP_RATE: f64 = 480.0;

/// Cells per unit of length of the bars, which are 1 x 1 x 3.
const CELLS: i32 = 8;

/// Damping rate in 1/s: less than a fifth of the angular frequency of every mode here.
const RATE: f64 = 0.6;

/// Recorded time in seconds: the amplitude falls to a twentieth.
const SECONDS: f64 = 5.0;

/// Lets a bar oscillate in a mode, and measures its decay.
fn of_mode(mode: Mode) -> Outcome {
    let body = bar(CELLS, 3)?.youngs_modulus(MODULUS).damping_rate(RATE);
    let (body, lower) = match mode {
        Mode::Cantilever => {
            let selection = Selection::Plane { point: [0.0, 0.0, 0.25 + 1e-6], normal: [0.0, 0.0, -1.0] };
            (body.pin(Pin { goal: None, selection, window: TimeWindow::default() }), 0.25)
        }
        _ => (body, 0.0),
    };
    let dt = 1.0 / STEP_RATE;
    let ends = [lower, 3.0 - lower];
    let mut oscillation = Oscillation::new(body.build()?, dt, mode, &Matrix3::identity(), ends, 0.005)?;
    Ok(vec![Measured::by_law(decay_of_extrema(&oscillation.record(SECONDS), dt), RATE)])
}

/// Pushes the bust, which is held at its base, to the side, and measures the decay of its energy, which is twice that
/// of the amplitudes of its modes.
fn of_bust() -> Outcome {
    let mesh = bust()?;
    let (low, high) = mesh.bounds();
    let height = high.y - low.y;
    let selection = Selection::Plane { point: [0.0, low.y + 0.05 * height, 0.0], normal: [0.0, -1.0, 0.0] };
    let body = Body::builder(mesh).lattice_vertices(1000).damping_rate(RATE).volume(Preservation::Off);
    let mut body = body.pin(Pin { goal: None, selection, window: TimeWindow::default() }).build()?;
    let push: Vec<_> =
        body.positions().iter().map(|p| Vector3::x() * (0.2 * (p.y - low.y) / height)).collect();
    body.set_velocities(&push)?;
    let mut simulation = automatic(body, [0.0; 3]).sleep(false).build()?;
    let mut energies = Vec::new();
    while simulation.time() < SECONDS {
        simulation.step();
        let elastic = simulation.body(0).elastic_energy().unwrap_or(f64::NAN);
        energies.push(simulation.bodies()[0].kinetic_energy() + elastic);
    }
    Ok(vec![Measured::by_law(0.5 * decay_of_samples(&energies, simulation.dt()), RATE)])
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let quantity = || [Quantity::new("rate, 1/s", Target::within(0.95, 1.1))];
    let modes = [
        ("stretch of a free bar", Mode::Stretch),
        ("bend of a free bar", Mode::Bend),
        ("twist of a free bar", Mode::Twist),
        ("cantilever", Mode::Cantilever),
    ];
    let mut cases: Vec<Case> =
        modes.into_iter().map(|(name, mode)| Case::new(name, quantity(), move || of_mode(mode))).collect();
    cases.push(Case::new("bust held at its base", quantity(), of_bust));
    cases
}
