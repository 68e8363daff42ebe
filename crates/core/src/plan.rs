//! The plan of a simulation: its stages in execution order, and their memory.
//!
//! A stage that a body does not need is not created and takes no time and no memory. The plan lists such a
//! stage as "left out".

use std::fmt;

/// Name of the stage in which a body touches other bodies and itself.
pub const CONTACT_OF_BODIES: &str = "contact of bodies";

/// The stages of each body of a [`Simulation`](crate::Simulation). `Display` prints them as a table.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Plan {
    /// Length of a step in seconds.
    pub dt: f64,
    /// Steps per frame.
    pub substeps: u64,
    /// Number of threads.
    pub threads: usize,
    /// One plan per body.
    pub bodies: Vec<BodyPlan>,
    /// Current memory of the search and the impulses of contact between bodies, which all bodies share, in bytes;
    /// `None` if no body can touch another one or itself.
    pub contact_bytes: Option<usize>,
    /// Current memory of the window sums of small bodies, which the bodies that a thread steps have in common, in
    /// bytes. It is allocated in the first step.
    pub window_sum_bytes: usize,
}

/// The stages of one body.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyPlan {
    /// Name of the body.
    pub name: String,
    /// Memory of the lattice, in bytes.
    pub lattice_bytes: usize,
    /// Memory of the state of the lattice vertices (positions, velocities and rotations), in bytes.
    pub state_bytes: usize,
    /// The existing stages in execution order.
    pub stages: Vec<PlannedStage>,
    /// Names of the stages that this body does not need.
    pub left_out: Vec<&'static str>,
}

/// A stage of a body.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlannedStage {
    /// The occasion on which the stage runs.
    pub when: When,
    /// Name of the stage.
    pub name: &'static str,
    /// Parameters of the stage, as text.
    pub detail: String,
    /// Current memory of the stage, in bytes.
    pub bytes: usize,
}

/// The occasion on which a stage runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum When {
    /// In every step.
    Step,
    /// When the displayed surface is evaluated, for example for a frame on disk.
    Display,
}

impl BodyPlan {
    /// Returns the memory of the body in bytes: lattice, state and stages.
    pub fn bytes(&self) -> usize {
        let stages: usize = self.stages.iter().map(|stage| stage.bytes).sum();
        self.lattice_bytes + self.state_bytes + stages
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dt, substeps, threads, bodies, contact_bytes, window_sum_bytes } = self;
        writeln!(f, "dt: {dt:.6} s, steps per frame: {substeps}, threads: {threads}")?;
        for body in bodies {
            writeln!(f, "{}: {:.1} MB", body.name, body.bytes() as f64 / 1e6)?;
            for stage in &body.stages {
                let when = match stage.when {
                    When::Step => "step",
                    When::Display => "display",
                };
                let kilobytes = stage.bytes as f64 / 1e3;
                writeln!(f, "  {when:<7}  {:<18} {:<49} {kilobytes:>10.1} kB", stage.name, stage.detail)?;
            }
            if !body.left_out.is_empty() {
                writeln!(f, "  left out: {}", body.left_out.join(", "))?;
            }
        }
        if let Some(bytes) = contact_bytes {
            let kilobytes = *bytes as f64 / 1e3;
            writeln!(f, "contact of bodies: {kilobytes:.1} kB in common")?;
        }
        if *window_sum_bytes > 0 {
            writeln!(f, "window sums of small bodies: {:.1} kB in common", *window_sum_bytes as f64 / 1e3)?;
        }
        Ok(())
    }
}
