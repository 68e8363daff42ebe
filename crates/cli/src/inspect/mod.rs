//! `supple inspect`: prints facts about a scene without running it.

mod facts;
mod text;

use supple_io::run::{RunError, prepare};

use crate::args::InspectArgs;
use crate::exit::Exit;
use crate::terminal;
use facts::Facts;

/// Inspects one input.
pub(crate) fn inspect(args: &InspectArgs) -> Exit {
    match collect(args) {
        Ok(facts) if args.json => {
            terminal::out(serde_json::to_string_pretty(&facts).expect("facts are plain data"));
            Exit::Done
        }
        Ok(facts) => {
            terminal::out(text::format(&facts, args.plan).trim_end());
            Exit::Done
        }
        Err(error) => {
            terminal::error(&error);
            Exit::from(&error)
        }
    }
}

/// Builds the scene and collects its facts.
fn collect(args: &InspectArgs) -> Result<Facts, RunError> {
    let scene = args.scene.open(&args.input)?;
    let prepared = prepare(&scene)?;
    Ok(Facts::of(&args.input.display().to_string(), &scene, &prepared))
}
