//! Describes the machine that ran a study.

use std::thread::available_parallelism;

use serde::{Deserialize, Serialize};

/// Description of the machine that ran a study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Model of the processor; empty if unknown (`/proc/cpuinfo` is missing).
    pub processor: String,
    /// Number of processors available to the program.
    pub processors: usize,
    /// Number of worker threads.
    pub threads: usize,
    /// SIMD level used by the library `supple`.
    pub simd: String,
    /// Operating system and architecture.
    pub system: String,
    /// Version of supple.
    pub version: String,
}

impl Machine {
    /// Describes this machine with the given number of worker threads.
    pub fn here(threads: usize) -> Self {
        Self {
            processor: processor(),
            processors: available_parallelism().map_or(1, usize::from),
            threads,
            simd: supple::simd_level().to_owned(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }

    /// Formats the description as one line.
    pub fn line(&self) -> String {
        let name = if self.processor.is_empty() { &self.system } else { &self.processor };
        let Self { processors, threads, simd, version, .. } = self;
        format!("{name}, {threads} of {processors} processors, {simd}, supple {version}")
    }
}

/// Returns the model of the processor, or an empty string.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    model.map_or_else(String::new, |(_, model)| model.trim().to_owned())
}
