//! The command line of supple, as a library: arguments -> jobs and studies -> lines on a terminal.
//!
//! Exit codes: 0 done; 2 bad arguments, scene or mesh, and nothing was written; 1 a failure during the run; 130 ended
//! by Ctrl-C.

mod args;
mod exit;
mod inspect;
mod interrupt;
mod progress;
mod run;
mod say;
mod study;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use exit::Exit;

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
