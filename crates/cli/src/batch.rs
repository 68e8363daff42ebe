//! Several inputs, one after another: a failure does not stop the rest, a table ends it.

use std::path::{Path, PathBuf};

use supple_io::run::{Outcome, RunError, RunReport};

use crate::args::RunArgs;
use crate::{Exit, input, interrupt, run, say, summary};

/// Runs every input into a folder of its own.
pub(crate) fn run(args: &RunArgs, inputs: &[PathBuf]) -> Exit {
    if let Some((first, second)) = same_stem(inputs) {
        say::error(format_args!(
            "{} and {} would both write to a folder called {}; run them one at a time, with -o",
            first.display(),
            second.display(),
            input::stem(first)
        ));
        return Exit::Input;
    }
    let mut results: Vec<(String, Result<RunReport, RunError>)> = Vec::new();
    for input in inputs {
        if interrupt::asked() {
            break;
        }
        let stem = input::stem(input);
        let stats = args.stats.as_deref().map(|path| stats_of(path, &stem));
        let folder = |scene: &supple_io::scene::Scene| {
            args.output.clone().unwrap_or_else(|| scene.output_folder()).join(&stem)
        };
        let result = run::run_one(args, input, folder, stats);
        match &result {
            Ok(report) => say::out(summary::line(&stem, report)),
            Err(error) => say::error(format_args!("{stem}: {error}")),
        }
        results.push((stem, result));
    }
    say::out(summary::table(&results, inputs.len()));

    let stopped = |result: &Result<RunReport, _>| {
        result.as_ref().is_ok_and(|report| report.outcome == Outcome::Stopped)
    };
    if results.len() < inputs.len() || results.iter().any(|(_, result)| stopped(result)) {
        say::out(format_args!("go on with: {}", run::resume_command()));
        Exit::Interrupted
    } else if results.iter().any(|(_, result)| result.is_err()) {
        Exit::Failed
    } else {
        Exit::Done
    }
}

/// Two inputs whose files have the same stem.
fn same_stem(inputs: &[PathBuf]) -> Option<(&Path, &Path)> {
    inputs.iter().enumerate().find_map(|(index, second)| {
        let first = inputs[..index].iter().find(|first| input::stem(first) == input::stem(second))?;
        Some((first.as_path(), second.as_path()))
    })
}

/// The stats file of one input: `stats.csv` of `bust.toml` is `stats_bust.csv`.
fn stats_of(path: &Path, stem: &str) -> PathBuf {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{name}_{stem}.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_input_has_its_own_files() {
        assert_eq!(stats_of(Path::new("a/stats.csv"), "bust"), Path::new("a/stats_bust.csv"));
        let inputs = ["a/x.toml", "b/y.toml", "b/x.obj"].map(PathBuf::from);
        assert_eq!(same_stem(&inputs), Some((Path::new("a/x.toml"), Path::new("b/x.obj"))));
        assert_eq!(same_stem(&inputs[..2]), None);
    }
}
