//! Rewrites the paths of material libraries (`mtllib`) so that they are correct relative to the directory of
//! the frames. Writes the library of a model whose materials are not in OBJ libraries.

use std::ffi::OsString;
use std::io::Write;
use std::path::Path;

use super::{OutputError, Sequence};
use crate::file::write_atomically;
use crate::obj::{Document, Library, library_text};
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

/// Returns the name of the library that is written beside the frames of a body; `None` if the model has no materials
/// besides those of OBJ libraries.
pub(super) fn own_library(document: &Document, body: &str) -> Option<String> {
    (!document.own_materials().is_empty()).then(|| format!("{body}_frames.mtl"))
}

/// Writes the library of [`own_library`] to the directory of a sequence.
pub(super) fn write_own_library(document: &Document, sequence: &Sequence) -> Result<(), OutputError> {
    let Some(name) = own_library(document, &sequence.name) else { return Ok(()) };
    let path = sequence.directory.join(name);
    let text = library_text(document.own_materials(), &sequence.directory);
    write_atomically(&path, |file| file.write_all(text.as_bytes())).map_err(OutputError::io("write", &path))
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
