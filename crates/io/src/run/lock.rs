//! One run at a time in a folder.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use super::error::RunError;

/// The name of the lock file in the folder of the frames.
pub const LOCK: &str = "supple.lock";

/// A folder held by this run; let go when dropped, and by the system when the program dies.
#[derive(Debug)]
pub(super) struct Lock {
    /// Keeps the lock: it lies on the open file.
    _file: File,
    path: PathBuf,
}

impl Lock {
    /// Takes the lock of a folder.
    pub(super) fn take(folder: &Path) -> Result<Self, RunError> {
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
                // Another run ended and removed the file after it was opened here.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Err(RunError::Locked { path }),
                Err(TryLockError::Error(source)) => {
                    return Err(RunError::io("take the lock", &path, source));
                }
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removed while it is still held. Failing to is harmless: a file nobody holds locks nothing.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Whether an open file is still the one at a path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(open), Ok(named)) => (open.dev(), open.ino()) == (named.dev(), named.ino()),
        _ => false,
    }
}

/// Whether an open file is still the one at a path: open files cannot be removed here.
#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_run_is_refused_until_the_first_ends() {
        let folder = tempfile::tempdir().unwrap();
        let first = Lock::take(folder.path()).unwrap();
        let refused = Lock::take(folder.path()).unwrap_err();
        assert!(refused.to_string().contains(LOCK), "{refused}");
        drop(first);
        assert!(!folder.path().join(LOCK).exists());
        Lock::take(folder.path()).unwrap();
    }
}
