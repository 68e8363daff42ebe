//! Timing with criterion, and what the table takes from it: medians, and ratios of rivals that took turns.

use std::io::Write;
use std::time::{Duration, Instant};

use criterion::{Criterion, SamplingMode};
use supple::{Simulation, simd_level};
use supple_benches::{Row, Table, Target};

/// How much of its time a case gets.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sampling {
    /// Below some milliseconds.
    Many,
    /// Tens of milliseconds and more.
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

/// Seconds that an iteration of each of `N` rivals took, sample by sample: those of a sample took turns.
pub(crate) struct Samples<const N: usize>(Vec<[f64; N]>);

impl<const N: usize> Samples<N> {
    /// The median of a rival, in seconds.
    pub(crate) fn seconds(&self, rival: usize) -> f64 {
        self.median(|sample| sample[rival])
    }

    /// How many times as long as `other` a rival took: the median of the samples' ratios.
    pub(crate) fn ratio(&self, rival: usize, other: usize) -> f64 {
        self.median(|sample| sample[rival] / sample[other])
    }

    /// How many seconds longer than `other` a rival took: the median of the samples' differences.
    pub(crate) fn difference(&self, rival: usize, other: usize) -> f64 {
        self.median(|sample| sample[rival] - sample[other])
    }

    fn median(&self, value: impl Fn(&[f64; N]) -> f64) -> f64 {
        let mut values: Vec<f64> = self.0.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
    }
}

/// Criterion, and the table of what it measured.
pub(crate) struct Bench {
    criterion: Criterion,
    table: Table,
}

impl Bench {
    /// As the arguments of the program ask for.
    pub(crate) fn from_arguments() -> Self {
        Self {
            criterion: Criterion::default().without_plots().configure_from_args(),
            table: Table::default(),
        }
    }

    /// Measures the case `group/name`; `None` if the filter leaves it out.
    ///
    /// `work(state, n)` does `n` iterations of each of `N` rivals, one rival after the other, and says how long each
    /// took. Criterion reports the first of them.
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
        // Before them it was warmed up.
        samples.drain(..samples.len().saturating_sub(sampling.samples()));
        (!samples.is_empty()).then_some(Samples(samples))
    }

    /// Starts a part of the table.
    pub(crate) fn part(&mut self, heading: &str) {
        self.table.part(heading);
    }

    /// Adds a row to the table.
    pub(crate) fn row(
        &mut self,
        case: &str,
        (measured, unit): (f64, &'static str),
        target: Option<Target>,
        beside: impl Into<String>,
    ) {
        self.table.row(Row { case: case.to_owned(), measured, unit, target, beside: beside.into() });
    }

    /// Prints the table, unless every case ran but once.
    pub(crate) fn finish(self) {
        let text = format!("\n{}, {}\n\n{}", processor(), simd_level(), self.table);
        if self.table.rows().next().is_some() && !std::env::args().any(|argument| argument == "--test") {
            // A reader that has gone away needs no table.
            let _ = std::io::stdout().write_all(text.as_bytes());
        }
    }
}

/// The machine by its processor, where the system tells.
fn processor() -> String {
    let facts = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = facts.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get());
    format!("{} x {threads}", model.map_or(std::env::consts::ARCH, |(_, name)| name.trim()))
}

/// How long something takes.
pub(crate) fn timed<R>(work: impl FnOnce() -> R) -> Duration {
    let start = Instant::now();
    std::hint::black_box(work());
    start.elapsed()
}

/// How long `count` steps take. Entering a pool of threads has a price: once for all of them, as in a run.
pub(crate) fn steps(simulation: &mut Simulation, count: u64) -> Duration {
    timed(|| simulation.steps(count))
}
