//! Rewrites the paths of material libraries (`mtllib`) so that they are correct relative to the directory of
//! the frames.

use std::ffi::OsString;
use std::path::Path;

use crate::obj::Library;
use crate::path::{relative, resolve, resolve_directory};

/// Returns the bytes that replace the path of `library` in a frame. The input file is in the directory
/// `input`, and the frames are in the directory `output`. Returns `None` if the path stays correct: it is
/// absolute, or relative to `output` it leads to the same file.
pub(super) fn rewritten(library: &Library, input: &Path, output: &Path) -> Option<Vec<u8>> {
    if Path::new(&library.name).is_absolute() || has_drive(&library.name) {
        return None;
    }
    let target = resolve(&library.path);
    let from_output = output.join(library.path.strip_prefix(input).unwrap_or(&library.path));
    if resolve(&from_output) == target {
        return None;
    }
    Some(bytes(&relative(&target, &resolve_directory(output))))
}

/// Returns whether `name` starts with a drive (`C:\...`). `Path` recognizes drives on Windows only.
fn has_drive(name: &str) -> bool {
    matches!(name.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic())
}

/// Returns the bytes of a path in a text file: the same bytes on Unix, UTF-8 elsewhere.
fn bytes(path: &OsString) -> Vec<u8> {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        path.as_bytes().to_vec()
    }
    #[cfg(not(unix))]
    {
        path.to_string_lossy().into_owned().into_bytes()
    }
}
