//! Cases with the largest accepted numbers. No result may be NaN.

use nalgebra::Vector3;
use supple::{BodyBuilder, Collider, Error, ForceDuration, Simulation, SimulationBuilder};

use crate::stability::bodies::{Matter, block, deform, of_cells, of_sized_cells};
use crate::stability::case::{Case, Figures, Measure};
use crate::stability::trial::{System, measure};

/// Creates a builder for a bar of 5 x 3 x 3 cells.
fn bar(matter: Matter) -> Result<BodyBuilder, Error> {
    of_cells(&block([5, 3, 3]), matter)
}

/// Runs a simulation for 300 steps.
fn run(simulation: SimulationBuilder) -> Result<Figures, Error> {
    Ok(measure(simulation.threads(1).build()?, System::Driven, |trial| trial.run(300, 10)))
}

/// Lets a bar fall in steps of 10^6 s, with or without a ground.
fn strong_gravity(matter: Matter, ground: bool) -> Result<Figures, Error> {
    let simulation = Simulation::builder()
        .sleep(false)
        .body(bar(matter)?.region_damping(0.1).build()?)
        .gravity([1e12, -1e12, 0.0])
        .dt(1e6);
    let plane = Collider { friction: 0.5, ..Collider::plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]) };
    run(if ground { simulation.collider(plane) } else { simulation })
}

/// Accelerates vertices by 10^15 cells/s², alternately in opposite directions.
fn strong_forces(matter: Matter) -> Result<Figures, Error> {
    let mut body = bar(matter)?.region_damping(0.1).build()?;
    let magnitudes: Vec<_> = body.masses().iter().map(|m| m * 1e15).collect();
    let alternating =
        |(vertex, force): (usize, &f64)| (vertex as u32, [if vertex % 2 == 0 { *force } else { -force }; 3]);
    let forces: Vec<_> = magnitudes.iter().enumerate().map(alternating).collect();
    body.apply_forces_for(&forces, ForceDuration::Step)?;
    run(Simulation::builder().sleep(false).body(body).gravity([0.0; 3]))
}

/// Scales a bar by 10^14 and moves its vertices at 10^15 cells/s, alternately in opposite directions.
fn far_apart(matter: Matter, dt: f64) -> Result<Figures, Error> {
    let mut body = bar(matter)?.build()?;
    deform(&mut body, |x| x.iter().map(|x| x * 1e14).collect())?;
    let velocities: Vec<_> = (0..body.lattice().len())
        .map(|vertex| Vector3::repeat(if vertex % 2 == 0 { 1e15 } else { -1e15 }))
        .collect();
    body.set_velocities(&velocities)?;
    run(Simulation::builder().sleep(false).body(body).gravity([0.0; 3]).dt(dt))
}

/// Spins a bar at 10^12 rad/s around each axis.
fn fast_spin(matter: Matter) -> Result<Figures, Error> {
    run(Simulation::builder()
        .sleep(false)
        .body(bar(matter)?.spin([1e12, -1e12, 1e12]).build()?)
        .gravity([0.0; 3]))
}

/// Lets a bar of cells of edge 10^-30 fall in steps of 10^-12 s.
fn tiny_cells(matter: Matter) -> Result<Figures, Error> {
    let body = of_sized_cells(&block([5, 3, 3]), 1e-30, matter)?.region_damping(0.1).build()?;
    run(Simulation::builder().sleep(false).body(body).gravity([0.0, -1e-3, 0.0]).dt(1e-12))
}

/// Returns the cases of this family.
pub(super) fn cases() -> Vec<Case> {
    type Run = fn(Matter) -> Result<Figures, Error>;
    let all: [(&str, Run, f64); 8] = [
        ("gravity of 1e12, steps of 1e6 s", |matter| strong_gravity(matter, false), 1e30),
        ("gravity of 1e12, steps of 1e6 s, a ground", |matter| strong_gravity(matter, true), 1e30),
        ("forces that accelerate by 1e15 cells/s^2", strong_forces, 1e13),
        ("1e14 times its size, speeds of 1e15 cells/s", |matter| far_apart(matter, 1.0 / 60.0), 1e17),
        ("the same in steps of 1e6 s", |matter| far_apart(matter, 1e6), 1e23),
        ("the same in steps of 1e-12 s", |matter| far_apart(matter, 1e-12), 1e17),
        ("spin of 1e12 rad/s", fast_spin, 1e13),
        ("cells of 1e-30, steps of 1e-12 s", tiny_cells, 1e6),
    ];
    let expected = "remains finite, and no faster than the driving motion";
    let case = |matter: Matter, (name, run, speed): (&str, Run, f64)| {
        let case = Case::new(matter.named(name), expected, move || run(matter));
        case.bound(Measure::LargestSpeed, speed).suite(matter.suite())
    };
    Matter::beside(2.0).flat_map(|matter| all.map(|row| case(matter, row))).collect()
}
