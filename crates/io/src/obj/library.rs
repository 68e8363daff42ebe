//! Finds the material libraries named in `mtllib` statements.

use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::lines::{Words, decode};

/// A material library named in an `mtllib` statement.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Library {
    /// Path as written in the OBJ file.
    pub name: String,
    /// Path of the library: absolute, or relative to the current directory.
    pub path: PathBuf,
    /// Whether a file exists at `path`.
    pub exists: bool,
    /// Byte range of the name in the OBJ file.
    pub(crate) bytes: Range<usize>,
}

/// Largest number of words in a name for which an existing file is searched. Limits the number of file-system
/// queries for a long line.
const MAX_WORDS: usize = 16;

/// Splits the text after `mtllib` into names. The format separates names by spaces, but names may contain
/// spaces.
///
/// Starting at the first remaining word, a name is the longest sequence of words that is an existing file. If
/// there is no such file, it is the shortest sequence that ends in `.mtl`. If there is none, it is all
/// remaining words.
pub(super) fn split(raw: &[u8], names: Range<usize>, directory: &Path) -> Vec<Library> {
    let words: Vec<_> = Words::new(raw, &names).collect();
    // A `#` ends the words. If it is inside a name, the last name extends to the end of the text.
    let end_of = |last: usize| if last + 1 == words.len() { names.end } else { words[last].end };
    let mut libraries = Vec::new();
    let mut first = 0;
    while first < words.len() {
        let candidate = |last: usize| library(raw, words[first].start..end_of(last), directory);
        let longest_file =
            (first..words.len().min(first + MAX_WORDS)).rev().find(|&last| candidate(last).exists);
        let shortest_mtl = || (first..words.len()).find(|&last| ends_in_mtl(&raw[..end_of(last)]));
        let last = longest_file.or_else(shortest_mtl).unwrap_or(words.len() - 1);
        libraries.push(candidate(last));
        first = last + 1;
    }
    libraries
}

/// Returns the library whose name is at the byte range `bytes` of the file `raw`, which is in `directory`.
fn library(raw: &[u8], bytes: Range<usize>, directory: &Path) -> Library {
    let name = &raw[bytes.clone()];
    let mut path = directory.join(os_string(name));
    let mut exists = path.is_file();
    if !exists && name.contains(&b'\\') {
        // Programs on Windows write `\` between directories.
        let slashed: Vec<u8> = name.iter().map(|&byte| if byte == b'\\' { b'/' } else { byte }).collect();
        let other = directory.join(os_string(&slashed));
        if other.is_file() {
            (path, exists) = (other, true);
        }
    }
    Library { name: decode(name), path, exists, bytes }
}

/// Returns a file name from bytes of the OBJ file: the same bytes on Unix, decoded text elsewhere.
fn os_string(bytes: &[u8]) -> OsString {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        std::ffi::OsStr::from_bytes(bytes).to_owned()
    }
    #[cfg(not(unix))]
    {
        decode(bytes).into()
    }
}

/// Returns whether `name` ends in `.mtl`, in upper or lower case.
fn ends_in_mtl(name: &[u8]) -> bool {
    name.len() >= 4 && name[name.len() - 4..].eq_ignore_ascii_case(b".mtl")
}
