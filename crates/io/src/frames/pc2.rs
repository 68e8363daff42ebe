//! Writes Point Cache 2 files: the positions of all frames in one file. A sample contains the positions of
//! one frame.
//!
//! ```text
//! offset  0   12 bytes   "POINTCACHE2" and a zero byte
//!        12   int32      version: 1
//!        16   int32      number of points in a sample
//!        20   float32    first frame
//!        24   float32    number of frames from one sample to the next
//!        28   int32      number of samples
//!        32   float32    the samples: x, y, z of each point
//! ```
//!
//! All numbers are little endian. The number of samples is updated after each sample, so that the `.part`
//! file of a killed run can be read.

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::PathBuf;

use super::record::{Compare, Record};
use super::single_file::{check_frames, too_short};
use super::{OutputError, Sequence};
use crate::count::counted;
use crate::file::{create_part, part_path};

const SIGNATURE: &[u8; 12] = b"POINTCACHE2\0";
/// Size of the header, in bytes.
const HEADER: u64 = 32;
/// Offset of the number of samples, in bytes.
const COUNT_AT: u64 = 28;

/// A point cache that is being written, as `NAME.pc2.part`.
#[derive(Debug)]
pub(super) struct PointCache {
    path: PathBuf,
    file: File,
    points: u32,
    samples: u32,
}

impl PointCache {
    /// Starts a new cache.
    pub(super) fn create(sequence: &Sequence, points: u32) -> Result<Self, OutputError> {
        let path = sequence.path(0);
        let mut file = create_part(&path).map_err(OutputError::io("write", &path))?;
        file.write_all(&header(sequence, points)).map_err(OutputError::io("write", &path))?;
        Ok(Self { path, file, points, samples: 0 })
    }

    /// Continues a finished or unfinished cache after its first `samples` samples, and removes later samples.
    /// Changes nothing if the cache cannot be continued.
    pub(super) fn resume(sequence: &Sequence, points: u32, samples: u64) -> Result<Self, OutputError> {
        let path = sequence.path(0);
        let existing = sequence.continued_path();
        sequence.check_continued_path()?;
        if let Some(reason) = problem(sequence, points, samples)? {
            return Err(OutputError::Cache { path, reason });
        }
        let invalid = |reason: String| OutputError::Cache { path: path.clone(), reason };
        let samples =
            u32::try_from(samples).map_err(|_| invalid("it has more than 2^32 - 1 frames".to_owned()))?;
        let part = part_path(&path);
        if existing == path {
            fs::rename(&path, &part).map_err(OutputError::io("continue", &path))?;
        }
        let open = File::options().write(true).open(&part);
        let file = open.map_err(OutputError::io("continue", &path))?;
        let mut cache = Self { path, file, points, samples };
        cache.truncate().map_err(OutputError::io("write", &cache.path))?;
        Ok(cache)
    }

    /// Appends a sample, and returns its record. If this fails, truncates the file after the previous sample.
    pub(super) fn write(&mut self, points: &[[f32; 3]]) -> Result<Record, OutputError> {
        debug_assert_eq!(points.len(), self.points as usize, "a sample has all points");
        let sample: Cow<'_, [u8]> = if cfg!(target_endian = "little") {
            bytemuck::cast_slice(points).into()
        } else {
            points.iter().flatten().flat_map(|number| number.to_le_bytes()).collect()
        };
        let written = self.file.write_all(&sample).and_then(|()| {
            self.samples += 1;
            self.write_count().inspect_err(|_| self.samples -= 1)
        });
        if let Err(error) = written {
            // The write error is returned; an error of the truncation would add nothing.
            let _ = self.truncate();
            return Err(OutputError::io("write", &self.path)(error));
        }
        Ok(Record::of(&sample))
    }

    /// Returns the path of the file while it is written.
    pub(super) fn part_path(&self) -> PathBuf {
        part_path(&self.path)
    }

    /// Returns a reader of the samples.
    pub(super) fn reader(&self) -> Result<SampleReader, OutputError> {
        let part = self.part_path();
        let file = File::open(&part).map_err(OutputError::io("read", &part))?;
        Ok(SampleReader { file, points: self.points, samples: self.samples, bytes: Vec::new() })
    }

    /// Renames the file to its final name.
    pub(super) fn finish(self) -> Result<(), OutputError> {
        let Self { path, file, .. } = self;
        drop(file);
        fs::rename(part_path(&path), &path).map_err(OutputError::io("rename to", &path))
    }

    /// Truncates the file after `self.samples` samples.
    fn truncate(&mut self) -> std::io::Result<()> {
        self.file.set_len(HEADER + u64::from(self.samples) * sample_size(self.points))?;
        self.write_count()
    }

    /// Writes the number of samples into the header, then seeks to the end.
    fn write_count(&mut self) -> std::io::Result<()> {
        self.file.seek(SeekFrom::Start(COUNT_AT))?;
        self.file.write_all(&self.samples.to_le_bytes())?;
        self.file.seek(SeekFrom::End(0)).map(drop)
    }
}

