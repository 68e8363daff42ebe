//! Sizes and places: what is done must not depend on them.

use nalgebra::{Point3, Vector3};
use supple::{Body, Collider, Error, Simulation};

use crate::bodies::{block, deform, sized};
use crate::trial::Trial;
use crate::{Case, Figures, Measure};

const FAMILY: &str = "scales";

/// A stretched block falls on the ground and comes to rest, all lengths times `cell`, about `place`.
fn dropped(cell: f64, place: [f64; 3], steps: u64) -> Result<Trial, Error> {
    let body = Body::from_lattice(sized(&block([5, 3, 4]), cell)?).half_width(2).damping(0.05);
    let mut body = body.translate(place).rotate([20.0, 0.0, 10.0]).build()?;
    deform(&mut body, |x| x.iter().map(|x| x.component_mul(&Vector3::new(1.3, 0.8, 1.0))).collect())?;
    let ground = place[1] - 3.0 * cell;
    let ground = Collider { friction: 0.5, ..Collider::plane([place[0], ground, place[2]], [0.0, 1.0, 0.0]) };
    let simulation = Simulation::builder().body(body).collider(ground).gravity([0.0, -9.81 * cell, 0.0]).threads(1);
    let mut trial = Trial::bound(simulation.build()?);
    trial.run(steps, 20);
    Ok(trial)
}

/// The same beside cells of edge 1 in the origin.
fn beside_unit(cell: f64, place: [f64; 3], steps: u64) -> Result<Figures, Error> {
    let unit = dropped(1.0, [0.0; 3], steps)?;
    let mut trial = dropped(cell, place, steps)?;
    let expected = unit.simulation.body(0).positions();
    let positions = trial.simulation.body(0).positions();
    let scaled: Vec<_> = positions.iter().map(|p| Point3::from((p.coords - Vector3::from(place)) / cell)).collect();
    trial.place(&expected, &scaled);
    Ok(trial.finish())
}

/// The cases.
pub(super) fn cases() -> Vec<Case> {
    let places = [
        ("cells of 1 mm", 1e-3, [0.0; 3]),
        ("cells of 10 km", 1e4, [0.0; 3]),
        ("cells of 1e-12", 1e-12, [0.0; 3]),
        ("cells of 1e12", 1e12, [0.0; 3]),
        ("10^7 cells from the origin", 1.0, [1e7, -1e7, 1e7]),
        ("cells of 1 mm, 10^7 from the origin", 1e-3, [1e7, -1e7, 1e7]),
    ];
    places
        .into_iter()
        .map(|(name, cell, place)| {
            let shows = "falls, bounces and rests as cells of edge 1 do in the origin";
            Case::new(FAMILY, name, shows, move || beside_unit(cell, place, 600)).bound(Measure::Place, 1e-3)
        })
        .collect()
}
