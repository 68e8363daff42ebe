//! The program of the README.
//!
//!     cargo run --release -p supple-io --example 00_readme

use supple::{Body, Collider, Simulation, Substeps};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = supple_io::obj::read("examples/scenes/bust.obj")?;
    let body = Body::builder(mesh).lattice_vertices(1000).build()?;
    let ground = Collider::plane([0.0, 5.0, 0.0], [0.0, 1.0, 0.0]);
    let builder = Simulation::builder().body(body).collider(ground);
    let mut simulation = builder.fps(30.0).substeps(Substeps::Auto).build()?;
    simulation.advance(60);
    let surface = simulation.body(0).surface(); // positions and normals, in input order
    assert!(surface.positions.iter().all(|p| p.y > 4.9));
    Ok(())
}
