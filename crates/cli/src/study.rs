//! `supple study`: measures error against run time for a scene or for the summation alone, checks the stability of
//! extreme cases, or measures materials.

use std::path::Path;

use supple_io::counted;
use supple_io::run::RunError;
use supple_study::material::MaterialStudy;
use supple_study::stability::StabilityStudy;
use supple_study::{Outcome, Study, StudyError, SumsStudy};

use crate::args::StudyArgs;
use crate::exit::Exit;
use crate::progress::Reporter;
use crate::{interrupt, terminal};

/// Runs the study that the arguments select.
pub(crate) fn study(args: &StudyArgs) -> Exit {
    interrupt::install_handler();
    let mut reporter = Reporter::of_study(args.quiet);
    let result = match &args.input {
        Some(input) => scene(args, input, &mut reporter),
        None if args.sums => sums(args, &mut reporter),
        None if args.material => material(args, &mut reporter),
        None => stability(args, &mut reporter),
    };
    result.unwrap_or_else(|error| {
        reporter.finish();
        terminal::print_error(&error);
        if error.is_input() { Exit::Input } else { Exit::Failed }
    })
}

/// Runs `supple study SCENE`, which measures the error of the scene against its run time.
fn scene(args: &StudyArgs, input: &Path, reporter: &mut Reporter) -> Result<Exit, StudyError> {
    let study = Study {
        scene: args.scene.open(input).map_err(RunError::from)?,
        name: input.display().to_string(),
        directory: args.output.clone(),
        quick: args.quick,
        resume: args.resume,
    };
    let (report, outcome) = study.run(reporter)?;
    reporter.finish();
    terminal::print(report.table());
    let directory = args.output.display();
    match outcome {
        Outcome::Finished => {
            terminal::print(format_args!("written to {directory}: study.csv, study.json, study.svg"))
        }
        Outcome::AlreadyFinished => {
            terminal::print(format_args!("already finished in {directory}; nothing written"));
        }
        Outcome::Stopped => {
            let points = counted(report.points.len(), "point");
            let command = terminal::resume_command();
            terminal::print(format_args!("stopped after {points}; resume with: {command}"));
            return Ok(interrupt::exit());
        }
    }
    Ok(Exit::Done)
}

/// Runs `supple study --sums`, which measures the error and the run time of the summation alone.
fn sums(args: &StudyArgs, reporter: &mut Reporter) -> Result<Exit, StudyError> {
    let study = SumsStudy { directory: args.output.clone(), quick: args.quick };
    let (report, outcome) = study.run(reporter)?;
    reporter.finish();
    terminal::print(report.table());
    terminal::print(format_args!("written to {}: sums.csv, sums.json", args.output.display()));
    Ok(if outcome == Outcome::Stopped { interrupt::exit() } else { Exit::Done })
}

/// Runs `supple study --stability`, which runs stiff and extreme cases and checks each against its bounds.
fn stability(args: &StudyArgs, reporter: &mut Reporter) -> Result<Exit, StudyError> {
    let study =
        StabilityStudy { directory: args.output.clone(), quick: args.quick, filter: args.filter.clone() };
    let report = study.run(reporter)?;
    reporter.finish();
    let passed = report.rows.iter().filter(|row| row.passed).count();
    let (cases, path) = (report.requested, study.path());
    terminal::print(format_args!("{}\n\n{}\n", report.machine.line(), report.table()));
    terminal::print(format_args!(
        "{passed} of {} passed; written to {}",
        counted(cases, "case"),
        path.display()
    ));
    Ok(exit(report.complete, report.passed))
}

/// Runs `supple study --material`, which measures materials and compares them with their laws and targets.
fn material(args: &StudyArgs, reporter: &mut Reporter) -> Result<Exit, StudyError> {
    let study =
        MaterialStudy { directory: args.output.clone(), quick: args.quick, filter: args.filter.clone() };
    let report = study.run(reporter)?;
    reporter.finish();
    let (rows, path) = (counted(report.rows.len(), "figure"), study.path());
    terminal::print(format_args!("{}\n\n{}\n", report.machine.line(), report.table()));
    terminal::print(format_args!(
        "{} of {rows} meet their targets; written to {}",
        report.met(),
        path.display()
    ));
    Ok(exit(report.complete, report.passed))
}

/// Returns the exit code of a study of cases.
fn exit(complete: bool, passed: bool) -> Exit {
    match (complete, passed) {
        (false, _) => interrupt::exit(),
        (true, false) => Exit::Failed,
        (true, true) => Exit::Done,
    }
}
