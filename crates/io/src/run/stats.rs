//! Writes statistics as CSV or JSON, with one row per written frame and body. The file is valid after every
//! frame.

use std::fs::File;
use std::io::{ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::Serialize;

use super::error::RunError;
use crate::file::{self, parent, sync_directory};
use crate::frames::{Record, Recorder};
use supple::{Body, ContactPoint, DisplayTimes, Touched, VolumeReport};

/// A row of the statistics: times and results of one frame of one body. The columns are the fields, in order.
/// The columns `ms_...` are wall-clock times in milliseconds. Volumes are cubic lengths.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// Number of the frame, as in its file name.
    pub frame: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Name of the body.
    pub body: String,
    /// Time of the steps since the previous row of the body, divided by the number of bodies.
    pub ms_step: f64,
    /// Time of the volume correction.
    pub ms_volume: f64,
    /// Time of the mesh update, including normals.
    pub ms_embed: f64,
    /// Time of writing the frame.
    pub ms_write: f64,
    /// Rest volume, by the measure of the body.
    pub volume_rest: f64,
    /// Volume before the correction.
    pub volume_before: f64,
    /// Volume after the correction.
    pub volume_after: f64,
    /// Scale of the displacement field of the correction, a length.
    pub lambda: f64,
    /// Remaining volume error after the correction, as a fraction of the rest volume.
    pub residual: f64,
    /// Whether lambda reached its cap.
    pub capped: bool,
    /// Kinetic energy of the lattice, kg length^2/s^2.
    pub energy_kinetic: f64,
    /// Speed of the fastest lattice vertex, length/s.
    pub max_speed: f64,
    /// Number of contacts with bodies and colliders in the last step; 0 for a body that sleeps, which is not stepped.
    pub contacts: usize,
    /// Greatest depth of these contacts, a length; 0 if the body touches nothing.
    pub overlap: f64,
}

/// The contacts of a body in the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Touching {
    /// Number of contacts.
    count: usize,
    /// Greatest depth, at least 0.
    depth: f64,
}

impl Touching {
    /// Returns those of a body, the `index`-th one. A sleeping body has none: it is not stepped, and a checkpoint does
    /// not contain the contacts with which it fell asleep.
    pub(super) fn of(index: usize, body: &Body, contacts: &[ContactPoint]) -> Self {
        if body.is_asleep() {
            return Self::default();
        }
        let own =
            contacts.iter().filter(|contact| contact.body == index || contact.other == Touched::Body(index));
        own.fold(Self::default(), |Self { count, depth }, contact| Self {
            count: count + 1,
            depth: depth.max(contact.depth),
        })
    }
}

/// Wall-clock times of one frame of one body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    /// Time of the steps since the previous row, divided by the number of bodies.
    pub(super) step: Duration,
    /// Times of the volume correction and of the mesh update.
    pub(super) display: DisplayTimes,
    /// Time of writing the frame.
    pub(super) write: Duration,
}

impl Row {
    /// Returns the row of a body in its current state.
    pub(super) fn new(
        frame: u64,
        time: f64,
        body: &Body,
        volume: &VolumeReport,
        times: Times,
        touching: Touching,
    ) -> Self {
        let milliseconds = |duration: Duration| duration.as_secs_f64() * 1e3;
        let masses = body.masses();
        let speeds_squared: Vec<f64> =
            body.velocities().iter().map(|velocity| velocity.norm_squared()).collect();
        Self {
            frame,
            time,
            body: body.name().to_owned(),
            ms_step: milliseconds(times.step),
            ms_volume: milliseconds(times.display.volume),
            ms_embed: milliseconds(times.display.mesh_update),
            ms_write: milliseconds(times.write),
            volume_rest: volume.rest,
            volume_before: volume.before,
            volume_after: volume.after,
            lambda: volume.lambda,
            residual: volume.residual,
            capped: volume.capped,
            energy_kinetic: masses.iter().zip(&speeds_squared).map(|(mass, v2)| mass * v2 / 2.0).sum(),
            max_speed: speeds_squared.iter().copied().fold(0.0, f64::max).sqrt(),
            contacts: touching.count,
            overlap: touching.depth,
        }
    }
}

/// Format of a statistics file. The extension of the file determines it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Csv,
    Json,
}

impl Kind {
    fn from_path(path: &Path) -> Result<Self, RunError> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("json") => Ok(Self::Json),
            _ => Err(RunError::StatsName { path: path.to_owned() }),
        }
    }

    /// Returns the text before the rows.
    fn head(self) -> std::io::Result<Vec<u8>> {
        match self {
            Self::Csv => {
                let mut text = csv_lines(&[Row::default()], true)?;
                text.truncate(1 + text.iter().position(|&byte| byte == b'\n').unwrap_or(0));
                Ok(text)
            }
            Self::Json => Ok(b"[\n".to_vec()),
        }
    }

    /// Returns the text of rows with their separators. `is_first`: whether the rows are the first in the
    /// file.
    fn rows(self, rows: &[Row], is_first: bool) -> std::io::Result<Vec<u8>> {
        match self {
            Self::Csv => csv_lines(rows, false),
            Self::Json => {
                let lines: Result<Vec<_>, _> = rows.iter().map(serde_json::to_string).collect();
                let separator = if is_first || rows.is_empty() { "" } else { ",\n" };
                Ok([separator, &lines?.join(",\n")].concat().into_bytes())
            }
        }
    }

    /// Returns the text after the rows.
    fn tail(self, is_empty: bool) -> &'static [u8] {
        match (self, is_empty) {
            (Self::Csv, _) => b"",
            (Self::Json, true) => b"]\n",
            (Self::Json, false) => b"\n]\n",
        }
    }
}

