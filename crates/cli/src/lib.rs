//! The program `supple` as a library: parses the command line, runs, inspects or studies scenes, and prints
//! the results.
//!
//! Exit codes:
//!
//! * 0: success;
//! * 1: the run failed, one of several inputs failed, or a stability case failed;
//! * 2: the arguments, the scene or a mesh are invalid, and nothing was written;
//! * 130: Ctrl-C stopped the program.

mod args;
mod exit;
mod inspect;
mod interrupt;
mod progress;
mod run;
mod study;
mod terminal;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use exit::Exit;

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let command = Cli::parse().command;
    if let Err(error) = supple::check_simd_request() {
        terminal::print_error(error);
        return Exit::Input.into();
    }
    let exit = match command {
        Command::Run(args) => run::run(&args),
        Command::Inspect(args) => inspect::inspect(&args),
        Command::Study(args) => study::study(&args),
    };
    exit.into()
}
