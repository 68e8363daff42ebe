//! The frame files of a job: a writer for each body and format, and the page of the run.

use supple::{Displayed, Simulation, VolumeReport};

use super::job::Job;
use super::prepare::Prepared;
use crate::frames::{FrameWriter, OutputError, PageWriter, Record};
use crate::html::Header;

/// The open frame files of a job.
#[derive(Debug)]
pub(super) struct Output {
    /// For each body, its writers and the indices of their sequences.
    bodies: Vec<Vec<(usize, FrameWriter)>>,
    /// The page and the index of its sequence.
    page: Option<(usize, PageWriter)>,
}

/// The evaluated surface of a body.
pub(super) struct Surface<'a> {
    /// Positions, one per mesh vertex.
    pub(super) positions: &'a [[f32; 3]],
    /// Normals, one per mesh vertex; empty if [`Output::needs_normals`] is false.
    pub(super) normals: &'a [[f32; 3]],
}

impl Output {
    /// Opens the files, which continue at frame number `next`, or start a sequence if `next` is `None`.
    pub(super) fn open(job: &Job, prepared: &Prepared, next: Option<u64>) -> Result<Self, OutputError> {
        let simulation = &prepared.simulation;
        let mut output = Self { bodies: prepared.inputs.iter().map(|_| Vec::new()).collect(), page: None };
        let mut body = 0;
        for (index, sequence) in job.sequences().into_iter().enumerate() {
            if sequence.format.is_per_run() {
                let (name, fps) = (job.name(), job.scene.simulation.fps);
                let (header, arrays) = Header::new(simulation, &name, fps, sequence.first, sequence.every);
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

    /// Returns whether a file of a body needs normals.
    pub(super) fn needs_normals(&self, body: usize) -> bool {
        self.bodies[body].iter().any(|(_, writer)| writer.needs_normals())
    }

    /// Returns whether volume reports are needed.
    pub(super) fn needs_volumes(&self) -> bool {
        self.page.is_some()
    }

    /// Writes a frame of a body, and appends the records of its files to those of their sequences. The page takes part
    /// of the frame, and `volume` if it is given.
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
            records[*sequence].push(writer.write_recorded(number, surface.positions, surface.normals)?);
        }
        if let (Some((_, page)), Some(volume)) = (&mut self.page, volume) {
            let volumes = [volume.rest, volume.before, volume.after];
            page.push_body(number, surface.positions, evaluated.positions(), volumes)?;
        }
        Ok(())
    }

    /// Writes the frame of the page after all bodies, and appends its record.
    pub(super) fn write_page(
        &mut self,
        simulation: &Simulation,
        records: &mut [Vec<Record>],
    ) -> Result<(), OutputError> {
        if let Some((sequence, page)) = &mut self.page {
            records[*sequence].push(page.write(simulation)?);
        }
        Ok(())
    }

    /// Returns when the contents of all written frames are on disk.
    pub(super) fn sync(&mut self) -> Result<(), OutputError> {
        let writers = self.bodies.iter_mut().flatten().map(|(_, writer)| writer);
        FrameWriter::sync_all(writers, self.page.as_ref().map(|(_, page)| page))
    }

    /// Gives all files their final form and names.
    pub(super) fn finish(&mut self) -> Result<(), OutputError> {
        let writers = self.bodies.drain(..).flatten();
        writers.map(|(_, writer)| writer).try_for_each(FrameWriter::finish)?;
        self.page.take().map_or(Ok(()), |(_, page)| page.finish())
    }
}
