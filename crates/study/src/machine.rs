//! Where a study was run.

use std::thread::available_parallelism;

use serde::{Deserialize, Serialize};

/// Where a study was run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Model of the processor; empty where the system does not say.
    pub processor: String,
    /// Processors that the program may use.
    pub processors: usize,
    /// Threads that worked.
    pub threads: usize,
    /// Vector instructions that the core used.
    pub simd: String,
    /// Operating system and architecture.
    pub system: String,
    /// Version of supple.
    pub version: String,
}

impl Machine {
    /// This machine, with so many threads at work.
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

    /// In one line.
    pub fn line(&self) -> String {
        let name = if self.processor.is_empty() { &self.system } else { &self.processor };
        let Self { processors, threads, simd, version, .. } = self;
        format!("{name}, {threads} of {processors} processors, {simd}, supple {version}")
    }
}

fn processor() -> String {
    let facts = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = facts.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    model.map_or_else(String::new, |(_, model)| model.trim().to_owned())
}
