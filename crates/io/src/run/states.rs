//! The states that a run keeps beside its frames, from which another run can continue: files `supple_0030.state` with the
//! contents of a checkpoint.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::error::RunError;
use crate::file::{PART, is_same_file, parent, sync_directory};
use crate::frames::OutputError;

/// Beginning and end of the names of kept states.
const NAME: (&str, &str) = ("supple_", ".state");

/// A kept state.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct KeptState {
    /// Number of its frame, as in file names.
    pub(super) number: u64,
    pub(super) path: PathBuf,
}

/// Returns the path of the state after the frame `number`.
pub(super) fn path(directory: &Path, number: u64) -> PathBuf {
    directory.join(format!("{}{number:04}{}", NAME.0, NAME.1))
}

/// Returns the number of the frame of the state with this file name; `None` for other names. With `.part` appended it
/// is incomplete.
fn number(name: &str) -> Option<u64> {
    let digits = name.strip_prefix(NAME.0)?.strip_suffix(NAME.1)?;
    (digits.len() >= 4 && digits.bytes().all(|byte| byte.is_ascii_digit())).then(|| digits.parse().ok())?
}

/// Returns whether a file with this name can be a kept state, complete or not.
pub(super) fn is_state(name: &str) -> bool {
    number(name.strip_suffix(PART).unwrap_or(name)).is_some()
}

/// Returns the states in a directory, sorted by their numbers.
pub(super) fn list(directory: &Path) -> Result<Vec<KeptState>, RunError> {
    let mut states = Vec::new();
    for name in names(directory)? {
        if let Some(number) = number(&name) {
            states.push(KeptState { number, path: directory.join(name) });
        }
    }
    states.sort();
    Ok(states)
}

/// Removes the states after the frame `number` from a directory, or all of them, and incomplete ones. Returns when the
/// removal is on disk.
pub(super) fn remove(directory: &Path, after: Option<u64>) -> Result<(), RunError> {
    let is_kept = |name: &String| number(name).zip(after).is_some_and(|(number, after)| number <= after);
    let mut removed = false;
    for name in names(directory)?.into_iter().filter(|name| is_state(name) && !is_kept(name)) {
        let path = directory.join(name);
        fs::remove_file(&path).map_err(|source| RunError::io("remove", &path, source))?;
        removed = true;
    }
    match removed {
        true => sync_directory(directory).map_err(|source| RunError::io("write", directory, source)),
        false => Ok(()),
    }
}

/// Returns an error if one of the `inputs` in a directory has the name of a state.
pub(super) fn check_inputs(directory: &Path, inputs: &BTreeSet<PathBuf>) -> Result<(), RunError> {
    let is_output = |path: &&PathBuf| {
        path.file_name().and_then(|name| name.to_str()).is_some_and(is_state)
            && is_same_file(parent(path), directory)
    };
    match inputs.iter().find(is_output) {
        Some(path) => Err(OutputError::OverwritesInput { path: path.clone() }.into()),
        None => Ok(()),
    }
}

/// Returns the names of the files in a directory.
fn names(directory: &Path) -> Result<Vec<String>, RunError> {
    let entries = match fs::read_dir(directory) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries,
    };
    let names = entries.and_then(|entries| {
        let names = entries.map(|entry| Ok(entry?.file_name().into_string().ok()));
        names.collect::<std::io::Result<Vec<_>>>()
    });
    let names = names.map_err(|source| RunError::io("read", directory, source))?;
    Ok(names.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_listed_by_number_and_removed_after_a_frame_with_incomplete_ones() {
        let folder = tempfile::tempdir().unwrap();
        let numbers = || list(folder.path()).unwrap().iter().map(|state| state.number).collect::<Vec<_>>();
        assert!(numbers().is_empty() && list(&folder.path().join("missing")).unwrap().is_empty());
        let others =
            ["supple_1.state", "supple_00a0.state", "supple.checkpoint", "supple_0010.obj", "a_0010.state"];
        for name in others.into_iter().chain(["supple_0040.state.part"]) {
            fs::write(folder.path().join(name), name).unwrap();
        }
        for number in [10_000, 30, 60] {
            fs::write(path(folder.path(), number), "state").unwrap();
        }
        assert_eq!(numbers(), [30, 60, 10_000]);
        remove(folder.path(), Some(60)).unwrap();
        assert_eq!(numbers(), [30, 60]);
        assert!(!folder.path().join("supple_0040.state.part").exists());
        remove(folder.path(), None).unwrap();
        assert!(numbers().is_empty());
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
    }
}
