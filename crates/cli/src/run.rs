//! `supple run`: simulates one or several inputs, one after another, and writes their frames.

use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};

use supple_io::frames::{Format, Formats};
use supple_io::run::{Job, Outcome, RunError, RunReport};
use supple_io::scene::Scene;
use supple_io::{counted, write_atomically};

use crate::args::{ProgressForm, RunArgs, has_extension};
use crate::exit::Exit;
use crate::progress::Reporter;
use crate::{interrupt, terminal};

/// Runs every input, or prints the scenes if `--print-scene` is set.
pub(crate) fn run(args: &RunArgs) -> Exit {
    if args.print_scene {
        return print_scenes(args);
    }
    if args.progress() == ProgressForm::Json {
        terminal::print_messages_as_json();
    }
    interrupt::install_handler();
    match args.inputs.as_slice() {
        [input] => run_single(args, input),
        inputs => run_several(args, inputs),
    }
}

/// Prints the scene of each input with absolute paths, or writes it to the file `-o`.
fn print_scenes(args: &RunArgs) -> Exit {
    if let Some(file) = &args.output {
        return write_scene(args, file);
    }
    for input in &args.inputs {
        match changed_scene(args, input).and_then(|scene| Ok(scene.relocated(None)?)) {
            Ok(scene) => terminal::print_data(scene.to_toml().trim_end()),
            Err(error) => {
                terminal::print_error(&error);
                return Exit::Input;
            }
        }
    }
    Exit::Done
}

/// Writes the scene of the only input to a new file, with paths relative to the file.
fn write_scene(args: &RunArgs, file: &Path) -> Exit {
    let name = file.display();
    let refused = |message: String| {
        terminal::print_error(message);
        Exit::Input
    };
    let [input] = args.inputs.as_slice() else {
        let inputs = args.inputs.len();
        return refused(format!("--print-scene -o {name} writes one scene, not {inputs}; give one input"));
    };
    if !has_extension(file, &["toml"]) {
        return refused(format!(
            "-o {name}: with --print-scene, -o is the scene file to write; it must end in .toml"
        ));
    }
    if file.symlink_metadata().is_ok() {
        return refused(format!(
            "-o {name}: the file exists, and is not replaced; choose another name, or remove it"
        ));
    }
    let directory = file.parent().unwrap_or(Path::new(""));
    match changed_scene(args, input).and_then(|scene| Ok(scene.relocated(Some(directory))?)) {
        Err(error) => {
            terminal::print_error(&error);
            Exit::Input
        }
        Ok(scene) => match write_atomically(file, |open| open.write_all(scene.to_toml().as_bytes())) {
            Ok(()) => {
                terminal::print(format_args!("scene written to {name}"));
                Exit::Done
            }
            Err(error) => {
                terminal::print_error(format_args!("cannot write {name}: {error}"));
                Exit::Failed
            }
        },
    }
}

/// Reads the scene of an input and applies the command-line options that change the scene.
fn changed_scene(args: &RunArgs, input: &Path) -> Result<Scene, RunError> {
    let mut scene = args.scene.open(input)?;
    if let Some(frames) = args.frames {
        scene.simulation.frames = frames;
    }
    if let Some(threads) = args.threads {
        scene.simulation.threads = threads as usize;
    }
    if let Some(formats) = Formats::new(args.format.iter().copied()) {
        scene.output.format = formats;
    }
    if let Some(encoding) = args.vat_encoding {
        let formats = &scene.output.format;
        if !formats.contains(Format::Vat) {
            return Err(RunError::Option {
                option: "--vat-encoding",
                value: format!("{} with the format {formats}", encoding.name()),
                range: "left out, or used with the format vat, as in --format vat",
            });
        }
        scene.output.vat_encoding = encoding;
    }
    Ok(scene)
}

fn run_single(args: &RunArgs, input: &Path) -> Exit {
    let name = input_name(input);
    match run_one(args, input, &name, (0, 1)) {
        Ok(report) => {
            print_report(&name, &report, args.start_frame);
            if report.outcome == Outcome::Stopped {
                terminal::print(format_args!("resume with: {}", terminal::resume_command()));
                return interrupt::exit();
            }
            Exit::Done
        }
        Err(error) => {
            terminal::print_error(&error);
            match (&error, interrupt::requested()) {
                (RunError::Stopped, Some(signal)) => signal.exit(),
                _ => Exit::from(&error),
            }
        }
    }
}

/// Runs each input in a directory of its own, and prints a table at the end. If an input fails, the next
/// inputs still run.
fn run_several(args: &RunArgs, inputs: &[PathBuf]) -> Exit {
    if let Some((first, second)) = same_name(inputs) {
        terminal::print_error(format_args!(
            "{} and {} have the same name, {}, so they would have the same output directory; run them one at \
             a time, each with its own -o",
            first.display(),
            second.display(),
            input_name(first)
        ));
        return Exit::Input;
    }
    let mut results: Vec<(String, Result<RunReport, RunError>)> = Vec::new();
    for (index, input) in inputs.iter().enumerate() {
        if interrupt::requested().is_some() {
            break;
        }
        let name = input_name(input);
        let result = run_one(args, input, &name, (index, inputs.len()));
        match &result {
            Ok(report) => print_report(&name, report, args.start_frame),
            Err(error) => terminal::print_error(format_args!("{name}: {error}")),
        }
        results.push((name, result));
    }
    terminal::print(table(&results, inputs.len()));

    let stopped = |result: &Result<RunReport, RunError>| match result {
        Ok(report) => report.outcome == Outcome::Stopped,
        Err(error) => matches!(error, RunError::Stopped),
    };
    if results.len() < inputs.len() || results.iter().any(|(_, result)| stopped(result)) {
        terminal::print(format_args!("resume with: {}", terminal::resume_command()));
        interrupt::exit()
    } else if results.iter().any(|(_, result)| result.is_err()) {
        Exit::Failed
    } else {
        Exit::Done
    }
}

