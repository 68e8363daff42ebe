//! Simulates a lattice without a mesh: cells, goal positions, momentum.
//!
//!     cargo run --release -p supple-io --example 03_bare_lattice

#![allow(clippy::print_stdout, reason = "figures for the reader")]

use std::error::Error;

use nalgebra::{Point3, Vector3};
use supple::{Body, Lattice, Simulation, Substeps};

fn main() -> Result<(), Box<dyn Error>> {
    // A horseshoe, one cell thick. Its tips are close to each other, but not linked.
    let cells: Vec<[i32; 3]> = (0..7)
        .flat_map(|y| (0..5).map(move |x| [x, y, 0]))
        .filter(|&[x, y, _]| y == 0 || x == 0 || x == 4)
        .collect();
    let lattice = Lattice::from_cells(&cells, 0.1, Point3::origin(), true)?;
    println!("{} cells, {} lattice vertices", lattice.cells().len(), lattice.len());

    // Lift one tip. The goals are the positions towards which shape matching moves the vertices.
    let mut body = Body::from_lattice(lattice).build()?;
    let mut positions = body.positions();
    for (position, &[x, y, _]) in positions.iter_mut().zip(body.lattice().indices()) {
        if x >= 4 && y >= 5 {
            position.z += 0.15;
        }
    }
    body.set_positions(&positions)?;
    let goals = body.goals();
    let distances = goals.iter().zip(&positions).map(|(goal, position)| (goal - position).norm());
    println!("greatest distance of a vertex from its goal: {:.4}", distances.fold(0.0, f64::max));

    // Shape matching conserves momentum: without external forces the center of mass stays in place.
    let builder = Simulation::builder().body(body).gravity([0.0; 3]);
    let mut simulation = builder.fps(60.0).substeps(Substeps::Auto).build()?;
    let before = center(&simulation.body(0));
    simulation.advance(600);
    let displacement = (center(&simulation.body(0)) - before).norm();
    println!("center of mass after {} steps: moved by {displacement:.1e}", simulation.step_count());
    Ok(())
}

/// Returns the center of mass.
fn center(body: &Body) -> Vector3<f64> {
    let masses = body.masses();
    let sum: Vector3<f64> = body.positions().iter().zip(&masses).map(|(p, mass)| p.coords * *mass).sum();
    sum / masses.iter().sum::<f64>()
}
