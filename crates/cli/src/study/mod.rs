//! `supple study`: what accuracy costs.

mod progress;
mod scene;

use crate::args::StudyArgs;
use crate::{Exit, say};

/// Runs the study that is asked for.
pub(crate) fn study(args: &StudyArgs) -> Exit {
    match &args.input {
        Some(input) => scene::study(args, input),
        None => {
            let subject = if args.sums { "sums" } else { "stability" };
            say::error(format_args!("{subject}: not there yet"));
            Exit::Failed
        }
    }
}
