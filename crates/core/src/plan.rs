//! A scene compiled: which stages run, in which order, and what they cost in memory.
//!
//! A stage that a scene does not need is not there at all: its struct is `None`, its buffers do not exist, and it
//! is named here under "left out".

use std::fmt;

/// What a [`Simulation`](crate::Simulation) does: for each body the stages of a step and of a look.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Length of a step in seconds.
    pub dt: f64,
    /// Steps per frame.
    pub substeps: u64,
    /// Threads that work.
    pub threads: usize,
    /// One for each body.
    pub bodies: Vec<BodyPlan>,
}

/// What is done for one body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyPlan {
    /// The body's name.
    pub name: String,
    /// In the order in which they run.
    pub stages: Vec<PlannedStage>,
    /// What this body does not need.
    pub left_out: Vec<&'static str>,
}

/// One stage.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedStage {
    /// When it runs.
    pub when: When,
    /// What it does.
    pub name: &'static str,
    /// Its parameters.
    pub detail: String,
    /// Memory that it holds.
    pub bytes: usize,
}

/// When a stage runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// In every step.
    Step,
    /// Only where somebody looks: on a written frame.
    Look,
}

impl BodyPlan {
    /// Adds a stage, or says that it is left out.
    pub(crate) fn stage(&mut self, when: When, name: &'static str, detail: Option<String>, bytes: usize) {
        match detail {
            Some(detail) => self.stages.push(PlannedStage { when, name, detail, bytes }),
            None => self.left_out.push(name),
        }
    }

    /// Memory of all stages.
    pub fn bytes(&self) -> usize {
        self.stages.iter().map(|stage| stage.bytes).sum()
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
                    When::Look => "look",
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
