//! Writes the film of a run. Until the run ends, its frames are kept in the file `NAME.webp.data` or `NAME.gif.data`, as
//! those of a page.

use std::{fs, io};

use supple::Executor;

use super::page_data::{Data, data_path, run_of};
use super::record::{Record, hash_of_frames};
use super::sink::{Ending, FrameRun};
use super::{Format, OutputError, Sequence, Source};
use crate::count::counted;
use crate::file::write_durably;
use crate::film::{Color, Coloring, FilmFile, FilmOptions, write_film};
use crate::html::{Playback, Run};

/// How a film is written.
#[derive(Debug)]
pub(super) struct Film {
    kind: FilmFile,
    options: FilmOptions,
    executor: Executor,
}

impl Film {
    /// Returns the film of a sequence; `None` if the sequence is a page.
    pub(super) fn of(sequence: &Sequence, run: &FrameRun<'_>) -> Option<Self> {
        let kind = match sequence.format {
            Format::Film => FilmFile::Webp,
            Format::Gif => FilmFile::Gif,
            _ => return None,
        };
        let executor = Executor::new(run.simulation.threads());
        Some(Self { kind, options: run.options.film.clone(), executor })
    }

    /// Returns whether the film shows the volumes of the bodies.
    pub(super) fn has_volumes(&self) -> bool {
        self.options.coloring == Coloring::Volume
    }

    /// Writes the film of the data. When the run is complete, removes the data.
    pub(super) fn write(&self, sequence: &Sequence, data: Data, ending: Ending) -> Result<(), OutputError> {
        let (path, data_path) = (sequence.path(0), data_path(sequence));
        let mut run = run_of(&data_path, &data)?;
        if run.header.frames == 0 {
            return Err(OutputError::NoFrames { path });
        }
        let read = |error| OutputError::io("read", &data_path)(error);
        let facts = facts(run.header.frames, hash(&mut run).map_err(read)?);
        let mut playback = Playback::new(run).map_err(read)?;
        let Self { kind, options, executor } = self;
        write_durably(&path, |file| write_film(file, *kind, &mut playback, options, executor, &facts))
            .map_err(OutputError::io("write", &path))?;
        drop(playback);
        if ending == Ending::Complete {
            drop(data);
            fs::remove_file(&data_path).map_err(OutputError::io("remove", &data_path))?;
        }
        Ok(())
    }
}

/// Returns the color of the material of each face of a body, if it has one.
pub(super) fn colors(source: &Source<'_>) -> Vec<Option<Color>> {
    source.file().map_or_else(Vec::new, |(document, part)| document.face_colors(part))
}

/// Returns what a film says of its frames.
pub(super) fn facts(frames: usize, hash: u64) -> String {
    format!("{}, {hash:016x}", counted(frames, "frame"))
}

/// Returns the hash of all frames.
fn hash(run: &mut Run<'_>) -> io::Result<u64> {
    let mut frame = Vec::new();
    let records = (0..run.header.frames).map(|index| {
        run.frames.read_frame(index, &mut frame)?;
        Ok(Record::of(&frame))
    });
    Ok(hash_of_frames(&records.collect::<io::Result<Vec<_>>>()?))
}

/// Returns whether a film whose run has ended has its final form.
pub(super) fn is_complete(sequence: &Sequence) -> bool {
    !data_path(sequence).exists()
}
