//! Runs all benchmarks and prints one table of measured values, targets and comparisons.
//!
//! `cargo bench` runs all cases. `cargo bench -- frame` runs the cases with "frame" in their names.
//! `cargo bench -- --test` runs every case once and prints no table.

mod bandwidth;
mod build;
mod contact;
mod files;
mod fracture;
mod frame;
mod measure;
mod memory;
mod naive;
mod plastic;
mod rest;
mod shapes;
mod step;
mod volume;

fn main() {
    let mut bench = measure::Bench::from_arguments();
    let bandwidth = bandwidth::bench(&mut bench);
    step::bench(&mut bench, bandwidth.as_ref());
    rest::bench(&mut bench);
    plastic::bench(&mut bench);
    fracture::bench(&mut bench);
    naive::bench(&mut bench);
    shapes::bench(&mut bench);
    frame::bench(&mut bench);
    volume::bench(&mut bench);
    contact::bench(&mut bench);
    build::bench(&mut bench);
    files::bench(&mut bench);
    bench.finish();
}
