//! Opens the files of a sequence in its format.

use super::sink::{FrameRun, FrameSink};
use super::{OutputError, Sequence};

/// Returns an error if a sequence of a run cannot be written. Changes nothing. `body`: as for [`open_sink`].
pub(crate) fn check_run(sequence: &Sequence, body: usize, run: &FrameRun<'_>) -> Result<(), OutputError> {
    (sequence.format.kind().check_run)(sequence, body, run)
}

/// Starts the files of a sequence, or continues them after the frames that `run` keeps. `body`: the index of the body
/// of a sequence that has one body.
pub(crate) fn open_sink(
    sequence: Sequence,
    body: usize,
    run: &FrameRun<'_>,
) -> Result<Box<dyn FrameSink>, OutputError> {
    (sequence.format.kind().open)(sequence, body, run)
}
