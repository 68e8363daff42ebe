//! Cases in free flight: high speed, high spin and long duration.

use nalgebra::{Point3, Vector3};
use supple::{Body, Error};

use crate::stability::bodies::{alone, block, of_cells, shake, two_blocks};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};
use crate::suite::Suite;

/// Lets a body fly. Compares the final position of each vertex with its initial position plus its velocity
/// times the duration. The figures are updated after each `interval` steps.
fn compare_with_uniform_motion(
    body: Body,
    velocities: &[Vector3<f64>],
    [steps, interval]: [u64; 2],
) -> Result<Figures, Error> {
    let start = body.positions();
    Ok(measure(alone(body)?, System::Isolated, |trial| {
        trial.run(steps, interval);
        let time = trial.simulation.time();
        let expected: Vec<Point3<f64>> = start.iter().zip(velocities).map(|(p, v)| p + v * time).collect();
        let now = trial.simulation.body(0).positions();
        trial.place(&expected, &now);
    }))
}

/// Lets a block fly at a uniform velocity, whose x component is `speed` scene units per second.
fn fast(speed: f64) -> Result<Figures, Error> {
    let velocity = Vector3::new(1.0, -0.3, 0.1) * speed;
    let body = of_cells(&block([5, 4, 3]), 2.0)?.velocity(velocity.into()).build()?;
    let velocities = vec![velocity; body.lattice().len()];
    compare_with_uniform_motion(body, &velocities, [10_000, 500])
}

/// Lets two blocks of one body that are not connected fly apart, each with `speed` scene units per second.
fn parting(speed: f64) -> Result<Figures, Error> {
    let mut body = of_cells(&two_blocks([8, 0, 0]), 2.0)?.build()?;
    let velocity = |&component: &u32| Vector3::new(if component == 0 { -speed } else { speed }, 0.0, 0.0);
    let velocities: Vec<_> = body.lattice().components().of_vertex.iter().map(velocity).collect();
    body.set_velocities(&velocities)?;
    compare_with_uniform_motion(body, &velocities, [600, 60])
}

/// Lets a block spin by one radian per step.
fn spinning(damping: f64) -> Result<Figures, Error> {
    let body = of_cells(&block([5, 4, 3]), 2.0)?.region_damping(damping);
    Ok(measure(alone(body.spin([0.0, 0.0, 60.0]).build()?)?, System::Isolated, |trial| {
        trial.run(10_000, 500)
    }))
}

/// Lets an undamped block vibrate and spin.
fn long(steps: u64) -> Result<Figures, Error> {
    let body = of_cells(&block([5, 3, 3]), 1.0)?.stiffness(0.7);
    let mut body = body.spin([0.5, 1.0, 2.0]).build()?;
    let spinning = body.velocities();
    shake(&mut body, 0.1)?;
    let sums: Vec<_> = body.velocities().iter().zip(&spinning).map(|(v, w)| v + w).collect();
    body.set_velocities(&sums)?;
    Ok(measure(alone(body)?, System::Isolated, |trial| trial.run(steps, steps / 100)))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, speed, place) in [("1e6", 1e6, 1e-3), ("1e9", 1e9, 0.1)] {
        let expected = "moves uniformly in its rest shape";
        let case = Case::new(format!("initial speed {name}"), expected, move || fast(speed));
        cases
            .push(case.bound(Measure::Place, place).bound(Measure::Shape, 1e-3).bound(Measure::Linear, 1e-9));
    }
    for (name, speed, place) in [("1e2", 1e2, 1e-2), ("1e6", 1e6, 20.0)] {
        let expected = "move uniformly, to 1e-6 of their distance: the parts of a body share an f32 frame";
        let case = Case::new(format!("parts that fly apart at {name}"), expected, move || parting(speed));
        cases.push(case.bound(Measure::Place, place).keeps_momenta());
    }
    for (name, damping, gain) in [("undamped", 0.0, 0.05), ("damped", 0.1, 1e-5)] {
        let expected = "keeps its spin, which stretches it";
        let case = Case::new(format!("spin of a radian a step, {name}"), expected, move || spinning(damping));
        cases.push(case.bound(Measure::EnergyGain, gain).bound(Measure::Shape, 5.0).keeps_momenta());
    }
    let expected = "keeps its momenta and its energy";
    let case = Case::new("10^6 steps, spinning and shaken, undamped", expected, || long(1_000_000));
    cases.push(case.bound(Measure::EnergyGain, 0.05).keeps_momenta().suite(Suite::Long));
    cases
}
