//! One row a frame and body, as CSV or JSON: whole after every frame, continued on resume.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::error::RunError;
use supple::{Body, DisplayTimes, VolumeReport};

/// What one frame of one body took and came to: a row of the statistics, whose columns are the fields in their order.
/// Times are milliseconds of wall clock for the frame, volumes cubic lengths.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// The number of the frame, as in its file's name.
    pub frame: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Name of the body.
    pub body: String,
    /// The steps since the frame before.
    pub ms_step: f64,
    /// Volume correction.
    pub ms_volume: f64,
    /// The mesh update with its normals.
    pub ms_embed: f64,
    /// Writing the frame.
    pub ms_write: f64,
    /// The volume that is kept, by the body's measure.
    pub volume_rest: f64,
    /// Its volume before correction.
    pub volume_before: f64,
    /// Its volume after correction.
    pub volume_after: f64,
    /// Length by which the correction moves along the field.
    pub lambda: f64,
    /// What the correction left over, as a fraction of the rest volume.
    pub residual: f64,
    /// Whether lambda met its cap.
    pub capped: bool,
    /// Kinetic energy of the lattice, kg length^2/s^2.
    pub energy_kinetic: f64,
    /// Speed of the fastest lattice vertex, length/s.
    pub max_speed: f64,
}

/// What a frame of a body took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    /// The steps since the frame before.
    pub(super) step: Duration,
    /// Volume correction and mesh update.
    pub(super) display: DisplayTimes,
    /// Writing.
    pub(super) write: Duration,
}

impl Row {
    /// The row of a body as it is now.
    pub(super) fn of(frame: u64, time: f64, body: &Body, volume: &VolumeReport, times: Times) -> Self {
        let milliseconds = |duration: Duration| duration.as_secs_f64() * 1e3;
        let masses = body.masses();
        let squares: Vec<f64> = body.velocities().iter().map(|velocity| velocity.norm_squared()).collect();
        Self {
            frame,
            time,
            body: body.name().to_owned(),
            ms_step: milliseconds(times.step),
            ms_volume: milliseconds(times.display.volume),
            ms_embed: milliseconds(times.display.embed),
            ms_write: milliseconds(times.write),
            volume_rest: volume.rest,
            volume_before: volume.before,
            volume_after: volume.after,
            lambda: volume.lambda,
            residual: volume.residual,
            capped: volume.capped,
            energy_kinetic: masses.iter().zip(&squares).map(|(mass, square)| mass * square / 2.0).sum(),
            max_speed: squares.iter().copied().fold(0.0, f64::max).sqrt(),
        }
    }
}

/// The formats of a stats file, told by its extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Csv,
    Json,
}

impl Kind {
    fn of(path: &Path) -> Result<Self, RunError> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("json") => Ok(Self::Json),
            _ => Err(RunError::StatsName { path: path.to_owned() }),
        }
    }

    /// What stands before the rows.
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

    /// Rows, and what goes between them, after others or as the first.
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

    /// What stands after the rows.
    fn tail(self, is_empty: bool) -> &'static [u8] {
        match (self, is_empty) {
            (Self::Csv, _) => b"",
            (Self::Json, true) => b"]\n",
            (Self::Json, false) => b"\n]\n",
        }
    }

    /// The frame of a whole line.
    fn frame_of(self, line: &str) -> Option<u64> {
        /// The part of a [`Row`] that is needed to go on.
        #[derive(Deserialize)]
        struct Numbered {
            frame: u64,
        }
        let line = line.strip_suffix('\n')?;
        match self {
            Self::Csv => line.split(',').next()?.parse().ok(),
            Self::Json => {
                let row = line.strip_suffix(',').unwrap_or(line);
                serde_json::from_str(row).ok().map(|Numbered { frame }| frame)
            }
        }
    }
}

fn csv_lines(rows: &[Row], with_header: bool) -> std::io::Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().has_headers(with_header).from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    writer.into_inner().map_err(|error| error.into_error())
}

/// Checks that a stats file's extension says what it is.
pub(super) fn check_name(path: &Path) -> Result<(), RunError> {
    Kind::of(path).map(drop)
}

/// An open stats file.
#[derive(Debug)]
pub(super) struct Stats {
    file: File,
    path: PathBuf,
    kind: Kind,
    /// Where the next row goes: in JSON the closing bracket stands there.
    end: u64,
    /// Whether no row stands before it.
    is_empty: bool,
}

impl Stats {
    /// A new file, over an existing one.
    pub(super) fn create(path: &Path) -> Result<Self, RunError> {
        let kind = Kind::of(path)?;
        let file = File::create(path).map_err(|source| RunError::io("create", path, source))?;
        let mut stats = Self { file, path: path.to_owned(), kind, end: 0, is_empty: true };
        stats.append(kind.head())?;
        Ok(stats)
    }

    /// An existing file, cut off after the rows up to frame `last`; a new one if there is none.
    pub(super) fn resume(path: &Path, last: u64) -> Result<Self, RunError> {
        if !path.exists() {
            return Self::create(path);
        }
        let kind = Kind::of(path)?;
        let failed = |action| move |source| RunError::io(action, path, source);
        let text = std::fs::read_to_string(path).map_err(failed("read"))?;
        let head = kind.head().map_err(failed("write"))?;
        if !text.as_bytes().starts_with(&head) {
            return Err(RunError::NotStats { path: path.to_owned() });
        }
        let rows = &text[head.len()..];
        let is_kept = |line: &&str| kind.frame_of(line).is_some_and(|frame| frame <= last);
        let kept: usize = rows.split_inclusive('\n').take_while(is_kept).map(str::len).sum();
        let kept = match kind {
            Kind::Csv => &rows[..kept],
            // The last row kept ends as `},\n` or `}\n`: what follows its brace is written anew.
            Kind::Json => rows[..kept].trim_end_matches(['\n', ',']),
        };
        let end = (head.len() + kept.len()) as u64;
        let open = File::options().write(true).open(path);
        let file = open.and_then(|file| file.set_len(end).map(|()| file)).map_err(failed("write"))?;
        let mut stats = Self { file, path: path.to_owned(), kind, end, is_empty: kept.is_empty() };
        stats.append(Ok(Vec::new()))?;
        Ok(stats)
    }

    /// Adds rows; the file is whole when this returns.
    pub(super) fn push(&mut self, rows: &[Row]) -> Result<(), RunError> {
        let text = self.kind.rows(rows, self.is_empty);
        self.is_empty &= rows.is_empty();
        self.append(text)
    }

    fn append(&mut self, text: std::io::Result<Vec<u8>>) -> Result<(), RunError> {
        let write = |mut text: Vec<u8>| {
            let length = text.len() as u64;
            text.extend_from_slice(self.kind.tail(self.is_empty));
            self.file.seek(SeekFrom::Start(self.end))?;
            // One write, so that a kill between two rows leaves a whole file.
            self.file.write_all(&text)?;
            self.end += length;
            Ok(())
        };
        text.and_then(write).map_err(|source| RunError::io("write", &self.path, source))
    }
}

#[cfg(test)]
mod tests;
