//! Colliders that leave no room, or nothing to stand on.

use supple::{Body, Collider, Error, Key, Simulation};

use super::super::bodies::{block, lattice};
use super::super::trial::{Surroundings, watch};
use super::super::{Case, Figures, Measure};

const FAMILY: &str = "colliders";

/// Half the edge of the block in cells.
const HALF: f64 = 3.0;

/// A block whose centre is at `height` over the origin falls among colliders, which are rough.
fn falls(colliders: &[Collider], height: f64, damping: f64) -> Result<Figures, Error> {
    let body = Body::from_lattice(lattice(&block([6; 3]))?).half_width(2).damping(damping);
    let body = body.translate([-HALF, height - HALF, -HALF]).build()?;
    let rough = |collider: &Collider| Collider { friction: 0.5, ..collider.clone() };
    let simulation = Simulation::builder().body(body).threads(1);
    let simulation = colliders.iter().map(rough).fold(simulation, |all, collider| all.collider(collider));
    watch(simulation.build()?, Surroundings::Acting, |trial| {
        trial.run(3_000, 20);
        Ok(())
    })
}

/// A block is pressed between two plates to a tenth of a cell within a second, and let go a second later.
fn squeezed() -> Result<Figures, Error> {
    let body = Body::from_lattice(lattice(&block([6; 3]))?).half_width(2).damping(0.1).build()?;
    let plate = |y: f64, normal: f64, way: f64| {
        let key = |(time, way)| Key { time, translate: [0.0, way, 0.0], rotate: [0.0; 3] };
        let keys = [(0.0, 0.0), (1.0, way), (2.0, way), (2.5, 0.0)].map(key).to_vec();
        Collider { keys, friction: 0.5, ..Collider::plane([0.0, y, 0.0], [0.0, normal, 0.0]) }
    };
    let simulation = Simulation::builder().body(body).gravity([0.0; 3]).threads(1);
    let simulation = simulation.collider(plate(-0.5, 1.0, 3.45)).collider(plate(6.5, -1.0, -3.45));
    watch(simulation.build()?, Surroundings::Acting, |trial| {
        trial.run(3_000, 20);
        Ok(())
    })
}

/// A block on a slope of 20 degrees whose friction would hold one of 45 degrees.
fn on_a_slope(damping: f64) -> Result<Figures, Error> {
    let body = Body::from_lattice(lattice(&block([6; 3]))?).half_width(2).damping(damping).build()?;
    let slope = Collider { friction: 1.0, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let (sine, cosine) = 20.0_f64.to_radians().sin_cos();
    let simulation = Simulation::builder().body(body).collider(slope).threads(1);
    let simulation = simulation.gravity([9.81 * sine, -9.81 * cosine, 0.0]).build()?;
    watch(simulation, Surroundings::Acting, |trial| {
        trial.run(600, 20);
        let rested = trial.simulation.body(0).positions();
        trial.run(3_000, 20);
        let now = trial.simulation.body(0).positions();
        trial.place(&rested, &now);
        Ok(())
    })
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
        Case::new(FAMILY, "squeezed flat between plates and let go", "returns to its rest shape", squeezed)
            .bound(Measure::Shape, 1e-3)
            .bound(Measure::LargestSpeed, 1.0),
        Case::new(FAMILY, "dropped on a needle", "comes to rest", move || falls(&needle, 5.0, 0.1))
            .bound(Measure::FinalSpeed, 5e-3),
        Case::new(FAMILY, "wedged between balls that overlap", "comes to rest", move || {
            falls(&balls, 7.0, 0.1)
        })
        .bound(Measure::FinalSpeed, 5e-3),
        Case::new(
            FAMILY,
            "between plates that overlap",
            "comes to rest, though no place is outside both",
            move || falls(&plates, 0.5, 0.1),
        )
        .bound(Measure::FinalSpeed, 5e-3),
        Case::new(
            FAMILY,
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
        let case = Case::new(FAMILY, format!("on a slope, {name}"), shows, move || on_a_slope(damping));
        cases.push(case.bound(Measure::Place, place));
    }
    cases
}
