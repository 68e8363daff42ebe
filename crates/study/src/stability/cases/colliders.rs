//! Colliders that leave no room, or nothing to stand on.

use supple::{Collider, Error, Simulation};

use crate::stability::bodies::{block, of_cells, plate};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{Surroundings, watch};

/// Half the edge of the block in cells.
const HALF: f64 = 3.0;

/// A block whose center is at `height` over the origin falls among colliders, which are rough.
fn falls(colliders: &[Collider], height: f64, damping: f64) -> Result<Figures, Error> {
    let body = of_cells(&block([6; 3]), 2)?.region_damping(damping);
    let body = body.translate([-HALF, height - HALF, -HALF]).build()?;
    let rough = |collider: &Collider| Collider { friction: 0.5, ..collider.clone() };
    let simulation = Simulation::builder().body(body).threads(1);
    let simulation = colliders.iter().map(rough).fold(simulation, |all, collider| all.collider(collider));
    Ok(watch(simulation.build()?, Surroundings::Acting, |trial| trial.run(3_000, 20)))
}

/// A block is pressed between two plates to a tenth of a cell within a second, and let go a second later.
fn squeezed() -> Result<Figures, Error> {
    let body = of_cells(&block([6; 3]), 2)?.region_damping(0.1).build()?;
    let simulation = Simulation::builder().body(body).gravity([0.0; 3]).threads(1);
    let rough = |plate| Collider { friction: 0.5, ..plate };
    let simulation = simulation.collider(rough(plate(-0.5, 1.0, 3.45)));
    let simulation = simulation.collider(rough(plate(6.5, -1.0, -3.45)));
    Ok(watch(simulation.build()?, Surroundings::Acting, |trial| trial.run(3_000, 20)))
}

/// A block on a slope of 20 degrees whose friction would hold one of 45 degrees.
fn on_a_slope(damping: f64) -> Result<Figures, Error> {
    let body = of_cells(&block([6; 3]), 2)?.region_damping(damping).build()?;
    let slope = Collider { friction: 1.0, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let (sine, cosine) = 20.0_f64.to_radians().sin_cos();
    let simulation = Simulation::builder().body(body).collider(slope).threads(1);
    let simulation = simulation.gravity([9.81 * sine, -9.81 * cosine, 0.0]).build()?;
    Ok(watch(simulation, Surroundings::Acting, |trial| {
        trial.run(600, 20);
        let rested = trial.simulation.body(0).positions();
        trial.run(3_000, 20);
        let now = trial.simulation.body(0).positions();
        trial.place(&rested, &now);
    }))
}

/// The cases.
pub(super) fn cases() -> Vec<Case> {
    let up = [0.0, 1.0, 0.0];
    let ground = Collider::plane([0.0, -10.0, 0.0], up);
    let needle = vec![Collider::capsule([0.1, -10.0, 0.1], [0.1, 0.0, 0.1], 0.05), ground.clone()];
    let balls = [-4.0, 4.0].map(|x| Collider::sphere([x, -4.0, 0.0], 6.0));
    let balls = vec![balls[0].clone(), balls[1].clone(), ground];
    let plates = vec![Collider::plane([0.0, 1.0, 0.0], up), Collider::plane([0.0; 3], [0.0, -1.0, 0.0])];
    let cuboid = vec![Collider::cuboid([0.0; 3], [20.0; 3], [10.0, 20.0, 30.0])];
    let mut cases = vec![
        Case::new("squeezed flat between plates and let go", "returns to its rest shape", squeezed)
            .bound(Measure::Shape, 1e-3)
            .bound(Measure::LargestSpeed, 1.0),
        Case::new("dropped on a needle", "comes to rest", move || falls(&needle, 5.0, 0.1))
            .bound(Measure::FinalSpeed, 5e-3),
        Case::new("wedged between balls that overlap", "comes to rest", move || falls(&balls, 7.0, 0.1))
            .bound(Measure::FinalSpeed, 5e-3),
        Case::new(
            "between plates that overlap",
            "comes to rest, though no place is outside both",
            move || falls(&plates, 0.5, 0.1),
        )
        .bound(Measure::FinalSpeed, 5e-3),
        Case::new(
            "inside a box of 40 cells",
            "comes out bit by bit, or comes to rest where it is",
            move || falls(&cuboid, 14.0, 0.1),
        )
        .bound(Measure::LargestSpeed, 25.0),
    ];
    let slopes = [
        ("damped", 0.1, 0.05, "stays where it is"),
        ("undamped", 0.0, 0.5, "creeps: it trembles for ever, and each time that it is lifted it slides"),
    ];
    for (name, damping, place, shows) in slopes {
        let case = Case::new(format!("on a slope, {name}"), shows, move || on_a_slope(damping));
        cases.push(case.bound(Measure::Place, place));
    }
    cases
}
