//! Stretches a bust by its crown, and prints the volume before and after the volume correction.
//!
//!     cargo run --release -p supple-io --example 02_stretch

#![allow(clippy::print_stdout, reason = "a table for the reader")]

use std::error::Error;
use std::path::Path;

use supple::{Body, Handle, Key, Pin, Selection, Simulation, Substeps, TimeWindow};

fn main() -> Result<(), Box<dyn Error>> {
    let bust = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes/bust.obj");
    let mesh = supple_io::obj::read(bust)?;
    let (low, high) = mesh.bounds();
    let height = high.y - low.y;

    // A plane selects the side that its normal points to.
    let base = Selection::Plane { point: [0.0, low.y + 0.05 * height, 0.0], normal: [0.0, -1.0, 0.0] };
    let crown = Selection::Plane { point: [0.0, high.y - 0.1 * height, 0.0], normal: [0.0, 1.0, 0.0] };
    let up = Key { time: 1.0, translate: [0.0, 0.35 * height, 0.0], ..Key::default() };

    let body = Body::builder(mesh)
        .lattice_vertices(1000)
        .pin(Pin { goal: None, selection: base, window: TimeWindow::default() })
        .handle(Handle {
            goal: None,
            selection: crown,
            motion: vec![Key::default(), up].into(),
            window: TimeWindow::default(),
        })
        .build()?;
    let builder = Simulation::builder().body(body).gravity([0.0; 3]);
    let mut simulation = builder.fps(30.0).substeps(Substeps::Auto).build()?;

    println!("  time   volume before correction      after       lambda");
    for _ in 0..=5 {
        // Evaluating the volume does not change the simulation.
        let report = simulation.body(0).volume_report();
        let (before, after) = (report.before / report.rest, report.after / report.rest);
        println!("{:>5.2}s {before:>26.4} {after:>10.6} {:>12.4}", simulation.time(), report.lambda);
        simulation.advance(6);
    }
    Ok(())
}
