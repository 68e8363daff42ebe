//! The frame files of a job: a writer for each body and format, and the USD stage and the page of the run.

use supple::{Displayed, Simulation, VolumeReport};

use super::job::Job;
use super::prepare::{Input, Prepared};
use crate::frames::{Format, FrameWriter, OutputError, PageWriter, Pieces, Record, Sequence, StageWriter};
use crate::html::Header;
use crate::space::FileSpace;
use crate::usd::StageDescription;

/// The open frame files of a job.
#[derive(Debug)]
pub(super) struct Output {
    /// For each body, its writers and the indices of their sequences.
    bodies: Vec<Vec<(usize, FrameWriter)>>,
    /// The USD stage and the index of its sequence.
    pub(super) stage: Option<(usize, StageWriter)>,
    /// The page and the index of its sequence.
    pub(super) page: Option<(usize, PageWriter)>,
    /// Coordinates of the files.
    space: FileSpace,
}

/// The evaluated surface of a body.
pub(super) struct Surface<'a> {
    /// Positions, one per mesh vertex.
    pub(super) positions: &'a [[f32; 3]],
    /// Normals, one per mesh vertex; empty if [`Output::needs_normals`] is false.
    pub(super) normals: &'a [[f32; 3]],
    /// The pieces of a broken body.
    pub(super) pieces: Option<Pieces<'a>>,
}

impl Output {
    /// No files, for a number of bodies.
    pub(super) fn new(bodies: usize, space: FileSpace) -> Self {
        Self { bodies: (0..bodies).map(|_| Vec::new()).collect(), stage: None, page: None, space }
    }

    /// Opens the files, which continue at frame number `next`, or start a sequence if `next` is `None`.
    pub(super) fn open(job: &Job, prepared: &Prepared, next: Option<u64>) -> Result<Self, OutputError> {
        let simulation = &prepared.simulation;
        let space = job.space();
        let mut output = Self::new(prepared.inputs.len(), space);
        let mut body = 0;
        for (index, sequence) in job.sequences().into_iter().enumerate() {
            if sequence.format == Format::Usd {
                let kept = next.map(|next| sequence.frames_before(next));
                output.stage = Some((index, open_stage(job, prepared, &sequence, kept)?));
                continue;
            }
            if sequence.format == Format::Html {
                let (name, fps) = (job.name(), job.fps());
                let (header, arrays) =
                    Header::new(simulation, &name, fps, sequence.first, sequence.every, space);
                let page = match next {
                    None => PageWriter::create(sequence, &header, &arrays)?,
                    Some(next) => {
                        let frames = sequence.frames_before(next);
                        PageWriter::resume(sequence, &header, frames)?
                    }
                };
                output.page = Some((index, page));
                continue;
            }
            let mut writer = FrameWriter::open(sequence, prepared.inputs[body].source(), next)?;
            writer.set_executor(simulation.executor());
            output.bodies[body].push((index, writer));
            body = (body + 1) % prepared.inputs.len();
        }
        Ok(output)
    }

    /// Completes the USD stage of an earlier run after its first `frames` frames.
    pub(super) fn complete_stage(job: &Job, prepared: &Prepared, frames: u64) -> Result<(), OutputError> {
        let stages = job.sequences().into_iter().filter(|sequence| sequence.format == Format::Usd);
        for sequence in stages {
            open_stage(job, prepared, &sequence, Some(frames))?.finish()?;
        }
        Ok(())
    }

    /// Returns whether a file of a body needs normals.
    pub(super) fn needs_normals(&self, body: usize) -> bool {
        self.bodies[body].iter().any(|(_, writer)| writer.needs_normals())
    }

    /// Returns whether volume reports are needed.
    pub(super) fn needs_volumes(&self) -> bool {
        self.page.is_some()
    }

    /// Converts an evaluated surface to the coordinates of the files.
    pub(super) fn convert(&self, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) {
        self.space.convert_positions(positions);
        self.space.convert_directions(normals);
    }

    /// Writes a frame of a body, converted by [`Output::convert`], and appends the records of its files to those of
    /// their sequences. The stage and the page take part of the frame, and the page `volume` if it is given.
    pub(super) fn write_body(
        &mut self,
        number: u64,
        body: usize,
        surface: &Surface<'_>,
        evaluated: &Displayed<'_>,
        volume: Option<&VolumeReport>,
        records: &mut [Vec<Record>],
    ) -> Result<(), OutputError> {
        for (sequence, writer) in &mut self.bodies[body] {
            records[*sequence].push(writer.write_recorded(
                number,
                surface.positions,
                surface.normals,
                surface.pieces.as_ref(),
            )?);
        }
        if let Some((_, stage)) = &mut self.stage {
            stage.push_body(number, surface.positions, surface.pieces.as_ref())?;
        }
        let space = self.space;
        if let (Some((_, page)), Some(volume)) = (&mut self.page, volume) {
            let volumes = [volume.rest, volume.before, volume.after].map(|volume| space.volume(volume));
            let lattice = evaluated.positions().map(|position| space.position(position.into()));
            page.push_body(number, surface.positions, lattice, volumes, surface.pieces.as_ref())?;
        }
        Ok(())
    }

    /// Writes the frame of the stage and of the page after all bodies, and appends their records.
    pub(super) fn write_run(
        &mut self,
        simulation: &Simulation,
        records: &mut [Vec<Record>],
    ) -> Result<(), OutputError> {
        if let Some((sequence, stage)) = &mut self.stage {
            records[*sequence].push(stage.write(simulation)?);
        }
        if let Some((sequence, page)) = &mut self.page {
            records[*sequence].push(page.write(simulation, self.space)?);
        }
        Ok(())
    }

    /// Forgets the bodies of a frame that is not complete.
    pub(super) fn discard(&mut self) {
        if let Some((_, stage)) = &mut self.stage {
            stage.discard();
        }
        if let Some((_, page)) = &mut self.page {
            page.discard();
        }
    }

    /// Returns when the contents of all written frames are on disk.
    pub(super) fn sync(&mut self) -> Result<(), OutputError> {
        let writers = self.bodies.iter_mut().flatten().map(|(_, writer)| writer);
        let stage = self.stage.as_ref().map(|(_, stage)| stage.part_path());
        let page = self.page.as_ref().map(|(_, page)| page.path());
        FrameWriter::sync_all(writers, stage.into_iter().chain(page))
    }

    /// Gives all files their final form and names.
    pub(super) fn finish(&mut self) -> Result<(), OutputError> {
        let writers = self.bodies.drain(..).flatten();
        writers.map(|(_, writer)| writer).try_for_each(FrameWriter::finish)?;
        self.stage.take().map_or(Ok(()), |(_, stage)| stage.finish())?;
        self.page.take().map_or(Ok(()), |(_, page)| page.finish())
    }
}

/// Starts the USD stage of a job, or continues it after its first `kept` frames.
fn open_stage(
    job: &Job,
    prepared: &Prepared,
    sequence: &Sequence,
    kept: Option<u64>,
) -> Result<StageWriter, OutputError> {
    let description = StageDescription {
        directory: sequence.directory.clone(),
        space: job.space(),
        meters_per_unit: job.scene.output.meters_per_unit,
        fps: job.fps(),
        first: sequence.first,
        every: sequence.every,
    };
    let sources = prepared.inputs.iter().map(Input::source);
    StageWriter::open(sequence, &prepared.simulation, sources, description, kept)
}
