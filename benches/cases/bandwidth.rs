//! Memory bandwidth: copy and triad over arrays much larger than the caches (McCalpin 1995, STREAM).

use std::time::Duration;

use supple_benches::Target;

use crate::measure::{Bench, Sampling, timed};

/// Length of each of the three arrays, which have 128 MiB each.
const LENGTH: usize = 32 << 20;

/// Bytes read and written per iteration, as STREAM counts them: without write-allocate reads.
const COPIED: usize = 2 * LENGTH * size_of::<f32>();
const TRIAD: usize = 3 * LENGTH * size_of::<f32>();

/// Bandwidth in bytes per second, the better of copy and triad.
pub(crate) struct Bandwidth {
    one_thread: f64,
    two_threads: f64,
}

impl Bandwidth {
    /// Returns the bandwidth with one or two threads.
    pub(crate) fn of(&self, threads: usize) -> f64 {
        if threads == 1 { self.one_thread } else { self.two_threads }
    }
}

struct Arrays {
    a: Vec<f32>,
    b: Vec<f32>,
    c: Vec<f32>,
}

pub(crate) fn bench(bench: &mut Bench) -> Option<Bandwidth> {
    bench.part("memory bandwidth, arrays of 128 MiB");
    let mut best = [0.0; 2];
    for threads in [1, 2] {
        let arrays = || Arrays { a: vec![1.0; LENGTH], b: vec![2.0; LENGTH], c: vec![3.0; LENGTH] };
        let samples = bench.measure(
            ["bandwidth", &format!("threads={threads}")],
            Sampling::Few,
            arrays,
            |arrays, n| [arrays.each(threads, n, copy), arrays.each(threads, n, triad)],
        )?;
        let rates = [COPIED as f64 / samples.seconds(0), TRIAD as f64 / samples.seconds(1)];
        best[threads - 1] = rates[0].max(rates[1]);
        let none: Option<Target> = None;
        bench.row(
            &format!("the better of copy and triad, threads: {threads}"),
            (best[threads - 1] / 1e9, "GB/s"),
            none,
            format!("copy {:.1}, triad {:.1}", rates[0] / 1e9, rates[1] / 1e9),
        );
    }
    Some(Bandwidth { one_thread: best[0], two_threads: best[1] })
}

impl Arrays {
    /// Times `count` passes over the arrays, split among the threads.
    fn each(&mut self, threads: usize, count: u64, pass: fn(&mut [f32], &[f32], &[f32])) -> Duration {
        let part = LENGTH.div_ceil(threads);
        timed(|| {
            for _ in 0..count {
                std::thread::scope(|scope| {
                    let parts = self.a.chunks_mut(part).zip(self.b.chunks(part)).zip(self.c.chunks(part));
                    parts.for_each(|((a, b), c)| drop(scope.spawn(move || pass(a, b, c))));
                });
            }
        })
    }
}

fn copy(a: &mut [f32], b: &[f32], _: &[f32]) {
    a.copy_from_slice(b);
}

fn triad(a: &mut [f32], b: &[f32], c: &[f32]) {
    for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
        *a = b + 3.0 * c;
    }
}
