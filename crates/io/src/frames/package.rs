//! Writes the USDZ package of a run. Until the run ends, its stage is in `NAME.usdz.usd.part`.

use std::fs::{self, File};
use std::path::PathBuf;

use supple::Simulation;

use super::record::{Compare, Record};
use super::single_file::{check_frames, no_frames, without};
use super::sink::{BodyFrame, Ending, FrameRun, FrameSink};
use super::stage::{self, StageWriter};
use super::{OutputError, Sequence};
use crate::file::{part_path, write_durably};
use crate::usd::{FRAMES, PACKAGED_STAGE};

/// A package that is being written.
#[derive(Debug)]
pub(super) struct PackageWriter {
    path: PathBuf,
    stage: StageWriter,
}

impl PackageWriter {
    /// Starts a package, or continues the stage of an unfinished one.
    pub(super) fn open(sequence: &Sequence, run: &FrameRun<'_>) -> Result<Self, OutputError> {
        let stage = StageWriter::open(&sequence.frames(), run, true)?;
        Ok(Self { path: sequence.path(0), stage })
    }
}

impl FrameSink for PackageWriter {
    fn push_body(&mut self, body: &BodyFrame<'_>) -> Result<Option<Record>, OutputError> {
        self.stage.push_body(body)
    }

    fn finish_frame(&mut self, simulation: &Simulation) -> Result<Option<Record>, OutputError> {
        self.stage.finish_frame(simulation)
    }

    fn discard(&mut self) {
        self.stage.discard();
    }

    fn take_unsynced(&mut self) -> Vec<PathBuf> {
        self.stage.take_unsynced()
    }

    /// Writes the package. When the run is complete, removes the stage.
    fn finish(self: Box<Self>, ending: Ending) -> Result<Vec<String>, OutputError> {
        let Self { path, stage } = *self;
        let (part, packed) = stage.complete()?;
        let mut stage = File::open(&part).map_err(OutputError::io("read", &part))?;
        write_durably(&path, |file| packed.write(file, &mut stage))
            .map_err(OutputError::io("write", &path))?;
        if ending == Ending::Complete {
            drop(stage);
            fs::remove_file(&part).map_err(OutputError::io("remove", &part))?;
        }
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(without(&file, packed.left_out()).collect())
    }
}

/// Compares the frames of an unfinished package, or a finished one, with the records of the frames. Returns the problem if
/// they differ. `continues`: whether frames are added.
pub(super) fn check(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
    continues: bool,
) -> Result<Option<String>, OutputError> {
    let stage = sequence.frames();
    if records.is_empty() || part_path(&stage.path(0)).exists() {
        return stage::check(&stage, records, compare);
    }
    let path = sequence.path(0);
    if continues {
        return Ok(Some(no_frames(&path)));
    }
    let length = match fs::metadata(&path) {
        Ok(found) if found.is_file() => found.len(),
        _ => return Ok(Some(format!("{} is missing", path.display()))),
    };
    let start = PACKAGED_STAGE + FRAMES;
    if length < start + records.iter().map(|record| record.bytes).sum::<u64>() {
        return Ok(Some(format!("{} is incomplete or was changed", path.display())));
    }
    check_frames(sequence, records, compare, start)
}
