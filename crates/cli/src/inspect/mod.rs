//! `supple inspect`: what would be simulated; nothing is run.

mod body;
mod facts;
mod text;

use supple_io::run::{RunError, prepare};

use crate::args::InspectArgs;
use crate::run::failure;
use crate::{Exit, input, say};
use facts::Facts;

/// Inspects one input.
pub(crate) fn inspect(args: &InspectArgs) -> Exit {
    match look(args) {
        Ok(facts) if args.json => match serde_json::to_string_pretty(&facts) {
            Ok(json) => {
                say::out(json);
                Exit::Done
            }
            Err(error) => {
                say::error(error);
                Exit::Failed
            }
        },
        Ok(facts) => {
            say::out(text::of(&facts).trim_end());
            Exit::Done
        }
        Err(error) => {
            say::error(&error);
            failure(&error)
        }
    }
}

fn look(args: &InspectArgs) -> Result<Facts, RunError> {
    let scene = input::scene(&args.input, &args.scene)?;
    let prepared = prepare(&scene)?;
    Ok(Facts::of(&args.input.display().to_string(), &scene, &prepared))
}
