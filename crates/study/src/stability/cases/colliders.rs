//! Cases with colliders that squeeze, pierce or enclose a body or overlap each other, and with slopes.

use supple::{Collider, Error, Simulation};

use crate::stability::bodies::{Matter, block, of_cells, plate};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};

/// Half of the edge of the block, in cells.
const HALF: f64 = 3.0;

/// Drops a block on colliders with friction 0.5. Its center starts at `height` cells above the origin.
fn drop_on(matter: Matter, colliders: &[Collider], height: f64) -> Result<Figures, Error> {
    let body = of_cells(&block([6; 3]), matter)?.region_damping(0.1);
    let body = body.translate([-HALF, height - HALF, -HALF]).build()?;
    let rough = |collider: &Collider| Collider { friction: 0.5, ..collider.clone() };
    let simulation = Simulation::builder().sleep(false).body(body).threads(1);
    let simulation = colliders.iter().map(rough).fold(simulation, |all, collider| all.collider(collider));
    Ok(measure(simulation.build()?, System::Driven, |trial| trial.run(3_000, 20)))
}

/// Compresses a block between two plates to a tenth of a cell within 1 s, and releases it 1 s later.
fn squeeze(matter: Matter) -> Result<Figures, Error> {
    let body = of_cells(&block([6; 3]), matter)?.region_damping(0.1).build()?;
    let simulation = Simulation::builder().sleep(false).body(body).gravity([0.0; 3]).threads(1);
    let rough = |plate| Collider { friction: 0.5, ..plate };
    let simulation = simulation.collider(rough(plate(-0.5, 1.0, 3.45)));
    let simulation = simulation.collider(rough(plate(6.5, -1.0, -3.45)));
    Ok(measure(simulation.build()?, System::Driven, |trial| trial.run(3_000, 20)))
}

/// Places a block on a slope of 20 degrees with friction 1, which would suffice on a slope of 45 degrees.
/// Measures the displacement in 3,000 steps, after 600 steps in which the block comes to rest.
fn on_a_slope(matter: Matter, damping: f64) -> Result<Figures, Error> {
    let body = of_cells(&block([6; 3]), matter)?.region_damping(damping).build()?;
    let slope = Collider { friction: 1.0, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let (sine, cosine) = 20.0_f64.to_radians().sin_cos();
    let simulation = Simulation::builder().sleep(false).body(body).collider(slope).threads(1);
    let simulation = simulation.gravity([9.81 * sine, -9.81 * cosine, 0.0]).build()?;
    Ok(measure(simulation, System::Driven, |trial| {
        trial.run(600, 20);
        let at_rest = trial.simulation.body(0).positions();
        trial.run(3_000, 20);
        let now = trial.simulation.body(0).positions();
        trial.place(&at_rest, &now);
    }))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let up = [0.0, 1.0, 0.0];
    let ground = Collider::plane([0.0, -10.0, 0.0], up);
    let needle = vec![Collider::capsule([0.1, -10.0, 0.1], [0.1, 0.0, 0.1], 0.05), ground.clone()];
    let balls = [-4.0, 4.0].map(|x| Collider::sphere([x, -4.0, 0.0], 6.0));
    let balls = vec![balls[0].clone(), balls[1].clone(), ground];
    let plates = vec![Collider::plane([0.0, 1.0, 0.0], up), Collider::plane([0.0; 3], [0.0, -1.0, 0.0])];
    let cuboid = vec![Collider::cuboid([0.0; 3], [20.0; 3], [10.0, 20.0, 30.0])];
    let mut cases = Vec::new();
    for matter in Matter::wide(2.0) {
        let squeezed = "squeezed flat between plates and let go";
        let case = Case::new(matter.named(squeezed), "returns to its rest shape", move || squeeze(matter));
        cases.push(case.bound(Measure::Shape, 1e-3).bound(Measure::LargestSpeed, 1.0));
        let overlapping = "comes to rest, although no position is outside both plates";
        for (name, expected, colliders, height) in [
            ("dropped on a needle", "comes to rest", &needle, 5.0),
            ("wedged between balls that overlap", "comes to rest", &balls, 7.0),
            ("between plates that overlap", overlapping, &plates, 0.5),
        ] {
            let colliders = colliders.clone();
            let case = Case::new(matter.named(name), expected, move || drop_on(matter, &colliders, height));
            cases.push(case.bound(Measure::FinalSpeed, 5e-3).suite(matter.suite()));
        }
        let cuboid = cuboid.clone();
        let inside = move || drop_on(matter, &cuboid, 14.0);
        let case = Case::new(matter.named("inside a box of 40 cells"), "leaves the box whole", inside);
        cases.push(case.bound(Measure::LargestSpeed, 25.0).bound(Measure::Shape, 0.1));
        let undamped = "slides at first, while its vibration unloads it";
        let slopes = [("damped", 0.1, 0.05, "does not move"), ("undamped", 0.0, 0.5, undamped)];
        // With Poisson's ratio the greatest stable stiffness is lower: the block is so soft that it tips over and rolls.
        for (name, damping, place, expected) in slopes.into_iter().filter(|_| matter.is_plain()) {
            let name = matter.named(format!("on a slope, {name}"));
            let case = Case::new(name, expected, move || on_a_slope(matter, damping));
            cases.push(case.bound(Measure::Place, place));
        }
    }
    cases
}
