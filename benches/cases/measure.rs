//! Times cases with criterion and collects the results in a table. The table contains medians, and ratios and
//! differences of variants that are timed alternately.

use std::io::Write;
use std::time::{Duration, Instant};

use criterion::{Criterion, SamplingMode};
use supple::{Simulation, simd_level};
use supple_benches::{Row, Table, Target};

/// Number of samples of a case.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sampling {
    /// 30 samples, for cases of up to some milliseconds.
    Many,
    /// 10 samples, for cases of tens of milliseconds and more.
    Few,
}

impl Sampling {
    fn samples(self) -> usize {
        match self {
            Self::Many => 30,
            Self::Few => 10,
        }
    }
}

/// Seconds per iteration of each of `N` variants, one entry per sample. In each sample, the variants run one
/// after the other.
pub(crate) struct Samples<const N: usize>(Vec<[f64; N]>);

impl<const N: usize> Samples<N> {
    /// Returns the median time of a variant, in seconds.
    pub(crate) fn seconds(&self, variant: usize) -> f64 {
        self.median(|sample| sample[variant])
    }

    /// Returns the median over the samples of the time of `variant` divided by the time of `other`.
    pub(crate) fn ratio(&self, variant: usize, other: usize) -> f64 {
        self.median(|sample| sample[variant] / sample[other])
    }

    /// Returns the median over the samples of the time of `variant` minus the time of `other`, in seconds.
    pub(crate) fn difference(&self, variant: usize, other: usize) -> f64 {
        self.median(|sample| sample[variant] - sample[other])
    }

    /// Returns the median of `value` over the samples.
    fn median(&self, value: impl Fn(&[f64; N]) -> f64) -> f64 {
        let mut values: Vec<f64> = self.0.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
    }
}

/// A benchmark run: criterion and the table of results.
pub(crate) struct Bench {
    criterion: Criterion,
    table: Table,
}

impl Bench {
    /// Creates a benchmark run from the arguments of the program.
    pub(crate) fn from_arguments() -> Self {
        Self {
            criterion: Criterion::default().without_plots().configure_from_args(),
            table: Table::default(),
        }
    }

    /// Measures the case `group/name`. Returns `None` if the filter excludes it.
    ///
    /// `work(state, n)` does `n` iterations of the first variant, then `n` of the next, and so on, and
    /// returns the time of each of the `N` variants. Criterion reports the time of the first variant.
    pub(crate) fn measure<S, const N: usize>(
        &mut self,
        [group, name]: [&str; 2],
        sampling: Sampling,
        state: impl Fn() -> S,
        mut work: impl FnMut(&mut S, u64) -> [Duration; N],
    ) -> Option<Samples<N>> {
        let mut group = self.criterion.benchmark_group(group);
        group
            .sample_size(sampling.samples())
            .warm_up_time(Duration::from_millis(300))
            .measurement_time(Duration::from_millis(1200))
            .sampling_mode(SamplingMode::Flat);
        let mut built = None;
        let mut samples = Vec::new();
        group.bench_function(name, |bencher| {
            let built = built.get_or_insert_with(&state);
            bencher.iter_custom(|iterations| {
                let times = work(built, iterations);
                samples.push(times.map(|time| time.as_secs_f64() / iterations as f64));
                times[0]
            });
        });
        group.finish();
        // Earlier samples belong to the warm-up.
        samples.drain(..samples.len().saturating_sub(sampling.samples()));
        (!samples.is_empty()).then_some(Samples(samples))
    }

    /// Starts a section of the table.
    pub(crate) fn section(&mut self, heading: &str) {
        self.table.section(heading);
    }

    /// Adds a row to the last section of the table.
    pub(crate) fn row(
        &mut self,
        case: &str,
        (measured, unit): (f64, &'static str),
        target: Option<Target>,
        comparison: impl Into<String>,
    ) {
        self.table.row(Row { case: case.to_owned(), measured, unit, target, comparison: comparison.into() });
    }

    /// Prints the table, unless the option `--test` is set, which runs every case only once.
    pub(crate) fn finish(self) {
        let text = format!("\n{}, {}\n\n{}", processor(), simd_level(), self.table);
        if self.table.rows().next().is_some() && !std::env::args().any(|argument| argument == "--test") {
            // A closed pipe is not an error.
            let _ = std::io::stdout().write_all(text.as_bytes());
        }
    }
}

/// Returns the model of the processor (the architecture if it is unknown) and the number of threads.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get());
    format!("{} x {threads}", model.map_or(std::env::consts::ARCH, |(_, name)| name.trim()))
}

/// Returns the run time of `work`.
pub(crate) fn timed<R>(work: impl FnOnce() -> R) -> Duration {
    let start = Instant::now();
    std::hint::black_box(work());
    start.elapsed()
}

/// Returns the time of `count` steps. The thread pool is entered once for all steps, as in a run.
pub(crate) fn steps(simulation: &mut Simulation, count: u64) -> Duration {
    timed(|| simulation.steps(count))
}