/// Reads points of the samples of a cache.
pub(super) struct SampleReader {
    file: File,
    points: u32,
    samples: u32,
    /// Scratch.
    bytes: Vec<u8>,
}

impl SampleReader {
    /// Returns the number of samples.
    pub(super) fn samples(&self) -> usize {
        self.samples as usize
    }

    /// Returns the record of a sample.
    pub(super) fn record(&mut self, sample: usize) -> std::io::Result<Record> {
        let bytes = sample_size(self.points);
        self.read_bytes(HEADER + sample as u64 * bytes, bytes as usize)?;
        Ok(Record::of(&self.bytes))
    }

    fn read_bytes(&mut self, start: u64, bytes: usize) -> std::io::Result<()> {
        self.file.seek(SeekFrom::Start(start))?;
        self.bytes.resize(bytes, 0);
        self.file.read_exact(&mut self.bytes)
    }

    /// Reads a range of points of a sample.
    pub(super) fn read(
        &mut self,
        sample: usize,
        points: Range<usize>,
        out: &mut Vec<[f32; 3]>,
    ) -> std::io::Result<()> {
        let start = HEADER + sample as u64 * sample_size(self.points) + 12 * points.start as u64;
        self.read_bytes(start, 12 * points.len())?;
        let number = |bytes: &[u8], axis: usize| {
            f32::from_le_bytes(std::array::from_fn(|byte| bytes[4 * axis + byte]))
        };
        out.clear();
        out.extend(self.bytes.chunks_exact(12).map(|bytes| std::array::from_fn(|axis| number(bytes, axis))));
        Ok(())
    }
}

/// Returns why an existing cache cannot be continued after `samples` samples of `points` points; `None` if it
/// can.
fn problem(sequence: &Sequence, points: u32, samples: u64) -> Result<Option<String>, OutputError> {
    let path = sequence.continued_path();
    let failed = |error| OutputError::io("read", &path)(error);
    let mut file = match File::open(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Some("it is missing".to_owned())),
        file => file.map_err(failed)?,
    };
    let mut found = [0; HEADER as usize];
    match file.read_exact(&mut found) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
            return Ok(Some("its header is incomplete".to_owned()));
        }
        result => result.map_err(failed)?,
    }
    if found[..COUNT_AT as usize] != header(sequence, points)[..COUNT_AT as usize] {
        let Sequence { first, every, .. } = sequence;
        return Ok(Some(format!(
            "its header must have {}, first frame {first} and frame interval {every}",
            counted(points as usize, "point")
        )));
    }
    let length = file.metadata().map_err(failed)?.len();
    let complete = (length - HEADER) / sample_size(points);
    Ok((complete < samples).then(|| too_short(complete, samples)))
}

/// Compares a cache with the records of its samples. Returns the problem if they differ.
pub(super) fn check(
    sequence: &Sequence,
    records: &[Record],
    compare: Compare,
) -> Result<Option<String>, OutputError> {
    let Some(first) = records.first() else { return Ok(None) };
    if let Some(reason) = problem(sequence, points(first), records.len() as u64)? {
        return Ok(Some(format!("cannot continue {}: {reason}", sequence.continued_path().display())));
    }
    check_frames(sequence, records, compare, HEADER)
}

/// Gives an unfinished cache that has all frames its final name, and removes the samples after `records`.
pub(super) fn finish(sequence: &Sequence, records: &[Record]) -> Result<(), OutputError> {
    match records.first() {
        Some(first) if sequence.continued_path() != sequence.path(0) => {
            PointCache::resume(sequence, points(first), records.len() as u64)?.finish()
        }
        _ => Ok(()),
    }
}

/// Returns the number of points in the sample of a record.
fn points(record: &Record) -> u32 {
    (record.bytes / sample_size(1)) as u32
}

/// Returns the size of a sample, in bytes.
fn sample_size(points: u32) -> u64 {
    12 * u64::from(points)
}

/// Returns the header with the number of samples set to 0.
fn header(sequence: &Sequence, points: u32) -> [u8; HEADER as usize] {
    let mut header = [0; HEADER as usize];
    let numbers = [
        1_u32.to_le_bytes(),
        points.to_le_bytes(),
        (sequence.first as f32).to_le_bytes(),
        (sequence.every as f32).to_le_bytes(),
    ];
    header[..12].copy_from_slice(SIGNATURE);
    header[12..COUNT_AT as usize].copy_from_slice(numbers.as_flattened());
    header
}
