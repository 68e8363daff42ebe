//! Opens the files of a sequence in its format.

use super::page::PageWriter;
use super::sink::{FrameRun, FrameSink};
use super::stage::StageWriter;
use super::{Format, FrameWriter, OutputError, Sequence};

/// Starts the files of a sequence, or continues them after the frames that `run` keeps. `body`: the index of the body
/// of a sequence that has one body.
pub(crate) fn open_sink(
    sequence: Sequence,
    body: usize,
    run: &FrameRun<'_>,
) -> Result<Box<dyn FrameSink>, OutputError> {
    Ok(match sequence.format {
        Format::Obj | Format::Ply | Format::Pc2 => Box::new(FrameWriter::of_run(sequence, body, run)?),
        Format::Usd => Box::new(StageWriter::open(&sequence, run)?),
        Format::Html => Box::new(PageWriter::open(sequence, run)?),
    })
}
