//! `supple inspect`: prints facts about a scene without running it.

mod contact;
mod facts;
mod material;
mod placed;
mod text;
mod warnings;

use supple_io::run::{RunError, prepare};

use crate::args::InspectArgs;
use crate::exit::Exit;
use crate::terminal;
use facts::Facts;

/// Prints the facts about one input.
pub(crate) fn inspect(args: &InspectArgs) -> Exit {
    match collect(args) {
        Ok(facts) if args.json => {
            terminal::print_data(
                serde_json::to_string_pretty(&facts).expect("facts can be serialized as JSON"),
            );
            Exit::Done
        }
        Ok(facts) => {
            terminal::print(text::format(&facts, args.plan).trim_end());
            Exit::Done
        }
        Err(error) => {
            terminal::print_error(&error);
            Exit::from(&error)
        }
    }
}

/// Builds the simulation of the scene and collects the facts about both.
fn collect(args: &InspectArgs) -> Result<Facts, RunError> {
    let scene = args.scene.open(&args.input)?;
    let prepared = prepare(&scene)?;
    Ok(Facts::new(&args.input.display().to_string(), &scene, &prepared))
}
