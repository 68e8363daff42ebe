//! Locks the output directory, so that only one run at a time writes to it.

use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::error::RunError;
use crate::file::is_link;
use crate::frames::OutputError;

/// Name of the lock file, which is in the directory of the frames.
pub const LOCK: &str = "supple.lock";

/// Lock of a directory. It is released on drop. If the process is killed, the operating system releases it.
#[derive(Debug)]
pub(super) struct Lock {
    /// Lock file. The lock lasts as long as the file is open.
    _file: File,
    path: PathBuf,
}

impl Lock {
    /// Acquires the lock of a directory.
    pub(super) fn acquire(directory: &Path) -> Result<Self, RunError> {
        let path = directory.join(LOCK);
        loop {
            if is_link(&path) {
                return Err(OutputError::Link { path }.into());
            }
            let failed = |source| RunError::io("open the lock", &path, source);
            // A new file is never created through a link.
            let file = match File::options().write(true).create_new(true).open(&path) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                    match File::options().write(true).open(&path) {
                        // The run that had the lock removed the file.
                        Err(error) if error.kind() == ErrorKind::NotFound => continue,
                        file => file.map_err(failed)?,
                    }
                }
                // The first file that a run creates: the cause is the directory.
                Err(source) => return Err(RunError::NotWritable { path: directory.to_owned(), source }),
                Ok(file) => file,
            };
            match file.try_lock() {
                Ok(()) if is_at(&file, &path) => return Ok(Self { _file: file, path }),
                // The run that had the lock removed the file after this run opened it: try again.
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
        // Removes the file before the lock is released. A failure is harmless, because a file that is not
        // locked has no effect.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Returns whether the open file `file` is still the file at `path`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::symlink_metadata(path)) {
        (Ok(open), Ok(named)) => (open.dev(), open.ino()) == (named.dev(), named.ino()),
        _ => false,
    }
}

/// Returns true, because on this operating system open files cannot be removed.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_lock_is_rejected_until_the_first_is_dropped() {
        let directory = tempfile::tempdir().unwrap();
        let first = Lock::acquire(directory.path()).unwrap();
        let error = Lock::acquire(directory.path()).unwrap_err();
        assert!(error.to_string().contains(LOCK), "{error}");
        drop(first);
        assert!(!directory.path().join(LOCK).exists());
        Lock::acquire(directory.path()).unwrap();
    }
}
