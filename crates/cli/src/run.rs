//! `supple run`: one input, or the same for each of several.

use std::path::{Path, PathBuf};

use supple_io::run::{Job, Outcome, RunError, RunReport};
use supple_io::scene::Scene;

use crate::args::RunArgs;
use crate::progress::Watch;
use crate::{Exit, batch, input, interrupt, say, summary};

/// Runs every input.
pub(crate) fn run(args: &RunArgs) -> Exit {
    if args.print_scene {
        return print_scenes(args);
    }
    interrupt::listen();
    match args.inputs.as_slice() {
        [input] => {
            let output = args.output.clone();
            let result = run_one(
                args,
                input,
                |scene| output.unwrap_or_else(|| scene.output_folder()),
                args.stats.clone(),
            );
            conclude(input, result)
        }
        inputs => batch::run(args, inputs),
    }
}

/// The scene of an input with the changes that the arguments ask for.
fn changed_scene(args: &RunArgs, input: &Path) -> Result<Scene, RunError> {
    let mut scene = input::scene(input, &args.scene)?;
    if let Some(frames) = args.frames {
        scene.simulation.frames = frames;
    }
    if let Some(threads) = args.threads {
        scene.simulation.threads = threads.into();
    }
    if let Some(format) = args.format {
        scene.output.format = format.into();
    }
    Ok(scene)
}

/// Runs one input into a folder.
pub(crate) fn run_one(
    args: &RunArgs,
    input: &Path,
    folder: impl FnOnce(&Scene) -> PathBuf,
    stats: Option<PathBuf>,
) -> Result<RunReport, RunError> {
    let scene = changed_scene(args, input)?;
    let folder = folder(&scene);
    let mut job = Job::new(scene, folder);
    job.every = args.every;
    job.start_frame = args.start_frame;
    job.resume = args.resume;
    job.stats = stats;
    job.checkpoint_interval = args.checkpoint;
    let mut watch = Watch::new(&input::stem(input), args.quiet);
    let result = job.run(&mut watch);
    watch.finish();
    result
}

/// Prints how a single run ended.
fn conclude(input: &Path, result: Result<RunReport, RunError>) -> Exit {
    match result {
        Ok(report) => {
            say::out(summary::line(&input::stem(input), &report));
            if report.outcome == Outcome::Stopped {
                say::out(format_args!("go on with: {}", resume_command()));
                return Exit::Interrupted;
            }
            Exit::Done
        }
        Err(error) => {
            say::error(&error);
            failure(&error)
        }
    }
}

/// The exit code of an error.
pub(crate) fn failure(error: &RunError) -> Exit {
    if error.is_input() { Exit::Input } else { Exit::Failed }
}

/// The command that goes on where this one ended.
pub(crate) fn resume_command() -> String {
    let mut words: Vec<String> = std::env::args().map(|word| quoted(&word)).collect();
    if !words.iter().any(|word| word == "--resume") {
        words.push("--resume".to_owned());
    }
    words.join(" ")
}

/// A word as a shell reads it back.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

fn print_scenes(args: &RunArgs) -> Exit {
    for input in &args.inputs {
        match changed_scene(args, input) {
            Ok(scene) => say::out(scene.to_toml().trim_end()),
            Err(error) => {
                say::error(&error);
                return Exit::Input;
            }
        }
    }
    Exit::Done
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("a/b.toml"), "a/b.toml");
        assert_eq!(quoted("a b"), "'a b'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
