//! Cases with extreme stiffness, time steps, gravity and density.

use supple::{Collider, Error, Force, ForceDuration, Pin, Simulation, TimeWindow};

use crate::stability::bodies::{Matter, alone, block, layer, of_cells, shake};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};

/// Cells of the bar along x, y and z.
const BAR: [i32; 3] = [12, 4, 4];

/// Gives the vertices of an undamped bar of stiffness 1 random velocities.
fn shaken(matter: Matter) -> Result<Figures, Error> {
    let mut body = of_cells(&block(BAR), matter)?.build()?;
    shake(&mut body, 0.2)?;
    Ok(measure(alone(body)?, System::Isolated, |trial| trial.run(10_000, 250)))
}

/// Spins a bar that is a single region with full region damping.
fn rigid() -> Result<Figures, Error> {
    let body = of_cells(&block(BAR), 12.0)?.region_damping(1.0).spin([0.0, 3.0, 6.0]);
    Ok(measure(alone(body.build()?)?, System::Isolated, |trial| trial.run(10_000, 250)))
}

/// Creates a pin at one end of the bar.
fn end_pin() -> Pin {
    Pin { goal: None, selection: layer(BAR, 0), window: TimeWindow::default() }
}

/// Lets a bar hang from one end, in steps of `dt` seconds. Gravity is along the bar.
fn hung(matter: Matter, dt: f64) -> Result<Figures, Error> {
    let body = of_cells(&block(BAR), matter)?.region_damping(0.1).pin(end_pin()).build()?;
    let simulation =
        Simulation::builder().sleep(false).body(body).gravity([9.81, 0.0, 0.0]).dt(dt).threads(1).build()?;
    Ok(measure(simulation, System::Driven, |trial| trial.run(10_000, 100)))
}

/// Drops a block on the ground under gravity `g`, in scene units per s².
fn dropped(matter: Matter, g: f64) -> Result<Figures, Error> {
    let body = of_cells(&block([6; 3]), matter)?.region_damping(0.1).build()?;
    let ground = Collider { friction: 0.5, ..Collider::plane([0.0, -2.0, 0.0], [0.0, 1.0, 0.0]) };
    let simulation =
        Simulation::builder().sleep(false).body(body).collider(ground).gravity([0.0, -g, 0.0]).threads(1);
    Ok(measure(simulation.build()?, System::Driven, |trial| {
        trial.run(3_000, 50);
        trial.depth(|p| -2.0 - p.y);
    }))
}

/// Simulates two hanging bars with random velocities in one scene. They are equal except for their densities.
fn densities(matter: Matter, ratio: f64) -> Result<Figures, Error> {
    let bar = |density: f64| {
        let body = of_cells(&block(BAR), matter)?.density(density).region_damping(0.05).pin(end_pin());
        let mut body = body.build()?;
        shake(&mut body, 0.2)?;
        // A sideways force equal to the bar's weight.
        let weight = body.masses().iter().sum::<f64>() * 9.81;
        let push = Force { duration: ForceDuration::Step, ..Force::from([0.0, 0.0, weight]) };
        body.apply_force(push, &layer(BAR, 12))?;
        Ok::<_, Error>(body)
    };
    // Both bars are in the same place.
    let empty = Simulation::builder().sleep(false).contact(false).threads(1);
    let simulation = empty.body(bar(1e-3)?).body(bar(1e-3 * ratio)?).build()?;
    Ok(measure(simulation, System::Driven, |trial| {
        trial.run(3_000, 50);
        let [light, heavy] = [0, 1].map(|body| trial.simulation.body(body).positions());
        trial.place(&light, &heavy);
    }))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for matter in [0.5, 1.0, 2.0, 4.0, 8.0, 12.0].map(Matter::from).into_iter().chain(Matter::VARIED) {
        let expected = "oscillates without end, keeps its momenta and gains no energy, from soft to rigid";
        let case = Case::new(format!("stiffness 1, {matter}, shaken"), expected, move || shaken(matter));
        cases.push(case.bound(Measure::EnergyGain, matter.gain()).keeps_momenta());
    }
    let expected = "spins like a rigid body: one region, fully damped";
    cases.push(
        Case::new("rigid limit, spinning", expected, rigid)
            .bound(Measure::EnergyGain, 1e-3)
            .bound(Measure::Angular, 1e-6)
            .bound(Measure::Shape, 0.1),
    );
    // The bar of 12 cells stretches to 93 cells in steps of 1 s, so its rest state is less accurate.
    for (dt, limit) in [(1e-6, 1e-4), (1e-4, 1e-4), (1e-2, 1e-4), (1.0, 1e-3)] {
        let expected = "hangs from its end and comes to rest";
        for matter in Matter::wide(3.0) {
            let name = matter.named(format!("time step {dt} s, hung"));
            let case = Case::new(name, expected, move || hung(matter, dt));
            cases.push(case.bound(Measure::FinalSpeed, limit).suite(matter.suite()));
        }
    }
    for g in [9.81, 9_810.0] {
        let expected = "falls on the ground and comes to rest";
        for matter in Matter::wide(2.0) {
            let name = matter.named(format!("gravity {g}, dropped"));
            let case = Case::new(name, expected, move || dropped(matter, g));
            let case = case.bound(Measure::FinalSpeed, 1e-2).bound(Measure::Depth, 0.05);
            cases.push(case.suite(matter.suite()));
        }
    }
    let expected = "both bodies move alike: the density cancels because all forces are proportional to mass";
    for matter in Matter::wide(2.0) {
        let case = Case::new(matter.named("density ratio 1e6"), expected, move || densities(matter, 1e6));
        cases.push(case.bound(Measure::Place, 1e-5));
    }
    cases
}
