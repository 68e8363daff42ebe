//! The names of a frame sequence: which frames are kept, under which numbers, in which files.

use std::path::{Path, PathBuf};

use super::error::RunError;
use crate::scene::FormatName;

/// Which frames of a run are written, and under which numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbering {
    /// The last frame that is simulated, counted from 0.
    pub last: u32,
    /// Every how many frames one is written; at least 1.
    pub every: u32,
    /// The number that frame 0 goes by.
    pub start: u32,
}

impl Numbering {
    /// Whether a frame is written.
    pub fn keeps(self, frame: u32) -> bool {
        frame.is_multiple_of(self.every)
    }

    /// The number in the file name of a frame.
    pub fn number(self, frame: u32) -> u64 {
        u64::from(self.start) + u64::from(frame)
    }

    /// How many frames up to and including `frame` are written.
    pub fn kept_until(self, frame: u32) -> u32 {
        frame / self.every + 1
    }

    /// The file name of a frame: `NAME_0000.obj`, as wide as the last frame's number.
    pub fn file_name(self, body: &str, frame: u32, format: FormatName) -> String {
        let width = self.number(self.last).to_string().len().max(4);
        format!("{body}_{:0width$}.{}", self.number(frame), format.name())
    }
}

/// The point cache of a body, `NAME.pc2`.
pub(super) fn cache_name(body: &str) -> String {
    format!("{body}.pc2")
}

/// The name under which a file is written before it is whole.
pub(super) fn part_name(name: &str) -> String {
    format!("{name}.part")
}

/// Files in a folder that belong to the sequences of these bodies, whatever their number.
pub(super) fn existing(
    folder: &Path,
    bodies: &[String],
    format: FormatName,
) -> Result<Vec<PathBuf>, RunError> {
    let failed = |source| RunError::io("list", folder, source);
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name();
        if name.to_str().is_some_and(|name| belongs_to_any(name, bodies, format)) {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

/// Whether a file belongs to the sequence of one of these bodies.
pub(super) fn belongs_to_any(file: &str, bodies: &[String], format: FormatName) -> bool {
    bodies.iter().any(|body| belongs(file, body, format))
}

/// Whether a file is a frame, or the cache, of a body.
fn belongs(file: &str, body: &str, format: FormatName) -> bool {
    if format == FormatName::Pc2 {
        let cache = cache_name(body);
        return file == cache || file == part_name(&cache);
    }
    let number = file
        .strip_prefix(body)
        .and_then(|rest| rest.strip_prefix('_'))
        .and_then(|rest| rest.strip_suffix(format.name()))
        .and_then(|rest| rest.strip_suffix('.'));
    number.is_some_and(|number| number.len() >= 4 && number.bytes().all(|byte| byte.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_as_wide_as_the_last_number() {
        let narrow = Numbering { last: 9999, every: 1, start: 0 };
        assert_eq!(narrow.file_name("bust", 7, FormatName::Obj), "bust_0007.obj");
        let wide = Numbering { last: 10_000, ..narrow };
        assert_eq!(wide.file_name("bust", 7, FormatName::Ply), "bust_00007.ply");
        let shot = Numbering { last: 24, every: 10, start: 1001 };
        assert_eq!(shot.file_name("bust", 20, FormatName::Obj), "bust_1021.obj");
        let kept: Vec<u32> = (0..=24).filter(|&frame| shot.keeps(frame)).collect();
        assert_eq!(kept, [0, 10, 20]);
        assert_eq!((shot.kept_until(9), shot.kept_until(20)), (1, 3));
    }

    #[test]
    fn only_the_sequence_of_a_body_belongs_to_it() {
        for name in ["bust_0000.obj", "bust_12345.obj"] {
            assert!(belongs(name, "bust", FormatName::Obj), "{name}");
        }
        for name in ["bust.obj", "bust_000.obj", "bust_0000.ply", "bust_a_0000.obj", "robust_0000.obj"] {
            assert!(!belongs(name, "bust", FormatName::Obj), "{name}");
        }
        assert!(belongs("bust.pc2.part", "bust", FormatName::Pc2));
    }
}
