//! The command line of supple, as a library: arguments -> jobs -> what a terminal shows.
//!
//! Exit codes: 0 done; 2 bad arguments, scene or mesh, and nothing was written; 1 anything that
//! failed while running; 130 ended by Ctrl-C.

mod args;
mod batch;
mod input;
mod inspect;
mod interrupt;
mod progress;
mod run;
mod say;
mod study;
mod summary;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Exit {
    /// Everything that was asked for is there.
    Done,
    /// Something failed while it ran.
    Failed,
    /// Arguments, scene or mesh are wrong; nothing was written.
    Input,
    /// Ended by Ctrl-C.
    Interrupted,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::Failed => 1,
            Exit::Input => 2,
            Exit::Interrupted => 130,
        })
    }
}

/// Runs the program on the arguments it was started with.
pub fn main() -> ExitCode {
    let command = Cli::parse().command;
    if let Err(error) = supple::check_simd_request() {
        say::error(error);
        return Exit::Input.into();
    }
    match command {
        Command::Run(args) => run::run(&args).into(),
        Command::Inspect(args) => inspect::inspect(&args).into(),
        Command::Study(args) => study::study(&args).into(),
    }
}
