//! Defines the files of a frame sequence: formats, names, and which existing files belong to a sequence.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::OutputError;
use crate::file::{PART, part_path};

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

    /// Returns the files in the directory that belong to a sequence of this name and format with any number
    /// of frames, sorted. A file belongs to the sequence if its name is exactly `NAME_<digits>.<extension>`
    /// (four digits or more) or `NAME.pc2`. Incomplete files, with `.part` appended, are included.
    ///
    /// # Errors
    /// If the directory exists but cannot be read.
    pub fn existing(&self) -> Result<Vec<PathBuf>, OutputError> {
        let entries = match fs::read_dir(&self.directory) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(OutputError::io("read", &self.directory)(error)),
        };
        let mut paths = Vec::new();
        for entry in entries {
            let entry = entry.map_err(OutputError::io("read", &self.directory))?;
            if entry.file_name().to_str().is_some_and(|name| self.contains(name)) {
                paths.push(self.directory.join(entry.file_name()));
            }
        }
        paths.sort();
        Ok(paths)
    }

    /// Removes the files that [`Sequence::existing`] returns.
    ///
    /// # Errors
    /// If the directory cannot be read or a file cannot be removed.
    pub fn remove_existing(&self) -> Result<(), OutputError> {
        self.existing()?
            .iter()
            .try_for_each(|path| fs::remove_file(path).map_err(OutputError::io("remove", path)))
    }

    /// Removes incomplete files, except an incomplete point cache, which can be continued.
    pub(super) fn remove_parts(&self) -> Result<(), OutputError> {
        let is_part = |path: &PathBuf| path.as_os_str().as_encoded_bytes().ends_with(PART.as_bytes());
        let parts = self.existing()?.into_iter().filter(is_part);
        let cache = part_path(&self.path(0));
        parts
            .filter(|path| self.format != Format::Pc2 || *path != cache)
            .try_for_each(|path| fs::remove_file(&path).map_err(OutputError::io("remove", &path)))
    }

    /// Returns an error if a frame would replace `input`, or if `input` would be removed as an older frame.
    pub(crate) fn check_input(&self, input: &Path) -> Result<(), OutputError> {
        // If `input` is a link, checks the link and its target.
        for path in [Some(input.to_owned()), fs::canonicalize(input).ok()].into_iter().flatten() {
            let in_sequence =
                path.file_name().and_then(|name| name.to_str()).is_some_and(|name| self.contains(name));
            let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
            let directories = [parent.unwrap_or(Path::new(".")), &self.directory].map(fs::canonicalize);
            if in_sequence && matches!(directories, [Ok(ref a), Ok(ref b)] if a == b) {
                return Err(OutputError::OverwritesInput { path });
            }
        }
        Ok(())
    }

    /// Returns whether a file with this name belongs to the sequence; see [`Sequence::existing`].
    fn contains(&self, file: &str) -> bool {
        let Some(rest) = file.strip_prefix(self.name.as_str()) else { return false };
        let rest = rest.strip_suffix(PART).unwrap_or(rest);
        let Some(rest) = rest.strip_suffix(self.format.name()).and_then(|rest| rest.strip_suffix('.')) else {
            return false;
        };
        match self.format {
            Format::Pc2 => rest.is_empty(),
            Format::Obj | Format::Ply => rest
                .strip_prefix('_')
                .is_some_and(|digits| digits.len() >= 4 && digits.bytes().all(|byte| byte.is_ascii_digit())),
        }
    }
}
