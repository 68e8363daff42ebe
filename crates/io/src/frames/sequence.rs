//! The files of a frame sequence.

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use super::file::{PART, part_of};
use super::{Format, OutputError};

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
    pub(super) fn spare(&self, input: &Path) -> Result<(), OutputError> {
        let own = input.file_name().and_then(|name| name.to_str()).is_some_and(|name| self.owns(name));
        let parent = input.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let same = || Some(fs::canonicalize(parent).ok()? == fs::canonicalize(&self.directory).ok()?);
        if own && same() == Some(true) {
            return Err(OutputError::OverwritesInput { path: input.to_owned() });
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
