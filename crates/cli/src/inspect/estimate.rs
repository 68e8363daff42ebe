//! Estimates what a run of a scene needs. `--json` prints it, for schedulers.

use std::sync::mpsc::channel;
use std::thread;
use std::time::{Duration, Instant};

use serde::Serialize;
use supple::Simulation;
use supple_io::memory_limit;

/// Time after which no further step is measured.
const LONGEST: Duration = Duration::from_millis(300);

/// Time after which the first step is given up.
const PATIENCE: Duration = Duration::from_secs(2);

/// What a run needs.
#[derive(Debug, Serialize)]
pub(super) struct Estimate {
    /// Memory of the simulation after its first steps, in bytes, without the files of the models.
    memory_bytes: usize,
    /// Memory that a lattice may take on this machine, in bytes.
    memory_limit_bytes: u64,
    /// Wall-clock time of the steps of a frame, in seconds: that of the fastest of the first steps, times their number.
    /// Writing files is not included, and bodies that touch take longer. `None` if the first step takes longer than 2 s.
    seconds_per_frame: Option<f64>,
    /// Size of a frame of all bodies on disk, in bytes.
    bytes_per_frame: u64,
}

impl Estimate {
    /// Measures the first steps of a simulation, at most those of a frame, which has this size on disk.
    pub(super) fn measure(mut simulation: Simulation, substeps: u32, bytes_per_frame: u64) -> Self {
        let before = memory(&simulation);
        let (sender, receiver) = channel();
        // A step cannot be interrupted. The thread of one that is given up ends with the process.
        thread::spawn(move || {
            let fastest = fastest_step(&mut simulation, substeps);
            let _ = sender.send((fastest, memory(&simulation)));
        });
        let measured = receiver.recv_timeout(PATIENCE).ok();
        Self {
            memory_bytes: measured.map_or(before, |(_, after)| after),
            memory_limit_bytes: memory_limit(),
            seconds_per_frame: measured.map(|(fastest, _)| fastest.as_secs_f64() * f64::from(substeps)),
            bytes_per_frame,
        }
    }
}

/// Returns the time of the fastest of the first steps, at most those of a frame.
fn fastest_step(simulation: &mut Simulation, substeps: u32) -> Duration {
    let start = Instant::now();
    let mut fastest = Duration::MAX;
    for _ in 0..substeps.max(1) {
        let step = Instant::now();
        simulation.step();
        fastest = fastest.min(step.elapsed());
        if start.elapsed() > LONGEST {
            break;
        }
    }
    fastest
}

/// Returns the memory of a simulation in bytes.
fn memory(simulation: &Simulation) -> usize {
    let plan = simulation.plan();
    let of_bodies: usize = plan.bodies.iter().map(|body| body.bytes()).sum();
    of_bodies + plan.contact_bytes.unwrap_or(0) + plan.window_sum_bytes
}
