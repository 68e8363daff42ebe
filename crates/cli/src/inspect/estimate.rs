//! Estimates what a run of a scene needs. `--json` prints it, for schedulers.

use std::time::{Duration, Instant};

use serde::Serialize;
use supple::Simulation;
use supple_io::memory_limit;

/// Time after which no further step is measured.
const LONGEST: Duration = Duration::from_millis(300);

/// What a run needs.
#[derive(Debug, Serialize)]
pub(super) struct Estimate {
    /// Memory of the simulation after its first steps, in bytes, without the files of the models.
    memory_bytes: usize,
    /// Memory that a lattice may take on this machine, in bytes.
    memory_limit_bytes: u64,
    /// Wall-clock time of the steps of a frame, in seconds: that of the fastest of the first steps, times their number.
    /// Writing files is not included, and bodies that touch take longer.
    seconds_per_frame: f64,
    /// Size of a frame of all bodies on disk, in bytes.
    bytes_per_frame: u64,
}

impl Estimate {
    /// Measures the first steps of a simulation, at most those of a frame, which has this size on disk.
    pub(super) fn measure(simulation: &mut Simulation, substeps: u32, bytes_per_frame: u64) -> Self {
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
        let plan = simulation.plan();
        let of_bodies: usize = plan.bodies.iter().map(|body| body.bytes()).sum();
        Self {
            memory_bytes: of_bodies + plan.contact_bytes.unwrap_or(0) + plan.window_sum_bytes,
            memory_limit_bytes: memory_limit(),
            seconds_per_frame: fastest.as_secs_f64() * f64::from(substeps),
            bytes_per_frame,
        }
    }
}
