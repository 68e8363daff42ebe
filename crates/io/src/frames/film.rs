//! Writes the film of a run. Until the run ends, its frames are kept in the file `NAME.webp.data` or `NAME.gif.data`, as
//! those of a page.

use std::{fs, io};

use supple::{Executor, Simulation};

use super::page::{self, PageWriter, run_of};
use super::page_data::data_path;
use super::record::{Compare, Record, hash_of_frames};
use super::single_file::{no_frames, other_frames};
use super::sink::{BodyFrame, Ending, FrameRun, FrameSink};
use super::{Format, OutputError, Sequence, Source};
use crate::count::counted;
use crate::file::write_durably;
use crate::film::{Color, Coloring, FilmFile, FilmOptions, read_facts, write_film};
use crate::html::{Playback, Run};

/// A film that is being written.
#[derive(Debug)]
pub(super) struct FilmWriter {
    sequence: Sequence,
    /// The frames.
    page: PageWriter,
    options: FilmOptions,
    executor: Executor,
}

impl FilmWriter {
    /// Starts a film, or continues the frames of an unfinished one.
    pub(super) fn open(sequence: Sequence, run: &FrameRun<'_>) -> Result<Self, OutputError> {
        let colors: Vec<_> = run.sources.iter().map(colors).collect();
        let options = run.options.film.clone();
        let has_volumes = options.coloring == Coloring::Volume;
        let describe = |header: &mut crate::html::Header| header.set_colors(&colors);
        let page = PageWriter::open_with(sequence.clone(), run, has_volumes, describe)?;
        Ok(Self { sequence, page, options, executor: Executor::new(run.simulation.threads()) })
    }
}

/// Returns the color of the material of each face of a body, if it has one.
fn colors(source: &Source<'_>) -> Vec<Option<Color>> {
    source.file().map_or_else(Vec::new, |(document, part)| document.face_colors(part))
}

impl FrameSink for FilmWriter {
    fn push_body(&mut self, body: &BodyFrame<'_>) -> Result<Option<Record>, OutputError> {
        self.page.push_body(body)
    }

    fn finish_frame(&mut self, simulation: &Simulation) -> Result<Option<Record>, OutputError> {
        self.page.finish_frame(simulation)
    }

    fn discard(&mut self) {
        self.page.discard();
    }

    fn take_unsynced(&mut self) -> Vec<std::path::PathBuf> {
        self.page.take_unsynced()
    }

    fn finish(self: Box<Self>, ending: Ending) -> Result<Vec<String>, OutputError> {
        let Self { sequence, page, options, executor } = *self;
        let (path, data_path) = (sequence.path(0), data_path(&sequence));
        let data = page.into_data();
        let mut run = run_of(&data_path, &data)?;
        if run.header.frames == 0 {
            return Err(OutputError::NoFrames { path });
        }
        let read = |error| OutputError::io("read", &data_path)(error);
        let facts = facts(run.header.frames, hash(&mut run).map_err(read)?);
        let mut playback = Playback::new(run).map_err(read)?;
        let kind = if sequence.format == Format::Gif { FilmFile::Gif } else { FilmFile::Webp };
        write_durably(&path, |file| write_film(file, kind, &mut playback, &options, &executor, &facts))
            .map_err(OutputError::io("write", &path))?;
        drop(playback);
        if ending == Ending::Complete {
            drop(data);
            fs::remove_file(&data_path).map_err(OutputError::io("remove", &data_path))?;
        }
        Ok(Vec::new())
    }
}

/// Returns what a film says of its frames.
fn facts(frames: usize, hash: u64) -> String {
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

/// Compares the frames of an unfinished film, or a finished one, with the records of the frames. Returns the problem if
/// they differ. `continues`: whether frames are added.
pub(super) fn check(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
    continues: bool,
) -> Result<Option<String>, OutputError> {
    let path = sequence.path(0);
    if records.is_empty() || data_path(sequence).exists() {
        return page::check(sequence, records, compare);
    }
    if continues {
        return Ok(Some(no_frames(&path)));
    }
    if !path.is_file() {
        return Ok(Some(format!("{} is missing", path.display())));
    }
    let found = read_facts(&path).map_err(OutputError::io("read", &path))?;
    let is_same = found == Some(facts(records.len(), hash_of_frames(records)));
    Ok((!is_same).then(|| other_frames(&path)))
}

/// Returns whether a film whose run has ended has its final form.
pub(super) fn is_complete(sequence: &Sequence) -> bool {
    !data_path(sequence).exists()
}
