//! The frame files of a run: the sinks of each body, and those of files with all bodies.

use std::path::PathBuf;

use supple::Simulation;

use crate::file::sync_files;
use crate::frames::{BodyFrame, Format, FrameRun, FrameSink, OutputError, Record, Sequence, open_sink};
use crate::space::FileSpace;

/// A sink and the index of its sequence.
type Sink = (usize, Box<dyn FrameSink>);

/// The open frame files of a run.
#[derive(Debug)]
pub(super) struct Output {
    /// For each body, the sinks of its files.
    bodies: Vec<Vec<Sink>>,
    /// The sinks of the files with all bodies, in the order of the formats.
    run: Vec<Sink>,
    /// Coordinates of the files.
    space: FileSpace,
}

impl Output {
    /// Opens the files of `sequences`. Those with one body are, for each format, in the order of the bodies.
    pub(super) fn open(sequences: Vec<Sequence>, run: &FrameRun<'_>) -> Result<Self, OutputError> {
        let mut bodies: Vec<Vec<Sink>> = run.sources.iter().map(|_| Vec::new()).collect();
        let mut with_all_bodies: Vec<(Format, Sink)> = Vec::new();
        let mut body = 0;
        for (index, sequence) in sequences.into_iter().enumerate() {
            let format = sequence.format;
            let sink = (index, open_sink(sequence, body, run)?);
            if format.is_per_run() {
                with_all_bodies.push((format, sink));
            } else {
                bodies[body].push(sink);
                body = (body + 1) % bodies.len();
            }
        }
        with_all_bodies.sort_by_key(|(format, _)| *format as u8);
        let of_run = with_all_bodies.into_iter().map(|(_, sink)| sink).collect();
        Ok(Self { bodies, run: of_run, space: run.space })
    }

    /// Returns whether a file of a body needs normals.
    pub(super) fn needs_normals(&self, body: usize) -> bool {
        self.bodies[body].iter().chain(&self.run).any(|(_, sink)| sink.needs_normals())
    }

    /// Converts an evaluated surface to the coordinates of the files.
    pub(super) fn convert(&self, positions: &mut [[f32; 3]], normals: &mut [[f32; 3]]) {
        self.space.convert_positions(positions);
        self.space.convert_directions(normals);
    }

    /// Adds the body with the index `body` to the frame, and appends the records of complete frames to those of their
    /// sequences.
    pub(super) fn push_body(
        &mut self,
        body: usize,
        frame: &BodyFrame<'_>,
        records: &mut [Vec<Record>],
    ) -> Result<(), OutputError> {
        for (sequence, sink) in self.bodies[body].iter_mut().chain(&mut self.run) {
            records[*sequence].extend(sink.push_body(frame)?);
        }
        Ok(())
    }

    /// Completes the frame after all bodies, and appends its records.
    pub(super) fn finish_frame(
        &mut self,
        simulation: &Simulation,
        records: &mut [Vec<Record>],
    ) -> Result<(), OutputError> {
        for (sequence, sink) in &mut self.run {
            records[*sequence].extend(sink.finish_frame(simulation)?);
        }
        Ok(())
    }

    /// Removes the bodies of a frame that is not complete.
    pub(super) fn discard(&mut self) {
        self.run.iter_mut().for_each(|(_, sink)| sink.discard());
    }

    /// Returns when the contents of all written frames are on disk. Their names are on disk when the directory is
    /// synchronized too.
    pub(super) fn sync(&mut self) -> Result<(), OutputError> {
        let sinks = self.run.iter_mut().chain(self.bodies.iter_mut().flatten());
        let paths: Vec<PathBuf> = sinks.flat_map(|(_, sink)| sink.take_unsynced()).collect();
        sync_files(&paths).map_err(|(path, error)| OutputError::io("write", path)(error))
    }

    /// Gives all files their final form and names.
    pub(super) fn finish(&mut self) -> Result<(), OutputError> {
        let sinks = self.bodies.drain(..).flatten().chain(self.run.drain(..));
        sinks.map(|(_, sink)| sink).try_for_each(FrameSink::finish)
    }
}
