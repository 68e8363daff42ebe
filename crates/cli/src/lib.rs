//! The command line of supple, as a library: arguments -> jobs and studies -> lines on a terminal.
//!
//! Exit codes: 0 done; 2 bad arguments, scene or mesh, and nothing was written; 1 a failure during the run; 130 ended
//! by Ctrl-C.

mod args;
mod inspect;
mod interrupt;
mod progress;
mod run;
mod say;
mod study;

use std::process::ExitCode;

use clap::Parser;
use supple_io::run::RunError;

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

impl From<&RunError> for Exit {
    fn from(error: &RunError) -> Self {
        if error.is_input() { Self::Input } else { Self::Failed }
    }
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
    let exit = match command {
        Command::Run(args) => run::run(&args),
        Command::Inspect(args) => inspect::inspect(&args),
        Command::Study(args) => study::study(&args),
    };
    exit.into()
}
