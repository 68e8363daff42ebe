//! Defines the files of a frame sequence: their names.

use std::collections::HashSet;
use std::path::PathBuf;

use super::{Format, OutputError};
use crate::file::{PART, is_link, part_path};
use crate::vat;

/// Length of the longest file name that common file systems allow, in bytes.
const MAX_NAME: usize = 255;

/// The files of one body, or of a run: directory, names, format and frame numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// Directory of the files. It is created if it is missing.
    pub directory: PathBuf,
    /// Name of the body, or of the stage or the page of a run. File names start with it.
    pub name: String,
    /// Format of the files.
    pub format: Format,
    /// Number of the first frame.
    pub first: u64,
    /// Interval between written frames, in frames, at least 1.
    pub every: u64,
    /// Number of the last frame. It determines the number of digits in file names, at least 4.
    pub last: u64,
}

impl Sequence {
    /// Returns the path of a frame, such as `NAME_0007.obj`. Formats with a file for all frames have one path for them,
    /// such as `NAME.pc2`; that of textures is `NAME_vat/NAME-remap_info.json`.
    pub fn path(&self, frame: u64) -> PathBuf {
        let Self { name, format, .. } = self;
        let width = (self.last.checked_ilog10().unwrap_or(0) as usize + 1).max(4);
        if *format == Format::Vat {
            // The last file of the folder.
            return self.directory.join(format!("{name}_vat")).join(format!("{name}-remap_info.json"));
        }
        self.directory.join(if format.is_per_sequence() {
            format!("{name}.{}", format.extension())
        } else {
            format!("{name}_{frame:0width$}.{}", format.extension())
        })
    }

    /// Returns the paths of the complete files of the sequence that have more than one frame.
    pub(crate) fn whole_files(&self) -> Vec<PathBuf> {
        let Self { directory, name, format, .. } = self;
        match format {
            Format::Vat => vat::existing_files(&self.path(0), name),
            // The library of a model whose materials are not in OBJ libraries.
            Format::Obj => {
                let library = directory.join(format!("{name}_frames.mtl"));
                if library.is_file() { vec![library] } else { Vec::new() }
            }
            Format::Vtu => vec![directory.join(format!("{name}.pvd"))],
            Format::Lattice => vec![directory.join(format!("{name}.lattice.pvd"))],
            _ if format.is_per_sequence() => vec![self.path(0)],
            _ => Vec::new(),
        }
    }

    /// Returns the sequence of the file that has the frames of a clip or a package until its run ends.
    pub(super) fn frames(&self) -> Self {
        let name = format!("{}.{}", self.name, self.format);
        let format = if self.format == Format::Usdz { Format::Usd } else { Format::Pc2 };
        Self { name, format, ..self.clone() }
    }

    /// Returns an error if files of two sequences with more than one frame would have the same path.
    pub(crate) fn check_different(sequences: &[Self]) -> Result<(), OutputError> {
        let mut known = HashSet::new();
        for sequence in sequences {
            let frames = sequence.format.needs_all_frames().then(|| sequence.frames().path(0));
            for path in sequence.whole_files().into_iter().chain(frames) {
                if !known.insert(path.clone()) {
                    return Err(OutputError::SamePath { path });
                }
            }
        }
        Ok(())
    }

    /// Returns the path of the file of a point cache or a stage that a run continues: of the unfinished one if there is
    /// one, or else of the finished one.
    pub(super) fn continued_path(&self) -> PathBuf {
        let path = self.path(0);
        let part = part_path(&path);
        if part.symlink_metadata().is_ok() { part } else { path }
    }

    /// Returns an error if the file at [`continued_path`](Self::continued_path) is a link, which would have to be
    /// followed.
    pub(super) fn check_continued_path(&self) -> Result<(), OutputError> {
        let path = self.continued_path();
        if is_link(&path) {
            return Err(OutputError::Link { path });
        }
        Ok(())
    }

    /// Returns how many frames are written before frame number `frame`.
    pub fn frames_before(&self, frame: u64) -> u64 {
        frame.saturating_sub(self.first).div_ceil(self.every.max(1))
    }

    /// Returns whether the sequence has a frame with this number.
    pub(crate) fn writes(&self, frame: u64) -> bool {
        (self.first..=self.last).contains(&frame) && (frame - self.first).is_multiple_of(self.every.max(1))
    }

    /// Returns an error if the name of a file of the sequence would be longer than file systems allow.
    pub(crate) fn check_length(&self) -> Result<(), OutputError> {
        // The name of the last frame is the longest. While it is written, a suffix of five bytes is appended.
        let path = part_path(&self.path(self.last));
        let length = path.file_name().map_or(0, |name| name.len());
        if length > MAX_NAME {
            return Err(OutputError::NameTooLong { name: self.name.clone(), length, max: MAX_NAME });
        }
        Ok(())
    }
}

/// Parts of the name of a file of any sequence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FileName<'a> {
    /// Name of the body.
    pub(super) body: &'a str,
    /// Number of the frame; `None` for a file with all frames, and for a number of more than 19 digits.
    pub(super) frame: Option<u64>,
    /// Whether the name ends in `.part`.
    pub(super) is_part: bool,
}

impl<'a> FileName<'a> {
    /// Splits a name, which is `BODY_<digits>.<extension>` with four digits or more, `BODY.pc2`, `BODY.usd` or
    /// `BODY.html`, all also with `.part` appended, or `BODY.html.data`. Returns `None` for other names.
    pub(super) fn parse(name: &'a str, format: Format) -> Option<Self> {
        let stem = name.strip_suffix(PART);
        let is_part = stem.is_some();
        let stem = stem.unwrap_or(name);
        let stem = stem.strip_suffix(format.data()).unwrap_or(stem);
        let stem = stem.strip_suffix(format.extension())?.strip_suffix('.')?;
        if format.is_per_sequence() {
            return Some(Self { body: stem, frame: None, is_part });
        }
        let (body, digits) = stem.rsplit_once('_')?;
        let is_number = digits.len() >= 4 && digits.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| Self { body, frame: digits.parse().ok(), is_part })
    }
}
