//! The files of a frame sequence: their formats, and which of them belong to it.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::OutputError;
use crate::file::{PART, part_of};

/// A format of frames. Shown and read as `obj`, `ply`, `pc2`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, one file a frame: the input with new positions and normals. The default.
    #[default]
    Obj,
    /// PLY, binary little endian, one file a frame: polygons where all have the same number of corners, else their
    /// triangles, as many readers take lists of one length only.
    Ply,
    /// Point Cache 2, one file a body.
    ///
    /// A reader applies it to the *input* mesh: it must have the same number of points in the same order (all `v` of
    /// an OBJ file, those that no face uses included), loaded without reordering, merging or splitting vertices. The
    /// positions are in world space, in the axes of the scene: a program that turns the input on import (y up to z
    /// up) must turn the cache likewise.
    Pc2,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 3] = [Self::Obj, Self::Ply, Self::Pc2];

    /// The name, which is also the ending of the files.
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

/// A name that no [`Format`] has.
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

/// The files of one body: where they lie, what they are called, which frames there are.
#[derive(Clone, Debug, PartialEq)]
pub struct Sequence {
    /// The directory. It is created where it is missing.
    pub directory: PathBuf,
    /// The name of the body, which files start with.
    pub name: String,
    /// The format.
    pub format: Format,
    /// The number of the first frame.
    pub first: u64,
    /// The step from one frame that is written to the next, at least 1.
    pub every: u64,
    /// The number of the last frame: numbers in file names have as many digits as it, and at least 4.
    pub last: u64,
}

impl Sequence {
    /// The file of a frame: `NAME_0007.obj`; for a point cache the file of all frames, `NAME.pc2`.
    pub fn path(&self, frame: u64) -> PathBuf {
        let Self { name, format, .. } = self;
        let width = (self.last.checked_ilog10().unwrap_or(0) as usize + 1).max(4);
        self.directory.join(match format {
            Format::Pc2 => format!("{name}.{format}"),
            Format::Obj | Format::Ply => format!("{name}_{frame:0width$}.{format}"),
        })
    }

    /// How many frames lie before number `frame`.
    pub fn frames_before(&self, frame: u64) -> u64 {
        frame.saturating_sub(self.first).div_ceil(self.every.max(1))
    }

    /// The files in the directory that belong to a sequence of this name and format, sorted, of any length, files
    /// that were left half written included. A file belongs iff it is called exactly `NAME_<digits>.<ending>` (four
    /// digits or more) or `NAME.pc2`, perhaps with `.part` after it.
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
            if entry.file_name().to_str().is_some_and(|name| self.owns(name)) {
                paths.push(self.directory.join(entry.file_name()));
            }
        }
        paths.sort();
        Ok(paths)
    }

    /// Removes the files of [`Sequence::existing`].
    ///
    /// # Errors
    /// If one of them cannot be removed.
    pub fn remove_existing(&self) -> Result<(), OutputError> {
        self.existing()?
            .iter()
            .try_for_each(|path| fs::remove_file(path).map_err(OutputError::io("remove", path)))
    }

    /// Removes the files that were left half written, but not a point cache, which can be continued.
    pub(super) fn remove_parts(&self) -> Result<(), OutputError> {
        let is_part = |path: &PathBuf| path.as_os_str().as_encoded_bytes().ends_with(PART.as_bytes());
        let parts = self.existing()?.into_iter().filter(is_part);
        let cache = part_of(&self.path(0));
        parts
            .filter(|path| self.format != Format::Pc2 || *path != cache)
            .try_for_each(|path| fs::remove_file(&path).map_err(OutputError::io("remove", &path)))
    }

    /// Refuses an `input` whose name a frame would take, or that would be removed as an older frame.
    pub(crate) fn spare(&self, input: &Path) -> Result<(), OutputError> {
        // A link and the file that it leads to.
        for path in [Some(input.to_owned()), fs::canonicalize(input).ok()].into_iter().flatten() {
            let own = path.file_name().and_then(|name| name.to_str()).is_some_and(|name| self.owns(name));
            let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
            let folders = [parent.unwrap_or(Path::new(".")), &self.directory].map(fs::canonicalize);
            if own && matches!(folders, [Ok(ref a), Ok(ref b)] if a == b) {
                return Err(OutputError::OverwritesInput { path });
            }
        }
        Ok(())
    }

    fn owns(&self, file: &str) -> bool {
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