/// Runs one input, and reports its progress. `name` is the name of the input, and `place` its index and the number of
/// inputs.
fn run_one(args: &RunArgs, input: &Path, name: &str, place: (usize, usize)) -> Result<RunReport, RunError> {
    let reporter = Reporter::of_job(args.progress(), name, input);
    let mut reporter = reporter.starting_at(args.start_frame).at_place(place.0, place.1);
    reporter.begin();
    let job = changed_scene(args, input).map(|scene| job(args, scene, input, name, place.1 > 1));
    let result = job.and_then(|job| job.run(&mut reporter));
    reporter.end(&result);
    result
}

/// Returns the job of an input. If `several` is set, `name`, the name of the input, is appended to the output directory
/// and to the name of the stats file.
fn job(args: &RunArgs, scene: Scene, input: &Path, name: &str, several: bool) -> Job {
    let mut directory = args.output.clone().unwrap_or_else(|| scene.output_directory());
    let mut stats = args.stats.clone();
    if several {
        directory.push(name);
        stats = stats.map(|path| stats_path(&path, name));
    }
    let mut job = Job::new(scene, directory);
    job.every = args.every;
    job.start_frame = args.start_frame;
    job.resume = args.resume.unwrap_or_default();
    job.from = args.from;
    job.verify = args.verify;
    job.scene_file = Some(input.to_owned());
    job.stats = stats;
    job.checkpoint_interval = args.checkpoint;
    job
}

/// Returns the first pair of inputs with the same [`input_name`].
fn same_name(inputs: &[PathBuf]) -> Option<(&Path, &Path)> {
    inputs.iter().enumerate().find_map(|(index, second)| {
        let first = inputs[..index].iter().find(|first| input_name(first) == input_name(second))?;
        Some((first.as_path(), second.as_path()))
    })
}

/// Returns the name of an input: its file name without the extension. If there are several inputs, the output
/// directory of each ends in its name.
fn input_name(input: &Path) -> String {
    input.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Returns the stats file for one of several inputs: `stats.csv` becomes `stats_bust.csv` for `bust.toml`.
fn stats_path(path: &Path, input_name: &str) -> PathBuf {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{name}_{input_name}.{extension}"))
}

/// Prints the summary of a job, the lines about its files, and its warnings. `start_frame` is the number of its first
/// frame.
fn print_report(name: &str, report: &RunReport, start_frame: u32) {
    terminal::print(summary_line(name, report, start_frame));
    report.files.iter().for_each(|line| terminal::print(format_args!("{name}: {line}")));
    print_warnings(name, report);
}

/// Prints a line for each body whose volume was not kept, that was crushed or that is softer than specified.
fn print_warnings(name: &str, report: &RunReport) {
    for body in &report.bodies {
        let warn = |warning: &dyn Display| {
            terminal::print_warning(format_args!("{name}: body {}: {warning}", body.name));
        };
        body.unkept_volume.iter().for_each(|volume| warn(volume));
        body.crushed.iter().for_each(|crushed| warn(crushed));
        body.softened.iter().for_each(|softened| warn(softened));
    }
}

/// Formats the summary line of a job. `start_frame` is the number of its first frame.
fn summary_line(name: &str, report: &RunReport, start_frame: u32) -> String {
    let directory = report.directory.display();
    let last = u64::from(start_frame) + u64::from(report.last);
    match report.outcome {
        Outcome::AlreadyFinished => {
            format!("{name}: already finished at frame {last} in {directory}; nothing written")
        }
        Outcome::Finished | Outcome::Stopped => {
            let outcome = if report.outcome == Outcome::Stopped { "stopped after" } else { "finished at" };
            format!(
                "{name}: {outcome} frame {last}, {} written to {directory} in {}",
                counted(report.written as usize, "frame"),
                terminal::duration(report.elapsed.as_secs_f64())
            )
        }
    }
}

/// Formats the table of several inputs. `inputs` is their number; after Ctrl-C or SIGTERM, `results` has fewer entries.
fn table(results: &[(String, Result<RunReport, RunError>)], inputs: usize) -> String {
    let width = results.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max("input".len());
    let row = |cells: [&str; 5]| {
        let [name, outcome, frames, time, directory] = cells;
        format!("{name:width$}  {outcome:15}  {frames:>7}  {time:>12}  {directory}").trim_end().to_owned()
    };
    let mut lines = vec![row(["input", "outcome", "frames", "time", "directory"])];
    for (name, result) in results {
        lines.push(match result {
            Ok(report) => {
                let outcome = match report.outcome {
                    Outcome::Finished => "done",
                    Outcome::Stopped => "stopped",
                    Outcome::AlreadyFinished => "already done",
                };
                let time = terminal::duration(report.elapsed.as_secs_f64());
                let directory = report.directory.display().to_string();
                row([name, outcome, &report.written.to_string(), &time, &directory])
            }
            Err(error) => row([name, "failed", "", "", &error.to_string()]),
        });
    }
    if results.len() < inputs {
        lines.push(format!("{} of {} not started", inputs - results.len(), counted(inputs, "input")));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stats_paths_contain_the_input_name_and_equal_input_names_are_found() {
        assert_eq!(stats_path(Path::new("a/stats.csv"), "bust"), Path::new("a/stats_bust.csv"));
        let inputs = ["a/x.toml", "b/y.toml", "b/x.obj"].map(PathBuf::from);
        assert_eq!(same_name(&inputs), Some((Path::new("a/x.toml"), Path::new("b/x.obj"))));
        assert_eq!(same_name(&inputs[..2]), None);
    }
}
