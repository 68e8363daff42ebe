//! Colliders that leave no room, or nothing to stand on.

use supple::{Body, Collider, Error, Key, Simulation};

use crate::bodies::{block, lattice};
use crate::trial::Trial;
use crate::{Case, Figures, Measure};

const FAMILY: &str = "colliders";

fn settled(colliders: Vec<Collider>, steps: u64, height: f64) -> Result<Trial, Error> {
    let body = Body::from_lattice(lattice(&block([6; 3]))?).half_width(2).damping(0.1).translate([-3.0, height, -3.0]);
    let mut simulation = Simulation::builder().body(body.build()?).threads(1);
    for collider in colliders {
        simulation = simulation.collider(Collider { friction: 0.5, ..collider });
    }
    let mut trial = Trial::bound(simulation.build()?);
    trial.run(steps, 20);
    Ok(trial)
}

/// Pressed between two plates to a tenth of a cell within a second, and let go a second later.
fn squeezed() -> Result<Figures, Error> {
    let body = Body::from_lattice(lattice(&block([6; 3]))?).half_width(2).damping(0.1).build()?;
    let plate = |y: f64, normal: f64, way: f64| {
        let keys = [(0.0, 0.0), (1.0, way), (2.0, way), (2.5, 0.0)];
        let key = |(time, way)| Key { time, translate: [0.0, way, 0.0], rotate: [0.0; 3] };
        Collider { keys: keys.map(key).to_vec(), friction: 0.5, ..Collider::plane([0.0, y, 0.0], [0.0, normal, 0.0]) }
    };
    let simulation = Simulation::builder().body(body).gravity([0.0; 3]).threads(1);
    let simulation = simulation.collider(plate(-0.5, 1.0, 3.45)).collider(plate(6.5, -1.0, -3.45)).build()?;
    let mut trial = Trial::bound(simulation);
    trial.run(3_000, 20);
    Ok(trial.finish())
}

fn needle() -> Result<Figures, Error> {
    let needle = Collider::capsule([0.1, -10.0, 0.1], [0.1, 0.0, 0.1], 0.05);
    let ground = Collider::plane([0.0, -10.0, 0.0], [0.0, 1.0, 0.0]);
    Ok(settled(vec![needle, ground], 3_000, 2.0)?.finish())
}

fn wedged() -> Result<Figures, Error> {
    let ball = |x: f64| Collider::sphere([x, -4.0, 0.0], 6.0);
    Ok(settled(vec![ball(-4.0), ball(4.0), Collider::plane([0.0, -10.0, 0.0], [0.0, 1.0, 0.0])], 3_000, 4.0)?.finish())
}

fn no_room() -> Result<Figures, Error> {
    let low = Collider::plane([0.0, 2.0, 0.0], [0.0, 1.0, 0.0]);
    let high = Collider::plane([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]);
    Ok(settled(vec![low, high], 3_000, 0.0)?.finish())
}

fn inside() -> Result<Figures, Error> {
    Ok(settled(vec![Collider::cuboid([0.0; 3], [20.0; 3], [10.0, 20.0, 30.0])], 3_000, -3.0)?.finish())
}

/// The cases.
pub(super) fn cases() -> Vec<Case> {
    vec![
        Case::new(FAMILY, "squeezed flat between plates and let go", "returns to its rest shape", squeezed)
            .bound(Measure::Shape, 1e-3)
            .bound(Measure::LargestSpeed, 5.0),
        Case::new(FAMILY, "dropped on a needle", "comes to rest, on the needle or beside it", needle)
            .bound(Measure::LargestSpeed, 5.0)
            .bound(Measure::FinalSpeed, 1e-2),
        Case::new(FAMILY, "wedged between overlapping balls", "comes to rest", wedged)
            .bound(Measure::LargestSpeed, 5.0)
            .bound(Measure::FinalSpeed, 1e-2),
        Case::new(FAMILY, "between plates that overlap", "no place is outside both: stays bounded", no_room)
            .bound(Measure::LargestSpeed, 5.0),
        Case::new(FAMILY, "deep inside a box", "comes out bit by bit", inside).bound(Measure::LargestSpeed, 5.0),
    ]
}
