//! The extensions of model files, and the formats in messages.

use std::path::Path;

use crate::escape::Escaped;

/// Extensions of model files, in lower case.
pub const EXTENSIONS: [&str; 5] = ["obj", "glb", "gltf", "stl", "ply"];

/// Returns the formats for messages.
pub(crate) fn names() -> &'static str {
    "OBJ (.obj), GLB (.glb), glTF (.gltf), STL (.stl) or PLY (.ply)"
}

/// Returns whether a path has the extension of a model file.
pub fn is_model(path: &Path) -> bool {
    extension(path).is_some_and(|extension| EXTENSIONS.contains(&&*extension))
}

/// Returns the extension of a path in lower case.
pub(super) fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_ascii_lowercase())
}

/// Returns the message that files with the extension of a path are not read.
pub(crate) fn not_read(path: &Path) -> String {
    match path.extension() {
        Some(extension) => format!("files with the extension .{} are not read", Escaped(extension.display())),
        None => "files without an extension are not read".to_owned(),
    }
}
