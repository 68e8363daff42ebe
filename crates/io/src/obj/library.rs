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
    /// Whether a file exists at `path`. Only the first 256 libraries of an OBJ file are searched.
    pub exists: bool,
    /// Byte range of the name in the OBJ file.
    pub(crate) bytes: Range<usize>,
}

/// Largest number of words in a name for which an existing file is searched.
const MAX_WORDS: usize = 16;
/// Largest number of names for which existing files are searched. Together with [`MAX_WORDS`], it limits the
/// number of file-system queries to a few thousand, which take less than a second.
const MAX_SEARCHED: usize = 256;
/// Largest length of a name for which an existing file is searched, in bytes. Operating systems allow no
/// longer paths.
const MAX_LENGTH: usize = 4096;

/// Returns the libraries that the texts after `mtllib` name, in order. `directory` is the directory of the
/// OBJ file.
pub(super) fn find(raw: &[u8], statements: &[Range<usize>], directory: &Path) -> Vec<Library> {
    let mut libraries = Vec::new();
    for names in statements {
        split(raw, names, directory, &mut libraries);
    }
    libraries
}

/// Splits the text after `mtllib` into names, and appends their libraries. The format separates names by
/// spaces, but names may contain spaces.
///
/// Starting at the first remaining word, a name is the longest sequence of words that is an existing file. If
/// there is no such file, it is the shortest sequence that ends in `.mtl`. If there is none, it is all
/// remaining words. Quotation marks around a name are not part of it.
fn split(raw: &[u8], names: &Range<usize>, directory: &Path, libraries: &mut Vec<Library>) {
    let words: Vec<_> = Words::new(raw, names).collect();
    // A `#` ends the words. If it is inside a name, the last name extends to the end of the text.
    let end_of = |last: usize| if last + 1 == words.len() { names.end } else { words[last].end };
    let mut first = 0;
    while first < words.len() {
        let start = words[first].start;
        let searched = if libraries.len() < MAX_SEARCHED { MAX_WORDS } else { 0 };
        let longest_file = (first..words.len().min(first + searched))
            .rev()
            .find_map(|last| Some((last, existing(&raw[start..end_of(last)], directory)?)));
        let shortest_mtl =
            || (first..words.len()).find(|&last| ends_in_mtl(unquoted(&raw[start..end_of(last)])));
        let (last, path) = match longest_file {
            Some((last, path)) => (last, Some(path)),
            None => (shortest_mtl().unwrap_or(words.len() - 1), None),
        };
        let bytes = start..end_of(last);
        let name = unquoted(&raw[bytes.clone()]);
        let exists = path.is_some();
        let path = path.unwrap_or_else(|| directory.join(os_string(name)));
        libraries.push(Library { name: decode(name).into_owned(), path, exists, bytes });
        first = last + 1;
    }
}

/// Returns the path of the file called `name` in `directory` if it exists.
fn existing(name: &[u8], directory: &Path) -> Option<PathBuf> {
    if name.len() > MAX_LENGTH {
        return None;
    }
    let path = directory.join(os_string(name));
    if path.is_file() {
        return Some(path);
    }
    let bare = unquoted(name);
    if bare.len() < name.len() {
        return existing(bare, directory);
    }
    if !name.contains(&b'\\') {
        return None;
    }
    // Programs on Windows write `\` between directories.
    let slashed: Vec<u8> = name.iter().map(|&byte| if byte == b'\\' { b'/' } else { byte }).collect();
    Some(directory.join(os_string(&slashed))).filter(|path| path.is_file())
}

/// Returns a name without the quotation marks around it, if it has both.
fn unquoted(name: &[u8]) -> &[u8] {
    name.strip_prefix(b"\"").and_then(|rest| rest.strip_suffix(b"\"")).unwrap_or(name)
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
        decode(bytes).into_owned().into()
    }
}

/// Returns whether `name` ends in `.mtl`, in upper or lower case.
fn ends_in_mtl(name: &[u8]) -> bool {
    name.len() >= 4 && name[name.len() - 4..].eq_ignore_ascii_case(b".mtl")
}
