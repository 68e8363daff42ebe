//! The table of formats.

use std::path::Path;

use super::error::ModelError;
use super::names::extension;
use super::{gltf, ply, stl};
use crate::obj::Document;

/// A format of model files.
pub(super) struct Format {
    /// Extensions of its files, in lower case.
    extensions: &'static [&'static str],
    /// Returns whether bytes are the content of a file of the format, valid or not.
    is: fn(&[u8]) -> bool,
    /// Reads a file from its bytes; the path is for messages and for the paths of other files.
    pub(super) read: fn(&Path, Vec<u8>) -> Result<Document, ModelError>,
}

/// All formats. OBJ comes last, because it has no mark at its start.
static FORMATS: [Format; 4] = [
    Format { extensions: &["glb", "gltf"], is: gltf::is, read: gltf::read },
    Format { extensions: &["ply"], is: ply::is, read: ply::read },
    Format { extensions: &["stl"], is: stl::is, read: stl::read },
    Format { extensions: &["obj"], is: is_obj, read: read_obj },
];

/// Returns the format of a file: that of its content, or else that of its extension.
pub(super) fn of(path: &Path, bytes: &[u8]) -> Result<&'static Format, ModelError> {
    let extension = extension(path);
    let by_content = FORMATS.iter().find(|format| (format.is)(bytes));
    let by_extension = || {
        let extension = extension.as_deref()?;
        FORMATS.iter().find(|format| format.extensions.contains(&extension))
    };
    by_content.or_else(by_extension).ok_or_else(|| ModelError::Unknown { path: path.to_owned() })
}

/// Returns whether bytes are a text with a `v` statement. Bytes after the first such statement are not searched.
fn is_obj(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| matches!(byte, b'\n' | b'\r')).take_while(|line| !line.contains(&0));
    lines.any(|line| matches!(line.trim_ascii_start(), [b'v', b' ' | b'\t', ..]))
}

fn read_obj(path: &Path, bytes: Vec<u8>) -> Result<Document, ModelError> {
    Ok(Document::from_bytes(path, bytes)?)
}

#[cfg(test)]
mod tests {
    use super::super::names::{EXTENSIONS, names};
    use super::*;

    #[test]
    fn extensions_are_those_of_the_table() {
        let mut all: Vec<&str> = FORMATS.iter().flat_map(|format| format.extensions).copied().collect();
        let mut listed = EXTENSIONS.to_vec();
        all.sort_unstable();
        listed.sort_unstable();
        assert_eq!(all, listed);
        assert!(EXTENSIONS.iter().all(|extension| names().contains(&format!("(.{extension})"))));
    }
}
