//! The command line of supple as a library: parses arguments, runs jobs and studies, prints the results.
//!
//! Exit codes: 0 success; 1 a failure during the run; 2 invalid arguments, scene or mesh (nothing was
//! written); 130 stopped by Ctrl-C.

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
        terminal::error(error);
        return Exit::Input.into();
    }
    let exit = match command {
        Command::Run(args) => run::run(&args),
        Command::Inspect(args) => inspect::inspect(&args),
        Command::Study(args) => study::study(&args),
    };
    exit.into()
}
