//! Material libraries: the file names after `mtllib`.

use std::ffi::OsString;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::lines::{Words, decode};

/// A material library that an `mtllib` statement names.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Library {
    /// The path as the file gives it.
    pub name: String,
    /// Where it lies: absolute, or relative to the current directory.
    pub path: PathBuf,
    /// Whether it is there.
    pub exists: bool,
    /// The bytes of the file that hold the name.
    pub(crate) bytes: Range<usize>,
}

/// Longer names are not looked for as files, so that a long line does not ask the file system without end.
const MOST_WORDS: usize = 16;

/// Splits what follows `mtllib` into names. The format separates them by spaces; names may hold spaces all the same.
///
/// A name is the longest run of words that is a file; else the shortest that ends in `.mtl`; else all that is left.
pub(super) fn split(raw: &[u8], names: Range<usize>, directory: &Path) -> Vec<Library> {
    let words: Vec<_> = Words::new(raw, &names).collect();
    // A `#` inside a name ends a word; what follows it belongs to the last name.
    let end_of = |last: usize| if last + 1 == words.len() { names.end } else { words[last].end };
    let mut libraries = Vec::new();
    let mut first = 0;
    while first < words.len() {
        let candidate = |last: usize| library(raw, words[first].start..end_of(last), directory);
        let longest_file =
            (first..words.len().min(first + MOST_WORDS)).rev().find(|&last| candidate(last).exists);
        let shortest_mtl = || (first..words.len()).find(|&last| ends_in_mtl(&raw[..end_of(last)]));
        let last = longest_file.or_else(shortest_mtl).unwrap_or(words.len() - 1);
        libraries.push(candidate(last));
        first = last + 1;
    }
    libraries
}

fn library(raw: &[u8], bytes: Range<usize>, directory: &Path) -> Library {
    let name = &raw[bytes.clone()];
    let mut path = directory.join(os_string(name));
    let mut exists = path.is_file();
    if !exists && name.contains(&b'\\') {
        // Written on Windows, read elsewhere.
        let slashed: Vec<u8> = name.iter().map(|&byte| if byte == b'\\' { b'/' } else { byte }).collect();
        let other = directory.join(os_string(&slashed));
        if other.is_file() {
            (path, exists) = (other, true);
        }
    }
    Library { name: decode(name), path, exists, bytes }
}

/// A file name from the bytes of the file: the very bytes where the system allows it.
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

fn ends_in_mtl(name: &[u8]) -> bool {
    name.len() >= 4 && name[name.len() - 4..].eq_ignore_ascii_case(b".mtl")
}
