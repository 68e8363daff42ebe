//! Flushes written files to disk in a thread of its own, so that a checkpoint waits only for the last ones.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use crate::file::sync_files;

/// Time for which files are collected. File systems with a journal flush many files at once in little more time than
/// one.
const COLLECT: Duration = Duration::from_secs(1);

/// A file that cannot be flushed, and the error.
pub(super) type Unflushed = (PathBuf, io::Error);

/// Files that are on their way to disk.
#[derive(Debug, Default)]
pub(super) struct Flusher {
    /// The files that no thread flushes yet. A file with all frames is added after each of them.
    collected: BTreeSet<PathBuf>,
    /// When the first of them was added.
    since: Option<Instant>,
    /// The thread that flushes earlier files.
    thread: Option<JoinHandle<Result<(), Unflushed>>>,
    /// The first error of threads that have ended.
    failed: Option<Unflushed>,
}

impl Flusher {
    /// Adds files whose contents are written. A file to which more is written is added again. Once files were collected
    /// for long enough, and the thread before has ended, a thread flushes them.
    pub(super) fn add(&mut self, paths: impl IntoIterator<Item = PathBuf>) {
        self.collected.extend(paths);
        let since = *self.since.get_or_insert_with(Instant::now);
        if since.elapsed() < COLLECT || self.thread.as_ref().is_some_and(|thread| !thread.is_finished()) {
            return;
        }
        self.join();
        let files = std::mem::take(&mut self.collected);
        self.since = None;
        self.thread = Some(thread::spawn(move || flush(files)));
    }

    /// Returns when the contents of all added files are on disk. Returns the first error and the path of its file.
    pub(super) fn finish(&mut self) -> Result<(), Unflushed> {
        self.since = None;
        let flushed = flush(std::mem::take(&mut self.collected));
        self.join();
        self.failed.take().map_or(flushed, Err)
    }

    /// Waits for the thread.
    fn join(&mut self) {
        if let Some(thread) = self.thread.take() {
            let flushed = thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            self.failed = self.failed.take().or(flushed.err());
        }
    }
}

/// Flushes files.
fn flush(files: BTreeSet<PathBuf>) -> Result<(), Unflushed> {
    let files: Vec<PathBuf> = files.into_iter().collect();
    let unflushed = |(path, error): (&Path, io::Error)| (path.to_owned(), error);
    sync_files(&files).map_err(unflushed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finishing_waits_for_all_files_and_returns_the_first_error() {
        let directory = tempfile::tempdir().unwrap();
        let file = |name: &str| {
            let path = directory.path().join(name);
            std::fs::write(&path, name).unwrap();
            path
        };
        let mut flusher = Flusher::default();
        flusher.finish().unwrap();
        flusher.add([file("a"), file("b"), file("a")]);
        flusher.finish().unwrap();
        let missing = directory.path().join("missing");
        flusher.add([file("c"), missing.clone()]);
        let (path, error) = flusher.finish().unwrap_err();
        assert_eq!((path, error.kind()), (missing, io::ErrorKind::NotFound));
        flusher.add([file("d")]);
        flusher.finish().unwrap();
    }

    #[test]
    fn files_that_arrive_while_others_are_flushed_are_flushed_too() {
        let directory = tempfile::tempdir().unwrap();
        let missing = directory.path().join("missing");
        let mut flusher = Flusher::default();
        flusher.add([missing.clone()]);
        let start = Instant::now();
        for number in 0.. {
            let path = directory.path().join(number.to_string());
            std::fs::write(&path, "text").unwrap();
            flusher.add([path]);
            thread::sleep(Duration::from_millis(2));
            if start.elapsed() > 2 * COLLECT + COLLECT / 4 {
                break;
            }
        }
        // The thread that found the error has ended, and another one has started.
        assert_eq!(flusher.failed.as_ref().unwrap().0, missing);
        assert!(flusher.thread.is_some() && !flusher.collected.is_empty());
        assert_eq!(flusher.finish().unwrap_err().0, missing);
        flusher.finish().unwrap();
    }
}
