//! One step of a block, and beside it the goals of the naive reference.
//!
//! Throughput is in lattice vertices: 1,000 / (Melem/s) is ns per lattice vertex.

#![allow(missing_docs, reason = "the macros of criterion make public items")]

use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use supple::Body;
use supple::reference::{self, Regions};
use supple_benches::{block, deform, simulation};

/// Lattice vertices along x, y, z: 1,000 and 97,336 of them.
const SIZES: [[i32; 3]; 2] = [[10, 10, 10], [46, 46, 46]];

fn step(criterion: &mut Criterion) {
    for size in SIZES {
        let lattice = block(size);
        let mut group = criterion.benchmark_group(format!("step/{}", lattice.len()));
        group.throughput(Throughput::Elements(lattice.len() as u64));
        for half_width in [1, 3] {
            for threads in [1, 2] {
                let name = BenchmarkId::new(format!("w={half_width}"), format!("threads={threads}"));
                let mut body = Body::from_lattice(lattice.clone()).half_width(half_width).build().unwrap();
                deform(&mut body);
                let mut simulation = simulation(body, threads);
                // Entering a pool of threads has a price: once for all steps, as in a run.
                group.bench_function(name, |bencher| {
                    bencher.iter_custom(|steps| {
                        let start = Instant::now();
                        simulation.steps(steps);
                        start.elapsed()
                    });
                });
            }
        }
    }
}

fn naive(criterion: &mut Criterion) {
    let lattice = block(SIZES[0]);
    let mut body = Body::from_lattice(lattice.clone()).build().unwrap();
    deform(&mut body);
    let positions: Vec<_> = body.positions().iter().map(|p| p.coords).collect();
    let mut group = criterion.benchmark_group(format!("naive goals/{}", lattice.len()));
    group.throughput(Throughput::Elements(lattice.len() as u64));
    for half_width in [1, 3] {
        group.bench_function(format!("w={half_width}"), |bencher| {
            bencher.iter(|| reference::goals(&lattice, &positions, half_width, Regions::Staircase));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = step, naive
}
criterion_main!(benches);
