//! Observers that stop runs and copy their files, and the files that runs write.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use supple_io::run::{Flow, Observer, Progress};

/// An OBJ file with a box of eight points.
pub(crate) const BLOCK: &str = "o Block\n\
                                v -1 0 -1\nv 1 0 -1\nv 1 3 -1\nv -1 3 -1\nv -1 0 1\nv 1 0 1\nv 1 3 1\nv -1 3 1\n\
                                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Stops a job after a frame.
pub(crate) struct StopAfter(pub(crate) u32);

impl Observer for StopAfter {
    fn frame(&mut self, progress: &Progress) -> Flow {
        if progress.frame == self.0 { Flow::Stop } else { Flow::Continue }
    }
}

/// Copies the output directory after a frame, as it is when a run is killed.
pub(crate) struct CopyAfter {
    pub(crate) frame: u32,
    pub(crate) from: PathBuf,
    pub(crate) to: PathBuf,
}

impl Observer for CopyAfter {
    fn frame(&mut self, progress: &Progress) -> Flow {
        if progress.frame == self.frame {
            copy(&self.from, &self.to);
        }
        Flow::Continue
    }
}

pub(crate) fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    let paths = fs::read_dir(from).unwrap().map(|entry| entry.unwrap().path());
    // A run that is killed has no files in folders yet.
    for path in paths.filter(|path| path.is_file()) {
        fs::copy(&path, to.join(path.file_name().unwrap())).unwrap();
    }
}

/// Returns the files of a directory that are not those of the program: frames and pages.
pub(crate) fn written(directory: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
    let files =
        entries.filter(|path| !["supple.lock", "supple.checkpoint", "manifest.json"].contains(&&*name(path)));
    files.map(|path| (name(&path), fs::read(&path).unwrap())).collect()
}
