//! Cases with free bars that oscillate in their lowest modes, along the cells and turned across them.

use nalgebra::{Matrix3, Point3, Vector3};
use supple::{Body, Simulation, euler_degrees};

use crate::material::bodies::{bar, bar_vertices, region_radius, stepped, turned_bar};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};
use crate::material::theory::{Bar, Mode};
use crate::material::trace::angular_frequency;

/// Length of the bar.
const LENGTH: i32 = 5;

/// Young's modulus for which the regions have the radius R = 0.29 t in the longest step, 1/60 s.
const MODULUS: f64 = 1e5;

/// Amplitude of the modes, in thicknesses.
const AMPLITUDE: f64 = 0.005;

/// Number of periods that are recorded.
const PERIODS: f64 = 3.0;

/// A bar in a lowest mode.
pub(super) struct Oscillation {
    pub(super) simulation: Simulation,
    /// Rest positions.
    rest: Vec<Point3<f64>>,
    /// Shape of the mode times mass, with the square sum 1 over mass.
    weighted: Vec<Vector3<f64>>,
}

impl Oscillation {
    /// Displaces a body by a mode with the amplitude `amplitude`. `turn` is the rotation of the bar, whose lower end is
    /// at z = `lower`, and `length` the length that moves.
    pub(super) fn new(
        body: Body,
        dt: f64,
        mode: Mode,
        turn: &Matrix3<f64>,
        [lower, length]: [f64; 2],
        amplitude: f64,
    ) -> Result<Self, supple::Error> {
        let rest = body.positions();
        let masses = body.masses();
        let displacement = |p: &Point3<f64>| {
            let along = turn.transpose() * p.coords;
            let z = (along.z - lower) / length;
            // The held part of a cantilever does not move.
            let z = if mode == Mode::Cantilever { z.max(0.0) } else { z };
            turn * Vector3::from(mode.displacement(along.x - 0.5, along.y - 0.5, z, length))
        };
        let shape: Vec<_> = rest.iter().map(displacement).collect();
        let squares: f64 = shape.iter().zip(&masses).map(|(u, m)| m * u.norm_squared()).sum();
        let weighted = shape.iter().zip(&masses).map(|(u, m)| u * (m / squares)).collect();
        let start: Vec<_> = rest.iter().zip(&shape).map(|(p, u)| p + u * amplitude).collect();
        let mut simulation = stepped(body, [0.0; 3], dt).build()?;
        simulation.body_mut(0).set_positions(&start)?;
        Ok(Self { simulation, rest, weighted })
    }

    /// Makes steps for `seconds`, and returns the amplitude after each step.
    pub(super) fn record(&mut self, seconds: f64) -> Vec<f64> {
        let steps = (seconds / self.simulation.dt()).round() as u64;
        let sample = |_| {
            self.simulation.step();
            let positions = self.simulation.bodies()[0].positions();
            let displaced = positions.iter().zip(&self.rest).map(|(p, r)| p - r);
            displaced.zip(&self.weighted).map(|(u, weight)| u.dot(weight)).sum()
        };
        (0..steps).map(sample).collect()
    }
}

/// Measures the frequencies of the three lowest modes of a bar.
fn oscillated(cells: i32, step_rate: f64, turn: Option<Matrix3<f64>>) -> Outcome {
    let dt = 1.0 / step_rate;
    let length = f64::from(LENGTH);
    let frequency = |mode: Mode| -> Result<Measured, supple::Error> {
        let body = match &turn {
            None => bar(cells, LENGTH)?,
            Some(turn) => turned_bar(cells, LENGTH, turn)?,
        };
        let body = body.youngs_modulus(MODULUS).damping_ratio(0.0).build()?;
        let bar = Bar {
            thickness: 1.0,
            length,
            modulus: MODULUS,
            poisson_ratio: 0.0,
            density: body.material().density,
        };
        let law = match mode {
            Mode::Stretch => bar.stretch(),
            Mode::Bend | Mode::Cantilever => bar.bending(),
            Mode::Twist => bar.twist(),
        };
        let turn = turn.unwrap_or_else(Matrix3::identity);
        let mut oscillation = Oscillation::new(body, dt, mode, &turn, [0.0, length], AMPLITUDE)?;
        let samples = oscillation.record(PERIODS / law);
        Ok(Measured::by_law(angular_frequency(&samples, dt) / std::f64::consts::TAU, law))
    };
    let measured = [Mode::Stretch, Mode::Bend, Mode::Twist].into_iter().map(frequency);
    Ok(measured.collect::<Result<_, _>>()?)
}

/// Returns the quantities of a bar, with the reasons of known misses.
fn quantities(cells: i32, step_rate: f64, is_turned: bool) -> [Quantity; 3] {
    let within = |name, error| Quantity::new(name, Target::within(1.0 - error, 1.0 + error));
    let [stretch, mut bend, mut twist] =
        [within("stretch, Hz", 0.05), within("bend, Hz", 0.1), within("twist, Hz", 0.15)];
    // Regions stiffen twist by 1 + 4 R²/t².
    let radius = region_radius(cells, MODULUS, 1.0 / step_rate);
    let factor = (1.0 + 4.0 * radius * radius).sqrt();
    if factor > 1.15 && !is_turned {
        twist = twist.misses(format!("regions of R = {radius:.2} t give about {factor:.2}"));
    }
    if cells == 4 && is_turned {
        bend = bend.misses("4 cells across, of which the outer ones are partly filled");
    }
    [stretch, bend, twist]
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for cells in [4, 8, 17] {
        // With 4 cells across, the half-width is 1 in all steps.
        let rates: &[f64] = if cells == 4 { &[60.0, 480.0] } else { &[60.0, 120.0, 240.0, 480.0] };
        for (name, degrees) in [("along the cells", [0.0; 3]), ("turned", [30.0, 30.0, 0.0])] {
            let turn = (degrees != [0.0; 3]).then(|| euler_degrees(degrees));
            for &step_rate in rates {
                let vertices = bar_vertices(cells, LENGTH);
                let name = format!("{vertices} vertices, {name}, {step_rate} steps/s");
                let quantities = quantities(cells, step_rate, turn.is_some());
                cases.push(Case::new(name, quantities, move || oscillated(cells, step_rate, turn)));
            }
        }
    }
    cases
}
