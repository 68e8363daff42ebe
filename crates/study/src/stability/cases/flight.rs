//! Free flight: fast, spinning, and for a long time.

use nalgebra::{Point3, Vector3};
use supple::{Body, Error};

use crate::stability::bodies::{alone, block, of_cells, shake, two_blocks};
use crate::stability::case::{Case, Figures, Measure, Suite};
use crate::stability::trial::{Surroundings, watch};

/// A body that flies, each vertex with a velocity of its own; where it is expected is known.
fn flies(body: Body, velocities: &[Vector3<f64>], [steps, every]: [u64; 2]) -> Result<Figures, Error> {
    let start = body.positions();
    Ok(watch(alone(body)?, Surroundings::Empty, |trial| {
        trial.run(steps, every);
        let time = trial.simulation.time();
        let expected: Vec<Point3<f64>> = start.iter().zip(velocities).map(|(p, v)| p + v * time).collect();
        let now = trial.simulation.body(0).positions();
        trial.place(&expected, &now);
    }))
}

/// A block with a velocity.
fn fast(speed: f64) -> Result<Figures, Error> {
    let velocity = Vector3::new(1.0, -0.3, 0.1) * speed;
    let body = of_cells(&block([5, 4, 3]), 2)?.velocity(velocity.into()).build()?;
    let velocities = vec![velocity; body.lattice().len()];
    flies(body, &velocities, [10_000, 500])
}

/// Two blocks of one body, which nothing joins, that fly apart.
fn parting(speed: f64) -> Result<Figures, Error> {
    let mut body = of_cells(&two_blocks([8, 0, 0]), 2)?.build()?;
    let velocity = |&part: &u32| Vector3::new(if part == 0 { -speed } else { speed }, 0.0, 0.0);
    let velocities: Vec<_> = body.lattice().components().of_vertex.iter().map(velocity).collect();
    body.set_velocities(&velocities)?;
    flies(body, &velocities, [600, 60])
}

/// A block that spins by a radian a step.
fn spinning(damping: f64) -> Result<Figures, Error> {
    let body = of_cells(&block([5, 4, 3]), 2)?.region_damping(damping);
    Ok(watch(alone(body.spin([0.0, 0.0, 60.0]).build()?)?, Surroundings::Empty, |trial| {
        trial.run(10_000, 500)
    }))
}

/// A block that vibrates and spins, undamped.
fn long(steps: u64) -> Result<Figures, Error> {
    let body = of_cells(&block([5, 3, 3]), 1)?.stiffness(0.7);
    let mut body = body.spin([0.5, 1.0, 2.0]).build()?;
    let spinning = body.velocities();
    shake(&mut body, 0.1)?;
    let both: Vec<_> = body.velocities().iter().zip(&spinning).map(|(v, w)| v + w).collect();
    body.set_velocities(&both)?;
    Ok(watch(alone(body)?, Surroundings::Empty, |trial| trial.run(steps, steps / 100)))
}

/// The cases.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, speed, place) in [("1e6", 1e6, 1e-3), ("1e9", 1e9, 0.1)] {
        let shows = "flies as a point does, in its rest shape";
        let case = Case::new(format!("initial speed {name}"), shows, move || fast(speed));
        cases
            .push(case.bound(Measure::Place, place).bound(Measure::Shape, 1e-3).bound(Measure::Linear, 1e-9));
    }
    for (name, speed, place) in [("1e2", 1e2, 1e-2), ("1e6", 1e6, 20.0)] {
        let shows =
            "fly as points do, to 1e-6 of the distance between them: parts of a body share their f32 frame";
        let case = Case::new(format!("parts that fly apart at {name}"), shows, move || parting(speed));
        cases.push(case.bound(Measure::Place, place).keeps_momenta());
    }
    for (name, damping, gain) in [("undamped", 0.0, 0.05), ("damped", 0.1, 1e-5)] {
        let shows = "keeps its spin, stretched by it";
        let case = Case::new(format!("spin of a radian a step, {name}"), shows, move || spinning(damping));
        cases.push(case.bound(Measure::EnergyGain, gain).bound(Measure::Shape, 5.0).keeps_momenta());
    }
    let shows = "keeps its momenta and its energy";
    let case = Case::new("10^6 steps, spinning and shaken, undamped", shows, || long(1_000_000));
    cases.push(case.bound(Measure::EnergyGain, 0.05).keeps_momenta().suite(Suite::Long));
    cases
}
