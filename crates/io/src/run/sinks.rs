//! Where the frames of a job go: one writer a body.

use std::path::PathBuf;

use super::error::RunError;
use super::job::Job;
use super::prepare::Prepared;
use crate::frames::{FrameWriter, OutputError, Sequence, part_of};

/// The frame writers of a job, one for each body.
#[derive(Debug, Default)]
pub(super) struct Sinks {
    writers: Vec<FrameWriter>,
}

impl Sinks {
    /// Starts every sequence anew.
    pub(super) fn create(job: &Job, prepared: &Prepared) -> Result<Self, RunError> {
        Self::open(job, prepared, FrameWriter::create)
    }

    /// Goes on with every sequence after a frame, counted from 0.
    pub(super) fn resume(job: &Job, prepared: &Prepared, frame: u32) -> Result<Self, RunError> {
        let next = job.number(frame) + 1;
        Self::open(job, prepared, |sequence, source| FrameWriter::resume(sequence, source, next))
    }

    fn open(
        job: &Job,
        prepared: &Prepared,
        open: impl Fn(Sequence, crate::frames::Source<'_>) -> Result<FrameWriter, OutputError>,
    ) -> Result<Self, RunError> {
        let writers = job.sequences().into_iter().zip(&prepared.inputs).map(|(sequence, input)| {
            let mut writer = open(sequence, input.source())?;
            writer.share(prepared.simulation.executor());
            Ok(writer)
        });
        Ok(Self { writers: writers.collect::<Result<_, RunError>>()? })
    }

    /// Whether the frames of a body hold normals.
    pub(super) fn needs_normals(&self, body: usize) -> bool {
        self.writers[body].needs_normals()
    }

    /// Writes a frame of a body, by its number.
    pub(super) fn write(
        &mut self,
        body: usize,
        number: u64,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(), RunError> {
        Ok(self.writers[body].write(number, positions, normals)?)
    }

    /// Gives point caches their final names.
    pub(super) fn finish(self) -> Result<(), RunError> {
        Ok(self.writers.into_iter().try_for_each(FrameWriter::finish)?)
    }
}

/// The first file that should be there after frame `done`, and is not.
pub(super) fn missing(job: &Job, done: u32) -> Option<PathBuf> {
    job.sequences().into_iter().find_map(|sequence| {
        let file = |frame: u32| sequence.path(job.number(frame));
        let kept = (0..=done).filter(|&frame| job.keeps(frame));
        match sequence.format {
            crate::frames::Format::Pc2 => {
                // A sequence that is done has its own name.
                let under_way = done < job.scene.simulation.frames;
                let there = |path: &PathBuf| path.is_file() || under_way && part_of(path).is_file();
                Some(file(0)).filter(|path| !there(path))
            }
            _ => kept.map(file).find(|path| !path.is_file()),
        }
    })
}
