//! The plan of a simulation: which stages run, in which order, and the memory that they hold.
//!
//! A stage that a scene does not need does not exist: it takes no time and no memory, and is named under "left out".

use std::fmt;

/// The stages of a [`Simulation`](crate::Simulation), for each body.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Plan {
    /// Length of a step in seconds.
    pub dt: f64,
    /// Steps per frame.
    pub substeps: u64,
    /// Number of threads.
    pub threads: usize,
    /// One for each body.
    pub bodies: Vec<BodyPlan>,
}

/// The stages of one body.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BodyPlan {
    /// The body's name.
    pub name: String,
    /// Memory of the lattice.
    pub lattice_bytes: usize,
    /// Memory of positions, velocities and rotations.
    pub state_bytes: usize,
    /// In the order in which they run.
    pub stages: Vec<PlannedStage>,
    /// The stages that this body does not need.
    pub left_out: Vec<&'static str>,
}

/// One stage.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlannedStage {
    /// When it runs.
    pub when: When,
    /// Its name.
    pub name: &'static str,
    /// Its parameters.
    pub detail: String,
    /// Memory that it holds now.
    pub bytes: usize,
}

/// When a stage runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum When {
    /// In every step.
    Step,
    /// Where the body is shown: on a written frame.
    Display,
}

impl BodyPlan {
    /// Memory of the body: lattice, state and stages.
    pub fn bytes(&self) -> usize {
        let stages: usize = self.stages.iter().map(|stage| stage.bytes).sum();
        self.lattice_bytes + self.state_bytes + stages
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { dt, substeps, threads, bodies } = self;
        writeln!(f, "steps of {dt:.6} s, {substeps} a frame, threads: {threads}")?;
        for body in bodies {
            writeln!(f, "{}: {:.1} MB", body.name, body.bytes() as f64 / 1e6)?;
            for stage in &body.stages {
                let when = match stage.when {
                    When::Step => "step",
                    When::Display => "show",
                };
                let kilobytes = stage.bytes as f64 / 1e3;
                writeln!(f, "  {when}  {:<18} {:<52} {kilobytes:>10.1} kB", stage.name, stage.detail)?;
            }
            if !body.left_out.is_empty() {
                writeln!(f, "  left out: {}", body.left_out.join(", "))?;
            }
        }
        if bodies.len() > 1 {
            writeln!(f, "contact between bodies is not simulated")?;
        }
        Ok(())
    }
}
