//! Cases with rods that swing about pinned vertices. Elastic damping must not damp the swing.
//!
//! The rod of Young's modulus E hangs with its weight m g on a few vertices. Its regions have the radius R, so that it
//! yields by at most about u = m g/(E R), the indentation of a block by a punch of the radius R. This changes the
//! distance l of the pin from the center of mass, and so the period by u/(2 l). The direction of u turns with the rod,
//! so elastic damping of the rate c acts on a velocity of the order ω u, where ω is the angular frequency of the swing:
//! a swing loses π (c/ω) (u/l)² of its amplitude, less than u/(3 l) here. Rounding of goal positions by up to ε = 2^-23
//! cells is an acceleration of ε/dt² cells, relative to the gravity g. So the errors of period and amplitude are less
//! than u/l + ε h/(g dt²), which is the bound: about twice the sum of the estimates.

use nalgebra::{Point3, Vector3};
use supple::{Body, Error, Lattice, Pin, Selection, Simulation, TimeWindow};

use crate::stability::bodies::block;
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};

/// Cells of the rod along x, y and z. It hangs along -y from the origin, the center of its upper end.
const ROD: [i32; 3] = [4, 12, 4];

/// Edge of a cell, h: the rod is one scene unit long.
const CELL_SIZE: f64 = 1.0 / 12.0;

/// Gravity in scene units per second squared.
const GRAVITY: f64 = 9.81;

/// Mass per volume.
const DENSITY: f64 = 1000.0;

/// Amplitude of the swing in degrees.
const AMPLITUDE: f64 = 30.0;

/// Number of swings, so that the third maximum of the angle is reached.
const SWINGS: f64 = 3.1;

/// Young's moduli with steps per second, for which regions of half-width 2 suffice.
const MATERIALS: [(f64, f64); 2] = [(1e6, 300.0), (1e7, 900.0)];

/// Returns the bound of the relative errors of period and amplitude.
fn bound(modulus: f64, step_rate: f64) -> f64 {
    let weight = DENSITY * GRAVITY * ROD.map(|cells| f64::from(cells) * CELL_SIZE).iter().product::<f64>();
    let radius = CELL_SIZE * 6.0_f64.sqrt();
    let arm = 0.5 * f64::from(ROD[1]) * CELL_SIZE;
    weight / (modulus * radius * arm) + f64::from(f32::EPSILON) * CELL_SIZE * step_rate.powi(2) / GRAVITY
}

/// Returns the period in seconds of the rigid rod with the vertex masses of the lattice. For a swing of amplitude a it
/// is the period of small swings divided by the arithmetic-geometric mean of 1 and cos(a/2).
fn rigid_period(body: &Body) -> f64 {
    let indices = body.lattice().indices().iter();
    let arms: Vec<_> = indices.map(|index| index.map(|i| f64::from(i) * CELL_SIZE)).collect();
    let sum = |value: &dyn Fn(&[f64; 3]) -> f64| -> f64 {
        arms.iter().zip(body.masses()).map(|(arm, mass)| mass * value(arm)).sum()
    };
    let (moment, inertia) = (sum(&|arm| -arm[1]), sum(&|arm| arm[0] * arm[0] + arm[1] * arm[1]));
    let (mut a, mut b) = (1.0, (AMPLITUDE.to_radians() / 2.0).cos());
    for _ in 0..6 {
        (a, b) = ((a + b) / 2.0, (a * b).sqrt());
    }
    std::f64::consts::TAU / ((GRAVITY * moment / inertia).sqrt() * a)
}

/// Returns the angle of the center of mass of a body from the vertical in degrees.
fn angle(body: &Body) -> f64 {
    let weighted = body.positions().into_iter().zip(body.masses());
    let center: Vector3<f64> = weighted.map(|(p, mass)| p.coords * mass).sum();
    center.x.atan2(-center.y).to_degrees()
}

/// Builds a rod that is turned by the amplitude and pinned at the vertices with the indices `pinned`.
fn rod(pinned: &[[i32; 3]], modulus: f64) -> Result<Body, Error> {
    let centered = |[x, y, z]: [i32; 3]| [x - ROD[0] / 2, y - ROD[1], z - ROD[2] / 2];
    let cells: Vec<_> = block(ROD).into_iter().map(centered).collect();
    let lattice = Lattice::from_cells(&cells, CELL_SIZE, Point3::origin(), false)?;
    let indexed = (0..).zip(lattice.indices());
    let vertices = indexed.filter(|(_, index)| pinned.contains(index)).map(|(vertex, _)| vertex).collect();
    let pin = Pin { goal: None, selection: Selection::Vertices(vertices), window: TimeWindow::default() };
    let body = Body::from_lattice(lattice).youngs_modulus(modulus).density(DENSITY);
    body.rotate([0.0, 0.0, AMPLITUDE]).pin(pin).build()
}

/// Lets a rod swing from rest, and measures the period and the amplitude of the last swing.
fn swung(pinned: &[[i32; 3]], (modulus, step_rate): (f64, f64)) -> Result<Figures, Error> {
    let body = rod(pinned, modulus)?;
    let period = rigid_period(&body);
    let simulation = Simulation::builder().body(body).gravity([0.0, -GRAVITY, 0.0]).dt(1.0 / step_rate);
    let simulation = simulation.sleep(false).threads(1).build()?;
    Ok(measure(simulation, System::Driven, |trial| {
        let mut before = angle(&trial.simulation.body(0));
        // Times at which the rod passes the vertical in the direction of the first passage.
        let mut passages: Vec<f64> = Vec::new();
        let mut amplitude = 0.0_f64;
        while trial.simulation.time() < SWINGS * period {
            trial.run(10, 10);
            let (now, time) = (angle(&trial.simulation.body(0)), trial.simulation.time());
            if before > 0.0 && now <= 0.0 {
                passages.push(time - 10.0 / step_rate * now / (now - before));
                amplitude = 0.0;
            }
            amplitude = amplitude.max(now);
            before = now;
        }
        let measured = (passages[passages.len() - 1] - passages[0]) / (passages.len() - 1) as f64;
        trial.raise(Measure::Period, (measured / period - 1.0).abs());
        trial.raise(Measure::AmplitudeLoss, 1.0 - amplitude / AMPLITUDE);
    }))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let line: Vec<[i32; 3]> = (-ROD[2] / 2..=ROD[2] / 2).map(|z| [0, 0, z]).collect();
    let mut cases = Vec::new();
    for (name, pinned) in [("one vertex", vec![[0, 0, 0]]), ("a line of vertices", line)] {
        for (modulus, step_rate) in MATERIALS {
            let (pinned, limit) = (pinned.clone(), bound(modulus, step_rate));
            let expected = "swings like a rigid pendulum, without elastic damping";
            let name = format!("rod pinned at {name}, Young's modulus {modulus:e}");
            let case = Case::new(name, expected, move || swung(&pinned, (modulus, step_rate)));
            cases.push(case.bound(Measure::Period, limit).bound(Measure::AmplitudeLoss, limit));
        }
    }
    cases
}
