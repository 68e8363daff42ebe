//! `supple study`: what accuracy costs.

mod progress;
mod scene;
mod stability;
mod sums;

use crate::args::StudyArgs;
use crate::{Exit, say};

/// Runs the study that is asked for.
pub(crate) fn study(args: &StudyArgs) -> Exit {
    let result = match &args.input {
        Some(input) => scene::study(args, input),
        None if args.sums => sums::study(args),
        None => stability::study(args),
    };
    result.unwrap_or_else(|error| {
        say::error(&error);
        if error.is_input() { Exit::Input } else { Exit::Failed }
    })
}
