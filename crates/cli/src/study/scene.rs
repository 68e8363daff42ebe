//! `supple study SCENE`: error against run time.

use std::path::Path;

use supple_study::{Outcome, Study, StudyError};

use super::progress::Watch;
use crate::args::StudyArgs;
use crate::run::resume_command;
use crate::{Exit, input, interrupt, say};

/// Studies a scene.
pub(super) fn study(args: &StudyArgs, path: &Path) -> Result<Exit, StudyError> {
    interrupt::listen();
    let scene = input::scene(path, &args.scene).map_err(supple_io::run::RunError::from)?;
    let study = Study {
        scene,
        name: path.display().to_string(),
        directory: args.output.clone(),
        quick: args.quick,
        resume: args.resume,
    };
    let mut watch = Watch::new(args.quiet);
    let result = study.run(&mut watch);
    watch.finish();
    let (report, outcome) = result?;
    say::out(report.table());
    let folder = args.output.display();
    match outcome {
        Outcome::Finished => {
            say::out(format_args!("written to {folder}: study.csv, study.json, study.svg"));
            Ok(Exit::Done)
        }
        Outcome::AlreadyFinished => {
            say::out(format_args!("finished before, in {folder}; nothing written"));
            Ok(Exit::Done)
        }
        Outcome::Stopped => {
            say::out(format_args!(
                "stopped after {} points; go on with: {}",
                report.points.len(),
                resume_command()
            ));
            Ok(Exit::Interrupted)
        }
    }
}
