//! Cases with materials that do not depend on the lattice: presets, Young's moduli, elastic damping, densities.

use nalgebra::Point3;
use supple::{
    Body, BodyBuilder, Collider, Error, Lattice, Material, Preset, Selection, Simulation, Substeps, Zone,
};

use crate::stability::bodies::{block, shake};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};

/// Frames per second.
const FPS: f64 = 60.0;

/// Creates a builder of a block of 1 x 1 x 1 scene units and 6 x 6 x 6 cells of rubber.
fn cube() -> Result<BodyBuilder, Error> {
    Ok(of_material(&block([6; 3]), 1.0 / 6.0)?.preset(Preset::Rubber))
}

/// Creates a builder of a body of cells of edge `cell_size` with the default material.
fn of_material(cells: &[[i32; 3]], cell_size: f64) -> Result<BodyBuilder, Error> {
    let lattice = Lattice::from_cells(cells, cell_size, Point3::origin(), false)?;
    Ok(Body::from_lattice(lattice).material(Material::default()))
}

/// Drops a body by a tenth of a scene unit on the ground, with automatic steps.
fn dropped(body: BodyBuilder, sleep: bool) -> Result<Simulation, Error> {
    let ground = Collider { friction: 0.5, ..Collider::plane([0.0; 3], [0.0, 1.0, 0.0]) };
    let body = body.translate([0.0, 0.1, 0.0]).build()?;
    let simulation = Simulation::builder().body(body).collider(ground).sleep(sleep).threads(1);
    simulation.fps(FPS).substeps(Substeps::Auto).build()
}

/// Drops a block with a preset, which comes to rest and sleeps, and simulates 20 s.
fn asleep(preset: Preset) -> Result<Figures, Error> {
    Ok(measure(dropped(cube()?.preset(preset), true)?, System::Driven, |trial| trial.run_to_sleep(1200, 60)))
}

/// Gives the vertices of a body random velocities of up to 0.2 cells per frame, with automatic steps.
fn shaken(body: BodyBuilder, steps: u64) -> Result<Figures, Error> {
    let mut body = body.build()?;
    shake(&mut body, 0.2)?;
    let simulation = Simulation::builder().body(body).gravity([0.0; 3]).sleep(false).threads(1);
    let simulation = simulation.fps(FPS).substeps(Substeps::Auto).build()?;
    Ok(measure(simulation, System::Isolated, |trial| trial.run(steps, 100)))
}

/// Drops a body with strong elastic damping.
fn dropped_damped(body: BodyBuilder) -> Result<Figures, Error> {
    Ok(measure(dropped(body, false)?, System::Driven, |trial| trial.run(6_000, 50)))
}

/// Drops a block of the given density, and compares its final positions with those of a block of density 1000.
fn of_density(density: f64) -> Result<Figures, Error> {
    let mut usual = dropped(cube()?, false)?;
    Ok(measure(dropped(cube()?.density(density), false)?, System::Driven, |trial| {
        trial.run(6_000, 50);
        usual.steps(6_000);
        let positions = |body: &Body| -> Vec<Point3<f64>> {
            body.positions().iter().map(|p| p / body.lattice().cell_size()).collect()
        };
        trial.place(&positions(&usual.body(0)), &positions(&trial.simulation.body(0)));
    }))
}

