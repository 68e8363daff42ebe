//! Cases with different cell sizes and distances from the origin. The motion must not depend on either.

use nalgebra::{Point3, Vector3};
use supple::{Collider, Error, Simulation};

use crate::stability::bodies::{Matter, block, deform, of_sized_cells};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};

/// Builds a scene with a stretched block that falls, with or without a ground. All lengths are multiplied by
/// `cell`, and the scene is translated by `origin`.
fn falling_scene(matter: Matter, cell: f64, origin: [f64; 3], ground: bool) -> Result<Simulation, Error> {
    let body = of_sized_cells(&block([5, 3, 4]), cell, matter)?.region_damping(0.05);
    let mut body = body.translate(origin).rotate([20.0, 0.0, 10.0]).build()?;
    deform(&mut body, |x| x.iter().map(|x| x.component_mul(&Vector3::new(1.3, 0.8, 1.0))).collect())?;
    let simulation =
        Simulation::builder().sleep(false).body(body).gravity([0.0, -9.81 * cell, 0.0]).threads(1);
    let point = [origin[0], origin[1] - 3.0 * cell, origin[2]];
    let plane = Collider { friction: 0.5, ..Collider::plane(point, [0.0, 1.0, 0.0]) };
    if ground { simulation.collider(plane).build() } else { simulation.build() }
}

/// Returns the positions of the body relative to `origin`, in cells.
fn in_cells(simulation: &Simulation, origin: [f64; 3]) -> Vec<Point3<f64>> {
    let body = simulation.body(0);
    let cell = body.lattice().cell_size();
    body.positions().iter().map(|p| Point3::from((p.coords - Vector3::from(origin)) / cell)).collect()
}

/// Compares the final positions of the body with its final positions in a scene with cells of edge 1 at the
/// origin.
fn compare(matter: Matter, cell: f64, origin: [f64; 3], ground: bool) -> Result<Figures, Error> {
    let mut unit = falling_scene(matter, 1.0, [0.0; 3], ground)?;
    Ok(measure(falling_scene(matter, cell, origin, ground)?, System::Driven, |trial| {
        trial.run(600, 20);
        unit.steps(600);
        trial.place(&in_cells(&unit, [0.0; 3]), &in_cells(&trial.simulation, origin));
    }))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let sizes = [("1 mm", 1e-3), ("10 km", 1e4), ("1e-12", 1e-12), ("1e11", 1e11)];
    let far = [1e7, -1e7, 1e7];
    let mut cases = Vec::new();
    for matter in Matter::wide(2.0) {
        for (name, cell) in sizes {
            let expected = "falls on the ground like a body with cells of edge 1";
            let run = move || compare(matter, cell, [0.0; 3], true);
            let case = Case::new(matter.named(format!("cells of {name}")), expected, run);
            cases.push(case.bound(Measure::Place, 1e-9));
        }
        for (name, cell, limit) in [("1 m", 1.0, 1e-6), ("1 mm", 1e-3, 1e-4)] {
            let name = format!("10^7 units from the origin, cells of {name}");
            let expected = "falls as at the origin, up to the rounding of its initial positions";
            let free = move || compare(matter, cell, far, false);
            let free = Case::new(matter.named(&name), expected, free);
            cases.push(free.bound(Measure::Place, limit));
            let expected =
                "falls on the ground as at the origin, except that tumbling amplifies the rounding";
            let dropped = move || compare(matter, cell, far, true);
            let dropped = Case::new(matter.named(format!("{name}, dropped")), expected, dropped);
            cases.push(dropped.bound(Measure::Place, 0.1));
        }
    }
    cases
}
