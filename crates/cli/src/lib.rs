//! The program `supple` as a library: parses the command line, runs, inspects or studies scenes, and prints
//! the results.
//!
//! Exit codes:
//!
//! * 0: success;
//! * 1: the run failed, one of several inputs failed, or a case of a study failed;
//! * 2: the arguments, the scene or a mesh are invalid, and nothing was written;
//! * 130: Ctrl-C stopped the program;
//! * 143: SIGTERM stopped the program.

mod args;
mod exit;
mod film;
mod html;
mod inspect;
mod interrupt;
mod progress;
mod run;
mod study;
mod terminal;

use std::ffi::OsString;
use std::fmt::Display;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use clap::error::{ContextKind, ContextValue};
use supple_io::model::is_model;
use supple_io::scene::SceneError;

use args::{Cli, Command, has_extension};
use exit::Exit;

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    ExitCode::from(main_with(std::env::args_os().collect()))
}

/// Runs the program with the given arguments, the first of which is its name, and returns the exit code. It may be
/// called once per process, because it handles Ctrl-C and SIGTERM.
pub fn main_with(arguments: Vec<OsString>) -> u8 {
    let code = execute(&arguments);
    // A process whose `main` is not Rust's does not flush.
    let _ = io::stdout().flush();
    code
}

/// Parses the arguments and runs the command.
fn execute(arguments: &[OsString]) -> u8 {
    terminal::set_arguments(arguments);
    let command = match Cli::try_parse_from(arguments) {
        Ok(Cli { command }) => command,
        Err(error) => match input_without_command(&error) {
            Some(message) => return refused(message),
            None => {
                let _ = error.print();
                return if error.use_stderr() { Exit::Input } else { Exit::Done }.code();
            }
        },
    };
    if let Err(error) = supple::check_simd_request() {
        return refused(error);
    }
    if let Err(message) = command.check() {
        return refused(message);
    }
    let exit = match command {
        Command::Run(args) => run::run(&args),
        Command::Inspect(args) => inspect::inspect(&args),
        Command::Study(args) => study::study(&args),
        Command::Html(args) => html::html(&args),
        Command::Film(args) => film::film(&args),
    };
    exit.code()
}

/// Prints an error of the arguments.
fn refused(error: impl Display) -> u8 {
    terminal::print_error(error);
    Exit::Input.code()
}

/// Returns a message if the command is missing, and the name of a file is in its place.
fn input_without_command(error: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return None };
    let path = Path::new(word);
    if has_extension(path, &["toml"]) || is_model(path) {
        let quoted = terminal::quoted(word);
        return Some(format!("{word} is a file, not a command; to simulate it, write: supple run {quoted}"));
    }
    path.extension().map(|_| SceneError::Kind { path: path.to_owned() }.to_string())
}