/// Gives each lattice vertex a random stiffness factor from 0.01 to 100, evenly distributed by their logarithms.
fn varied(body: BodyBuilder) -> Result<BodyBuilder, Error> {
    let count = body.clone().build()?.lattice().len() as u32;
    let mut random = fastrand::Rng::with_seed(4);
    let zone = |vertex| Zone::new(Selection::Vertices(vec![vertex]), 100_f64.powf(2.0 * random.f64() - 1.0));
    Ok((0..count).map(zone).fold(body, BodyBuilder::zone))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    // The speed of the impact, √(2 g L/10), must fall to the limit of sleep, √(g L)/1000: by a factor of 450. The
    // lowest mode of jelly, of at least π √(E/ρ)/(2 L) = 22 rad/s, decays at a tenth of that, so it takes 2.8 s.
    for preset in [Preset::Rubber, Preset::Jelly] {
        let expected = "falls on the ground, comes to rest, falls asleep within 8 s, and stays asleep";
        let case = Case::new(format!("{}, dropped", preset.name()), expected, move || asleep(preset));
        cases.push(case.bound(Measure::Awake, 8.0).bound(Measure::FinalSpeed, 0.0));
    }
    for exponent in 3..=12 {
        for [ratio, inflate] in [[0.0, 1.0], [0.3, 1.5], [0.45, 0.7]] {
            let expected = "keeps its momenta and gains no energy; at most 1000 steps per frame";
            let run = move || {
                let body = cube()?.youngs_modulus(10.0_f64.powi(exponent));
                shaken(body.poisson_ratio(ratio).inflate(inflate), 5_000)
            };
            let bulk =
                if ratio == 0.0 { String::new() } else { format!("ratio {ratio}, inflate {inflate}, ") };
            let case = Case::new(format!("Young's modulus 1e{exponent}, {bulk}shaken"), expected, run);
            cases.push(case.bound(Measure::EnergyGain, 1e-5).keeps_momenta());
        }
    }
    type Damped = fn(BodyBuilder) -> BodyBuilder;
    let damped: [(&str, Damped); 2] = [
        ("damping ratio 1", |body| body.damping_ratio(1.0)),
        ("damping rate 1e6", |body| body.damping_rate(1e6)),
    ];
    for (name, with_damping) in damped {
        let expected = "returns to its rest shape and keeps its momenta";
        let run = move || shaken(with_damping(cube()?), 2_000);
        let case = Case::new(format!("{name}, shaken"), expected, run);
        // After 2,000 steps the slowest mode has decayed to the rounding of f32. These are the bounds of `starts`.
        let case = case.bound(Measure::Shape, 1e-3).bound(Measure::FinalSpeed, 1e-4);
        cases.push(case.bound(Measure::EnergyGain, 1e-5).keeps_momenta());
        let expected = "falls on the ground and comes to rest";
        let run = move || dropped_damped(with_damping(cube()?));
        let case = Case::new(format!("{name}, dropped"), expected, run);
        // Its weight compresses rubber, E = 300 ρ g L, by L/600 at the top, 0.01 cells. The shape may differ by twice
        // that much.
        cases.push(case.bound(Measure::FinalSpeed, 1e-4).bound(Measure::Shape, 0.02));
    }
    for density in [1e-6, 1e9] {
        let expected =
            "moves as with density 1000: Young's modulus of a preset is proportional to the density";
        let case = Case::new(format!("density {density:e}, dropped"), expected, move || of_density(density));
        cases.push(case.bound(Measure::Place, 1e-5));
    }
    let expected = "keeps its momenta and gains no energy";
    let case = Case::new("random stiffness factors from 0.01 to 100, shaken", expected, || {
        shaken(varied(cube()?)?, 5_000)
    });
    cases.push(case.bound(Measure::EnergyGain, 1e-5).keeps_momenta());
    // A block of which the lower half is a hundred times as stiff or as soft. The soft half is compressed by at most
    // 100 L/1200, 0.5 cells, at the top; the distance is the mean of the body.
    for factor in [0.01, 100.0] {
        let expected = "falls on the ground and comes to rest";
        let case = Case::new(format!("lower half of factor {factor}, dropped"), expected, move || {
            let selection = Selection::Plane { point: [0.0, 0.6, 0.0], normal: [0.0, -1.0, 0.0] };
            dropped_damped(cube()?.damping_ratio(1.0).zone(Zone::new(selection, factor)))
        });
        cases.push(case.bound(Measure::FinalSpeed, 1e-4).bound(Measure::Shape, 0.5));
    }
    let case = Case::new("needle of 1 x 1 x 200 cells, shaken", expected, || {
        shaken(of_material(&block([1, 1, 200]), 0.01)?, 5_000)
    });
    cases.push(case.bound(Measure::EnergyGain, 1e-5).keeps_momenta());
    cases
}
