//! Locks a directory, so that one run at a time writes to it.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use super::error::RunError;

/// Name of the lock file in the directory of the frames.
pub const LOCK: &str = "supple.lock";

/// Lock of a directory. It is released on drop, and by the operating system when the process ends.
#[derive(Debug)]
pub(super) struct Lock {
    /// Open lock file; the lock lasts as long as it is open.
    _file: File,
    path: PathBuf,
}

impl Lock {
    /// Acquires the lock of a directory.
    pub(super) fn acquire(folder: &Path) -> Result<Self, RunError> {
        let path = folder.join(LOCK);
        loop {
            let file = File::options()
                .create(true)
                .truncate(false)
                .write(true)
                .open(&path)
                .map_err(|source| RunError::io("open the lock", &path, source))?;
            match file.try_lock() {
                Ok(()) if is_at(&file, &path) => return Ok(Self { _file: file, path }),
                // Another run ended and removed the file after it was opened here: try again.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(RunError::Locked { path }),
                Err(TryLockError::Error(source)) => {
                    return Err(RunError::io("acquire the lock", &path, source));
                }
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removes the file while it is still locked. A failure is harmless, because an unlocked file has no
        // effect.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Returns whether an open file is still the file at `path`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(open), Ok(named)) => (open.dev(), open.ino()) == (named.dev(), named.ino()),
        _ => false,
    }
}

/// Returns true: the file at `path` is still the open one, because open files cannot be removed here.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_lock_is_refused_until_the_first_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let first = Lock::acquire(folder.path()).unwrap();
        let refused = Lock::acquire(folder.path()).unwrap_err();
        assert!(refused.to_string().contains(LOCK), "{refused}");
        drop(first);
        assert!(!folder.path().join(LOCK).exists());
        Lock::acquire(folder.path()).unwrap();
    }
}
