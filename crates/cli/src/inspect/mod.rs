//! `supple inspect`: prints facts about a scene without running it.

mod contact;
mod estimate;
mod facts;
mod material;
mod mesh;
mod placed;
mod text;
mod warnings;

use supple_io::run::{RunError, prepare};

use crate::args::InspectArgs;
use crate::exit::Exit;
use crate::terminal;
use estimate::Estimate;
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
    let mut facts = Facts::new(&args.input.display().to_string(), &scene, &prepared);
    if args.json {
        let bytes_per_frame = facts.bodies.iter().map(|body| body.frame_bytes).sum();
        facts.estimate = Some(Estimate::measure(prepared.simulation, prepared.substeps, bytes_per_frame));
    }
    Ok(facts)
}
