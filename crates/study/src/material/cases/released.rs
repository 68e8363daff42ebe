//! Cases with a box of 1 x 1 x 3 that is stretched to 1.5 times its length in 1 s, let go half a unit above the ground,
//! and dropped.

use nalgebra::Vector3;
use supple::{Collider, Handle, Key, Pin, Selection, TimeWindow};

use crate::material::bodies::{FPS, GRAVITY, automatic, bar, bar_vertices, greatest_speed};
use crate::material::case::{Case, Measured, Outcome, Quantity, Target};
use crate::shape::shape_distance;

/// Length of the box.
const LENGTH: i32 = 3;

/// Distance of the lower end from the ground.
const DROP: f64 = 0.5;

/// Young's modulus.
const MODULUS: f64 = 1e6;

/// Stretches a box, lets it go, and measures its shape after 3 s and its speed after 3, 4 and 6 s.
fn released(cells: i32) -> Outcome {
    let length = f64::from(LENGTH);
    let half_cell = 0.5 / f64::from(cells);
    let window = TimeWindow { start: 0.0, end: 1.0 };
    let end = |z: f64, side: f64| Selection::Plane { point: [0.0, 0.0, z], normal: [0.0, 0.0, side] };
    let lower = Pin { goal: None, selection: end(DROP + half_cell, -1.0), window };
    let keys = [(0.0, 0.0), (1.0, 0.5 * length)].map(|(time, z)| Key {
        time,
        translate: [0.0, 0.0, z],
        rotate: [0.0; 3],
    });
    let upper = Handle {
        goal: None,
        selection: end(DROP + length - half_cell, 1.0),
        motion: keys.to_vec().into(),
        window,
    };
    let body = bar(cells, LENGTH)?.youngs_modulus(MODULUS).translate([0.0, 0.0, DROP]);
    let body = body.pin(lower).handle(upper).build()?;
    let rest: Vec<Vector3<f64>> = body.positions().iter().map(|p| p.coords).collect();
    let masses = body.masses();
    let ground = Collider { friction: 0.5, ..Collider::plane([0.0; 3], [0.0, 0.0, 1.0]) };
    let mut simulation = automatic(body, [0.0, 0.0, -GRAVITY]).collider(ground).build()?;
    let mut after = |seconds: f64| {
        while simulation.time() < 1.0 + seconds - 0.5 / FPS {
            simulation.advance(1);
        }
        let body = &simulation.bodies()[0];
        let now: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
        (shape_distance(&masses, &rest, &now) / length, greatest_speed(body))
    };
    let [(shape, early), (_, middle), (_, late)] = [3.0, 4.0, 6.0].map(&mut after);
    Ok([shape, early, middle, late].map(Measured::from).into())
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let quantities = || {
        [("shape, rms/height", 0.01), ("speed at 3 s, m/s", 0.1), ("at 4 s", 0.01), ("at 6 s", 0.001)]
            .map(|(name, most)| Quantity::new(name, Target::at_most(most)))
    };
    let case = |cells| {
        let vertices = bar_vertices(cells, LENGTH);
        Case::new(format!("{vertices} vertices"), quantities(), move || released(cells)).of_vertices(vertices)
    };
    [6, 14, 31].map(case).into()
}
