//! Writes statistics as CSV or JSON, with one row per written frame and body. The file is valid after every
//! frame.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::error::RunError;
use supple::{Body, DisplayTimes, VolumeReport};

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
    pub(super) fn new(frame: u64, time: f64, body: &Body, volume: &VolumeReport, times: Times) -> Self {
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

    /// Returns the frame number of a row. Returns `None` if the line is incomplete or is not a row.
    fn frame_of(self, line: &str) -> Option<u64> {
        /// The field of a [`Row`] that is needed to resume.
        #[derive(Deserialize)]
        struct FrameNumber {
            frame: u64,
        }
        let line = line.strip_suffix('\n')?;
        match self {
            Self::Csv => line.split(',').next()?.parse().ok(),
            Self::Json => {
                let row = line.strip_suffix(',').unwrap_or(line);
                serde_json::from_str(row).ok().map(|FrameNumber { frame }| frame)
            }
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

/// An open statistics file.
#[derive(Debug)]
pub(super) struct Stats {
    file: File,
    path: PathBuf,
    kind: Kind,
    /// Byte offset of the end of the rows. In JSON, the closing bracket follows.
    end: u64,
    /// Whether the file has no rows yet.
    is_empty: bool,
}

impl Stats {
    /// Creates a file, and replaces an existing file.
    pub(super) fn create(path: &Path) -> Result<Self, RunError> {
        let kind = Kind::from_path(path)?;
        let file = File::create(path).map_err(|source| RunError::io("create", path, source))?;
        let mut stats = Self { file, path: path.to_owned(), kind, end: 0, is_empty: true };
        stats.append(kind.head())?;
        Ok(stats)
    }

    /// Opens an existing file and removes the rows after frame number `last_kept`. Creates the file if it is
    /// missing.
    pub(super) fn resume(path: &Path, last_kept: u64) -> Result<Self, RunError> {
        if !path.exists() {
            return Self::create(path);
        }
        let kind = Kind::from_path(path)?;
        let failed = |action| move |source| RunError::io(action, path, source);
        let text = std::fs::read_to_string(path).map_err(failed("read"))?;
        let head = kind.head().map_err(failed("write"))?;
        if !text.as_bytes().starts_with(&head) {
            return Err(RunError::NotStats { path: path.to_owned() });
        }
        let rows = &text[head.len()..];
        let is_kept = |line: &&str| kind.frame_of(line).is_some_and(|frame| frame <= last_kept);
        let kept_length: usize = rows.split_inclusive('\n').take_while(is_kept).map(str::len).sum();
        let kept = match kind {
            Kind::Csv => &rows[..kept_length],
            // The last kept row ends in `},\n` or `}\n`. The text after the brace is removed, and written
            // again.
            Kind::Json => rows[..kept_length].trim_end_matches(['\n', ',']),
        };
        let end = (head.len() + kept.len()) as u64;
        let opened = File::options().write(true).open(path);
        let file = opened.and_then(|file| file.set_len(end).map(|()| file)).map_err(failed("write"))?;
        let mut stats = Self { file, path: path.to_owned(), kind, end, is_empty: kept.is_empty() };
        stats.append(Ok(Vec::new()))?;
        Ok(stats)
    }

    /// Appends rows. The file is valid when this function returns.
    pub(super) fn append_rows(&mut self, rows: &[Row]) -> Result<(), RunError> {
        let text = self.kind.rows(rows, self.is_empty);
        self.is_empty &= rows.is_empty();
        self.append(text)
    }

    /// Writes `text` at the end of the rows, and then the text that ends the file.
    fn append(&mut self, text: std::io::Result<Vec<u8>>) -> Result<(), RunError> {
        let write = |mut text: Vec<u8>| {
            let length = text.len() as u64;
            text.extend_from_slice(self.kind.tail(self.is_empty));
            self.file.seek(SeekFrom::Start(self.end))?;
            // A single write, so that killing the process between two calls leaves a valid file.
            self.file.write_all(&text)?;
            self.end += length;
            Ok(())
        };
        text.and_then(write).map_err(|source| RunError::io("write", &self.path, source))
    }
}

#[cfg(test)]
mod tests;
