//! What a frame of the bust costs: its steps, the volume correction, the mesh update.

#![allow(missing_docs, reason = "the macros of criterion make public items")]

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use supple::volume::Preservation;
use supple_benches::{bust, deform, simulation};

/// Steps that make a frame.
const SUBSTEPS: u64 = 4;

fn frame(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("bust");
    for (name, volume) in [("off", Preservation::Off), ("mesh", Preservation::Auto)] {
        let mut body = bust().volume(volume).build().unwrap();
        deform(&mut body);
        let mut points = vec![[0.0; 3]; body.mesh().map_or(0, |mesh| mesh.vertices().len())];
        let mut simulation = simulation(body, 1);
        group.bench_function(format!("look/volume={name}"), |bencher| {
            bencher.iter(|| simulation.body(0).surface_into(&mut points, None));
        });
        group.bench_function(format!("frame/volume={name}"), |bencher| {
            bencher.iter(|| {
                simulation.steps(SUBSTEPS);
                simulation.body(0).surface_into(&mut points, None)
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = frame
}
criterion_main!(benches);