/// Formats rows as CSV, with or without the header line.
fn csv_lines(rows: &[Row], with_header: bool) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().has_headers(with_header).from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    writer.into_inner().map_err(|error| error.into_error())
}

/// Checks that the extension of a statistics file is `.csv` or `.json`.
pub(super) fn check_name(path: &Path) -> Result<(), RunError> {
    Kind::from_path(path).map(drop)
}

/// Reads the rows of an earlier run, to which `rows` belongs. `numbers` are the numbers of the first and the
/// last frame in the rows.
///
/// Returns an error if the file is missing or does not start with the rows.
pub(super) fn read_rows(path: &Path, rows: &Record, numbers: (u64, u64)) -> Result<Recorder, RunError> {
    let lost = |problem: &str| {
        let (first, last) = numbers;
        RunError::StatsLost { path: path.to_owned(), problem: problem.to_owned(), first, last }
    };
    let text = match file::read(path, u64::MAX) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Err(lost("the file is missing")),
        text => text.map_err(|source| RunError::io("read", path, source))?,
    };
    let Some(text) = usize::try_from(rows.bytes).ok().and_then(|length| text.get(..length)) else {
        return Err(lost("it is shorter than the earlier run wrote it"));
    };
    let mut recorder = Recorder::default();
    recorder.append(text);
    if recorder.record() != *rows {
        return Err(lost("it does not start with the rows of the earlier run"));
    }
    Ok(recorder)
}

/// An open statistics file.
#[derive(Debug)]
pub(super) struct Stats {
    file: File,
    path: PathBuf,
    kind: Kind,
    /// Text up to the end of the rows. In JSON, the closing bracket follows.
    written: Recorder,
    /// Whether the file has no rows yet.
    is_empty: bool,
}

impl Stats {
    /// Creates a file, and replaces an existing file.
    pub(super) fn create(path: &Path) -> Result<Self, RunError> {
        let kind = Kind::from_path(path)?;
        let failed = |action| move |source| RunError::io(action, path, source);
        let file = File::create(path).map_err(failed("create"))?;
        sync_directory(parent(path)).map_err(failed("create"))?;
        let mut stats =
            Self { file, path: path.to_owned(), kind, written: Recorder::default(), is_empty: true };
        stats.append(kind.head(), true)?;
        Ok(stats)
    }

    /// Opens an existing file and removes all text after `rows`, which [`read_rows`] returned.
    pub(super) fn resume(path: &Path, rows: Recorder) -> Result<Self, RunError> {
        let kind = Kind::from_path(path)?;
        let failed = |source| RunError::io("write", path, source);
        let is_empty = rows.bytes() <= kind.head().map_err(failed)?.len() as u64;
        let file = File::options().write(true).open(path).map_err(failed)?;
        let mut stats = Self { file, path: path.to_owned(), kind, written: rows, is_empty };
        stats.remove_after_rows().map_err(failed)?;
        Ok(stats)
    }

    /// Appends rows. The file is valid when this function returns, also if it returns an error.
    pub(super) fn append_rows(&mut self, rows: &[Row]) -> Result<(), RunError> {
        let text = self.kind.rows(rows, self.is_empty);
        self.append(text, self.is_empty && rows.is_empty())
    }

    /// Returns the record of the text up to the end of the rows.
    pub(super) fn record(&self) -> Record {
        self.written.record()
    }

    /// Returns when all rows are on disk.
    pub(super) fn sync(&self) -> Result<(), RunError> {
        self.file.sync_all().map_err(|source| RunError::io("write", &self.path, source))
    }

    /// Writes `text` at the end of the rows, and then the text that ends the file. `is_empty`: whether the
    /// file has no rows then. If this fails, restores the file as it was before.
    fn append(&mut self, text: std::io::Result<Vec<u8>>, is_empty: bool) -> Result<(), RunError> {
        let write = |mut text: Vec<u8>| {
            let length = text.len();
            text.extend_from_slice(self.kind.tail(is_empty));
            self.file.seek(SeekFrom::Start(self.written.bytes()))?;
            // A single write, so that killing the process between two calls leaves a valid file.
            if let Err(error) = self.file.write_all(&text) {
                // The write error is returned; an error of the restoration would add nothing. The
                // restoration needs no new space on disk, because it writes where text was before.
                let _ = self.remove_after_rows();
                return Err(error);
            }
            self.written.append(&text[..length]);
            self.is_empty = is_empty;
            Ok(())
        };
        text.and_then(write).map_err(|source| RunError::io("write", &self.path, source))
    }

    /// Writes the text that ends the file after the rows, and removes all text after it.
    fn remove_after_rows(&mut self) -> std::io::Result<()> {
        let end = self.written.bytes();
        let tail = if end == 0 { b"" } else { self.kind.tail(self.is_empty) };
        self.file.seek(SeekFrom::Start(end))?;
        self.file.write_all(tail)?;
        self.file.set_len(end + tail.len() as u64)
    }
}

#[cfg(test)]
mod tests;
