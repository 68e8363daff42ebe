//! Defines the files of a frame sequence: formats and names.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::OutputError;
use crate::file::{PART, part_path};

/// Length of the longest file name that common file systems allow, in bytes.
const MAX_NAME: usize = 255;

/// Format of frames. Displayed and parsed as `obj`, `ply`, `pc2`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, one file per frame: the input with new positions and normals. The default.
    #[default]
    Obj,
    /// PLY, binary little endian, one file per frame. Faces are polygons if all have the same number of
    /// corners, otherwise triangles, because many readers require lists of equal length.
    Ply,
    /// Point Cache 2, one file per body.
    ///
    /// The program that loads the cache applies it to the *input* mesh. The points of the cache are all `v`
    /// of the OBJ file in file order, including unused ones. Load the input without reordering, merging or
    /// splitting vertices. The positions are in world space, in the axes of the scene. A program that rotates
    /// the input on import (y up to z up) must rotate the cache in the same way.
    Pc2,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Obj, Self::Ply, Self::Pc2];

    /// Returns the name, which is also the file extension.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Pc2 => "pc2",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error: no [`Format`] has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown format `{0}`: it must be obj, ply or pc2")]
pub struct UnknownFormat(pub String);

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(name: &str) -> Result<Self, UnknownFormat> {
        Self::ALL
            .into_iter()
            .find(|format| format.name() == name)
            .ok_or_else(|| UnknownFormat(name.to_owned()))
    }
}

/// The files of one body: directory, names, format and frame numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// Directory of the files. It is created if it is missing.
    pub directory: PathBuf,
    /// Name of the body. File names start with it.
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
    /// Returns the path of a frame, such as `NAME_0007.obj`. A point cache has one path for all frames,
    /// `NAME.pc2`.
    pub fn path(&self, frame: u64) -> PathBuf {
        let Self { name, format, .. } = self;
        let width = (self.last.checked_ilog10().unwrap_or(0) as usize + 1).max(4);
        self.directory.join(match format {
            Format::Pc2 => format!("{name}.{format}"),
            Format::Obj | Format::Ply => format!("{name}_{frame:0width$}.{format}"),
        })
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
        // The name of the last frame is the longest. While it is written, `.part` is appended.
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
    /// Number of the frame; `None` for a point cache, and for a number of more than 19 digits.
    pub(super) frame: Option<u64>,
    /// Whether the name ends in `.part`.
    pub(super) is_part: bool,
}

impl<'a> FileName<'a> {
    /// Splits a name, which is `BODY_<digits>.<extension>` with four digits or more, or `BODY.pc2`, both also
    /// with `.part` appended. Returns `None` for other names.
    pub(super) fn parse(name: &'a str, format: Format) -> Option<Self> {
        let stem = name.strip_suffix(PART);
        let is_part = stem.is_some();
        let stem = stem.unwrap_or(name).strip_suffix(format.name())?.strip_suffix('.')?;
        if format == Format::Pc2 {
            return Some(Self { body: stem, frame: None, is_part });
        }
        let (body, digits) = stem.rsplit_once('_')?;
        let is_number = digits.len() >= 4 && digits.bytes().all(|byte| byte.is_ascii_digit());
        is_number.then(|| Self { body, frame: digits.parse().ok(), is_part })
    }
}
