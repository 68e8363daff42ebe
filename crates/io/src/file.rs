//! Reads regular files. Writes files atomically: under a temporary name, and renames them when they are
//! complete.

use std::fs::{self, File, FileType};
use std::io;
use std::path::{Path, PathBuf};

/// Suffix of files that are not complete yet.
pub(crate) const PART: &str = ".part";

/// Returns `path` with `.part` appended.
pub(crate) fn part_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(PART);
    name.into()
}

/// Reads a whole regular file, or the regular file that a link leads to, of at most `largest` bytes.
///
/// # Errors
///
/// The error of the file system; or that the file is larger, or that it is a directory, a pipe, a socket or a
/// device. A pipe or a device may have no end, so it is not opened.
pub(crate) fn read(path: &Path, largest: u64) -> io::Result<Vec<u8>> {
    let metadata = fs::metadata(path)?;
    let (kind, size) = (metadata.file_type(), metadata.len());
    if kind.is_file() && size > largest {
        let message = format!("it has {size} bytes; the largest size is {largest} bytes");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    if kind.is_file() {
        return fs::read(path);
    }
    Err(if kind.is_dir() {
        io::Error::new(io::ErrorKind::IsADirectory, "it is a directory; give a file")
    } else {
        let message = format!("it is {}; save its data as a regular file and give that", name_of(kind));
        io::Error::new(io::ErrorKind::InvalidInput, message)
    })
}

/// Returns the name of a type of file that is neither regular nor a directory, for messages.
fn name_of(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    let _ = kind;
    "not a regular file"
}

/// Writes a file atomically: writes to `path` with `.part` appended, then renames it to `path`.
///
/// # Errors
///
/// The error of `write` or of the file system. The `.part` file is then removed, and a file that existed at
/// `path` is unchanged.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let part = part_path(path);
    let written = File::create(&part).and_then(|mut file| write(&mut file));
    let result = written.and_then(|()| fs::rename(&part, path));
    if result.is_err() {
        // The error of `write` or `rename` is returned; an error of the removal would add nothing.
        let _ = fs::remove_file(&part);
    }
    result
}
