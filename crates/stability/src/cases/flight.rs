//! Free flight: fast, spinning, and for a long time.

use nalgebra::{Point3, Vector3};
use supple::{Body, Error, Simulation};

use crate::bodies::{alone, block, lattice, shake, two_blocks};
use crate::trial::Trial;
use crate::{Case, Figures, Measure};

const FAMILY: &str = "free flight";

fn fast(speed: f64) -> Result<Figures, Error> {
    let body = Body::from_lattice(lattice(&block([5, 4, 3]))?).half_width(2).velocity([speed, -0.3 * speed, 0.1 * speed]).build()?;
    let start = body.positions();
    let mut trial = Trial::free(alone(body)?);
    trial.run(10_000, 500);
    let way = Vector3::new(1.0, -0.3, 0.1) * (speed * trial.simulation.time());
    let expected: Vec<Point3<f64>> = start.iter().map(|p| p + way).collect();
    let now = trial.simulation.body(0).positions();
    trial.place(&expected, &now);
    Ok(trial.finish())
}

fn parting(speed: f64, steps: u64) -> Result<Figures, Error> {
    let cells = two_blocks([8, 0, 0]);
    let mut body = Body::from_lattice(lattice(&cells)?).half_width(2).build()?;
    let of = &body.lattice().components().of_vertex;
    let velocity = |&part: &u32| Vector3::new(if part == 0 { -speed } else { speed }, 0.0, 0.0);
    let velocities: Vec<_> = of.iter().map(velocity).collect();
    body.set_velocities(&velocities)?;
    let start = body.positions();
    let mut trial = Trial::free(alone(body)?);
    trial.run(steps, steps / 20);
    let time = trial.simulation.time();
    let expected: Vec<Point3<f64>> = start.iter().zip(&velocities).map(|(p, v)| p + v * time).collect();
    let now = trial.simulation.body(0).positions();
    trial.place(&expected, &now);
    Ok(trial.finish())
}

fn spinning(damping: f64) -> Result<Figures, Error> {
    let body = Body::from_lattice(lattice(&block([5, 4, 3]))?).half_width(2).damping(damping).spin([0.0, 0.0, 60.0]);
    let mut trial = Trial::free(alone(body.build()?)?);
    trial.run(10_000, 500);
    Ok(trial.finish())
}

fn long(steps: u64) -> Result<Figures, Error> {
    let mut body = Body::from_lattice(lattice(&block([5, 3, 3]))?).half_width(1).stiffness(0.7).build()?;
    shake(&mut body, 0.1)?;
    let mut trial = Trial::free(Simulation::builder().body(body).gravity([0.0; 3]).threads(1).build()?);
    trial.run(steps, steps / 100);
    Ok(trial.finish())
}

/// The cases.
pub(super) fn cases() -> Vec<Case> {
    vec![
        Case::new(FAMILY, "initial speed 1e6", "flies as a point does", || fast(1e6)).bound(Measure::Place, 1e-2).bound(Measure::Shape, 1e-3).bound(Measure::Linear, 1e-9),
        Case::new(FAMILY, "initial speed 1e12", "flies as a point does", || fast(1e12)).bound(Measure::Shape, 1e-3).bound(Measure::Linear, 1e-9),
        Case::new(FAMILY, "parts that fly apart at 100", "", || parting(1e2, 600)).bound(Measure::Place, 1e-2),
        Case::new(FAMILY, "parts that fly apart at 1e6", "", || parting(1e6, 600)).bound(Measure::Place, 1e-2),
        Case::new(FAMILY, "spin of a radian a step, undamped", "", || spinning(0.0)).bound(Measure::Angular, 1e-6).bound(Measure::EnergyGain, 0.05),
        Case::new(FAMILY, "spin of a radian a step, damped", "", || spinning(0.1)).bound(Measure::Angular, 1e-6).bound(Measure::EnergyGain, 1e-6),
        Case::new(FAMILY, "10^6 steps, undamped", "", || long(1_000_000)).bound(Measure::Angular, 1e-6).bound(Measure::Linear, 1e-6).bound(Measure::EnergyGain, 0.05).long(),
    ]
}
