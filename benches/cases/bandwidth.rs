//! Measures the memory bandwidth with the STREAM kernels copy, a = b, and triad, a = b + 3 c (McCalpin 1995),
//! over arrays much larger than the caches.

use std::time::Duration;

use supple_benches::Target;

use crate::measure::{Bench, Sampling, timed};

/// Number of elements of each of the three arrays. One array has 128 MiB.
const LENGTH: usize = 32 << 20;

/// Bytes that the copy kernel reads and writes in one run over the arrays. As in STREAM, the reads that
/// write-allocate causes are not counted.
const COPY_BYTES: usize = 2 * LENGTH * size_of::<f32>();
/// Bytes that the triad kernel reads and writes in one run over the arrays, counted in the same way.
const TRIAD_BYTES: usize = 3 * LENGTH * size_of::<f32>();

/// Bandwidth in bytes per second: the higher of the bandwidths of copy and triad.
pub(crate) struct Bandwidth {
    one_thread: f64,
    two_threads: f64,
}

impl Bandwidth {
    /// Returns the bandwidth with `threads` threads, 1 or 2.
    pub(crate) fn with_threads(&self, threads: usize) -> f64 {
        if threads == 1 { self.one_thread } else { self.two_threads }
    }
}

/// The operands of copy and triad; `a` is written.
struct Arrays {
    a: Vec<f32>,
    b: Vec<f32>,
    c: Vec<f32>,
}

/// Measures copy and triad with one and two threads. Returns `None` if the filter excludes one of these
/// cases.
pub(crate) fn bench(bench: &mut Bench) -> Option<Bandwidth> {
    bench.section("memory bandwidth, arrays of 128 MiB");
    let mut best = [0.0; 2];
    for threads in [1, 2] {
        let arrays = || Arrays { a: vec![1.0; LENGTH], b: vec![2.0; LENGTH], c: vec![3.0; LENGTH] };
        let samples = bench.measure(
            ["bandwidth", &format!("threads={threads}")],
            Sampling::Few,
            arrays,
            |arrays, n| [arrays.time(threads, n, copy), arrays.time(threads, n, triad)],
        )?;
        let rates = [COPY_BYTES as f64 / samples.seconds(0), TRIAD_BYTES as f64 / samples.seconds(1)];
        best[threads - 1] = rates[0].max(rates[1]);
        let no_target: Option<Target> = None;
        bench.row(
            &format!("the better of copy and triad, threads: {threads}"),
            (best[threads - 1] / 1e9, "GB/s"),
            no_target,
            format!("copy {:.1}, triad {:.1}", rates[0] / 1e9, rates[1] / 1e9),
        );
    }
    Some(Bandwidth { one_thread: best[0], two_threads: best[1] })
}

impl Arrays {
    /// Applies `kernel` to the whole arrays `count` times and returns the total time. Each time, every thread
    /// processes one contiguous chunk of the arrays.
    fn time(&mut self, threads: usize, count: u64, kernel: fn(&mut [f32], &[f32], &[f32])) -> Duration {
        let length = LENGTH.div_ceil(threads);
        timed(|| {
            for _ in 0..count {
                std::thread::scope(|scope| {
                    let (b, c) = (self.b.chunks(length), self.c.chunks(length));
                    let chunks = self.a.chunks_mut(length).zip(b).zip(c);
                    chunks.for_each(|((a, b), c)| drop(scope.spawn(move || kernel(a, b, c))));
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
