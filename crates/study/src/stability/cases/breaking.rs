//! Cases with bodies that break: torn apart, dropped and spun.

use supple::{Body, BreakLimit, Collider, Error, FractureOptions, Handle, Key, Simulation, TimeWindow};

use crate::stability::bodies::{alone, block, layer, of_cells};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, Trial, measure};

/// Cells of the bar along x, y and z.
const BAR: [i32; 3] = [16, 4, 4];

/// Creates the fracture of a body that breaks at a strain, with up to `cracks` cracks at a time.
fn brittle(strain: f64, cracks: usize) -> FractureOptions {
    FractureOptions { cracks, ..FractureOptions::new(BreakLimit::Strain(strain)) }
}

/// Returns the greatest number of pieces of a body.
fn pieces(trial: &Trial<'_>) -> usize {
    trial.simulation.bodies().iter().map(Body::pieces).max().unwrap_or_default()
}

/// Moves the ends of a bar apart by its length, and turns one of them, within a second; the pieces at the ends then
/// hang on them.
fn torn(fracture: FractureOptions, half_width: usize, degrees: f64) -> Result<Figures, Error> {
    let end = |x: i32, translate: f64, angle: f64| {
        let key = |time, share: f64| Key {
            time,
            translate: [share * translate, 0.0, 0.0],
            rotate: [share * angle, 0.0, 0.0],
        };
        let motion = vec![key(0.0, 0.0), key(1.0, 1.0)].into();
        Handle { selection: layer(BAR, x), motion, window: TimeWindow::default() }
    };
    let body = of_cells(&block(BAR), half_width)?.region_damping(0.1).fracture(fracture);
    let body = body.handle(end(0, -8.0, 0.0)).handle(end(BAR[0], 8.0, degrees)).build()?;
    Ok(measure(alone(body)?, System::Driven, |trial| {
        trial.run(1_500, 10);
        assert!(pieces(trial) > 1, "the bar did not break");
    }))
}

/// Lets a brittle block hit the ground at `speed` cells per step.
fn dropped(fracture: FractureOptions, half_width: usize, speed: f64) -> Result<Figures, Error> {
    let body = of_cells(&block([8; 3]), half_width)?.damping_ratio(0.2).fracture(fracture);
    let body = body.rotate([30.0, 0.0, 40.0]).translate([0.0, 8.0, 0.0]).velocity([0.0, -60.0 * speed, 0.0]);
    let ground = Collider { friction: 0.5, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let simulation = Simulation::builder().body(body.build()?).collider(ground).threads(1).build()?;
    Ok(measure(simulation, System::Driven, |trial| {
        trial.run(1_200, 10);
        assert!(pieces(trial) > 1, "the block did not break");
    }))
}

/// Spins a bar about an axis across it so fast that it breaks, and measures whether the pieces keep the momenta.
fn spun(fracture: FractureOptions, half_width: usize) -> Result<Figures, Error> {
    let body = of_cells(&block(BAR), half_width)?.fracture(fracture).spin([0.0, 0.0, 12.0]).build()?;
    Ok(measure(alone(body)?, System::Isolated, |trial| {
        trial.run(600, 10);
        assert!(pieces(trial) > 1, "the bar did not break");
    }))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for half_width in [1, 2] {
        for (name, degrees) in [("pulled", 0.0), ("pulled and twisted", 90.0)] {
            let name = format!("half-width {half_width}, {name} apart by a length");
            let expected = "breaks into pieces that keep their volumes";
            let case = Case::new(name, expected, move || torn(brittle(0.2, 1), half_width, degrees));
            cases.push(case.bound(Measure::Volume, 1e-6).bound(Measure::LargestSpeed, 5.0));
        }
        let name = format!("half-width {half_width}, thrown on the ground");
        let expected = "breaks into pieces that keep their volumes";
        // Wider regions break at higher speeds.
        let speed = half_width as f64;
        let case = Case::new(name, expected, move || dropped(brittle(0.02, 8), half_width, speed));
        cases.push(case.bound(Measure::Volume, 1e-6).bound(Measure::LargestSpeed, 3.0 * speed));
        for cracks in [1, 8] {
            let name = format!("half-width {half_width}, spun, cracks {cracks}");
            let expected = "flies apart, and the pieces keep the momenta and their volumes";
            let case = Case::new(name, expected, move || spun(brittle(0.02, cracks), half_width));
            cases.push(case.bound(Measure::Volume, 1e-6).keeps_momenta());
        }
    }
    cases
}
