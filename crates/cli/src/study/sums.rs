//! `supple study --sums`: the summation alone.

use supple_study::{Outcome, StudyError, SumsStudy};

use super::progress::Watch;
use crate::args::StudyArgs;
use crate::{Exit, interrupt, say};

/// Studies the summation.
pub(super) fn study(args: &StudyArgs) -> Result<Exit, StudyError> {
    interrupt::listen();
    let mut watch = Watch::new(args.quiet);
    let result = SumsStudy { directory: args.output.clone(), quick: args.quick }.run(&mut watch);
    watch.finish();
    let (report, outcome) = result?;
    say::out(report.table());
    say::out(format_args!("written to {}: sums.csv, sums.json", args.output.display()));
    Ok(if outcome == Outcome::Stopped { Exit::Interrupted } else { Exit::Done })
}
