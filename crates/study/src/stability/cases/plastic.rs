//! Cases with plastic bodies: pressed hard, dropped, spun and shaken.

use supple::{Body, BodyBuilder, Collider, Error, Plasticity, RegionDamping, Simulation};

use crate::stability::bodies::{Matter, alone, block, of_cells, plate, shake};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};

/// Flows as fast as possible, up to the greatest plastic shapes that are possible.
const FAST: Plasticity = Plasticity { yield_strain: 0.05, creep: 1e6, max: 2.0 };

/// Flows at every strain, as fast as possible.
const FLUID: Plasticity = Plasticity { yield_strain: 1e-6, creep: 1e6, max: 1.0 };

/// Creates a builder of a plastic block.
fn plastic(matter: Matter, plastic: Plasticity) -> Result<BodyBuilder, Error> {
    Ok(of_cells(&block([6; 3]), matter)?.plastic(plastic))
}

/// Compresses a block between two plates to a tenth of a cell within 1 s, and releases it 1 s later.
fn pressed(matter: Matter, parameters: Plasticity) -> Result<Figures, Error> {
    let body = plastic(matter, parameters)?.region_damping(0.1).damping_rate(5.0).build()?;
    let simulation = Simulation::builder().sleep(false).body(body).gravity([0.0; 3]).threads(1);
    let simulation = simulation.collider(plate(-0.5, 1.0, 3.45)).collider(plate(6.5, -1.0, -3.45));
    Ok(measure(simulation.build()?, System::Driven, |trial| trial.run(3_000, 20)))
}

/// Drops a block by 30 cells on the ground.
fn dropped(matter: Matter, parameters: Plasticity) -> Result<Figures, Error> {
    let body =
        plastic(matter, parameters)?.damping_ratio(0.2).rotate([20.0, 30.0, 0.0]).translate([0.0, 30.0, 0.0]);
    let ground = Collider { friction: 0.5, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let simulation = Simulation::builder().body(body.build()?).collider(ground).threads(1);
    Ok(measure(simulation.fps(60.0).substeps(supple::Substeps::Fixed(4)).build()?, System::Driven, |trial| {
        trial.run_to_sleep(1_200, 60);
    }))
}

/// Lets a free body move, and measures whether it keeps its momenta.
fn free(body: Body) -> Result<Figures, Error> {
    Ok(measure(alone(body)?, System::Isolated, |trial| trial.run(3_000, 100)))
}

/// Spins a block by half a radian per step, which strains it far beyond its yield strain.
fn spun(matter: Matter, parameters: Plasticity) -> Result<Figures, Error> {
    free(plastic(matter, parameters)?.region_damping(0.1).spin([10.0, 0.0, 30.0]).build()?)
}

/// Gives the vertices random velocities of up to half a cell per step.
fn shaken(matter: Matter, parameters: Plasticity, region_damping: f64) -> Result<Figures, Error> {
    let mut body = plastic(matter, parameters)?.build()?;
    body.set_region_damping(RegionDamping::PerStep(region_damping))?;
    shake(&mut body, 0.5)?;
    free(body)
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let kinds =
        [("default plasticity", Plasticity::default()), ("fast plasticity", FAST), ("nearly fluid", FLUID)];
    for (matter, (name, parameters)) in
        Matter::beside(1.0).flat_map(|matter| kinds.map(|kind| (matter, kind)))
    {
        let expected = "comes to rest in another shape";
        let case = Case::new(matter.named(format!("{name}, pressed flat and let go")), expected, move || {
            pressed(matter, parameters)
        });
        cases.push(case.bound(Measure::FinalSpeed, 1e-4).bound(Measure::LargestSpeed, 1.0));
        let case = if parameters == FLUID {
            let expected = "falls on the ground and spreads";
            Case::new(matter.named(format!("{name}, dropped")), expected, move || dropped(matter, parameters))
                .bound(Measure::FinalSpeed, 1e-2)
        } else {
            // The run takes 20 s: asleep for its last two seconds.
            let expected = "falls on the ground, comes to rest, falls asleep within 18 s, and stays asleep";
            Case::new(matter.named(format!("{name}, dropped")), expected, move || dropped(matter, parameters))
                .bound(Measure::Awake, 18.0)
                .bound(Measure::FinalSpeed, 0.0)
        };
        cases.push(case);
        let case = Case::new(matter.named(format!("{name}, spun")), "keeps its momenta", move || {
            spun(matter, parameters)
        });
        cases.push(case.keeps_momenta());
        for region_damping in [0.0, 0.1] {
            let expected = "keeps its momenta and gains no energy";
            let case = Case::new(
                matter.named(format!("{name}, region damping {region_damping}, shaken")),
                expected,
                move || shaken(matter, parameters, region_damping),
            );
            // The bound of undamped bodies: see the cases of stiffnesses and time steps.
            cases.push(case.bound(Measure::EnergyGain, matter.gain()).keeps_momenta());
        }
    }
    cases
}
