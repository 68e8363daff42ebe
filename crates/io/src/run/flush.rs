//! Flushes written files to disk in a thread of its own, so that a checkpoint waits only for the last ones.

use std::collections::BTreeSet;
use std::io;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
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
    /// `None` if there are no files.
    worker: Option<Worker>,
}

/// The thread that flushes, and the channel to it.
#[derive(Debug)]
struct Worker {
    files: Sender<PathBuf>,
    thread: JoinHandle<Result<(), Unflushed>>,
}

impl Flusher {
    /// Adds files whose contents are written. A file to which more is written is added again.
    pub(super) fn add(&mut self, paths: impl IntoIterator<Item = PathBuf>) {
        for path in paths {
            let worker = self.worker.get_or_insert_with(|| {
                let (files, receiver) = channel();
                Worker { files, thread: thread::spawn(move || flush(&receiver)) }
            });
            // The thread ends early only after an error, which `finish` returns.
            let _ = worker.files.send(path);
        }
    }

    /// Returns when the contents of all added files are on disk. Returns the first error and the path of its file.
    pub(super) fn finish(&mut self) -> Result<(), Unflushed> {
        let Some(Worker { files, thread }) = self.worker.take() else { return Ok(()) };
        // The thread ends when it has flushed what was sent.
        drop(files);
        thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// Flushes the files that arrive, until the sender is dropped.
fn flush(files: &Receiver<PathBuf>) -> Result<(), Unflushed> {
    while let Ok(first) = files.recv() {
        let end = Instant::now() + COLLECT;
        // A file with all frames is added after each of them.
        let mut collected = BTreeSet::from([first]);
        let is_last = loop {
            match files.recv_timeout(end.saturating_duration_since(Instant::now())) {
                Ok(path) => drop(collected.insert(path)),
                Err(error) => break error == RecvTimeoutError::Disconnected,
            }
        };
        let collected: Vec<PathBuf> = collected.into_iter().collect();
        sync_files(&collected).map_err(|(path, error)| (path.to_owned(), error))?;
        if is_last {
            break;
        }
    }
    Ok(())
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
        let mut flusher = Flusher::default();
        let start = Instant::now();
        for number in 0.. {
            let path = directory.path().join(number.to_string());
            std::fs::write(&path, "text").unwrap();
            flusher.add([path]);
            thread::sleep(Duration::from_millis(2));
            if start.elapsed() > COLLECT + COLLECT / 4 {
                break;
            }
        }
        let missing = directory.path().join("missing");
        flusher.add([missing.clone()]);
        assert_eq!(flusher.finish().unwrap_err().0, missing);
    }
}
