//! Reads the surfaces of Wavefront OBJ files, and keeps the bytes of each file so that it can be written back
//! unchanged.
//!
//! ```text
//! bytes -> lines: statements, words -> parse, with numbers, corner, groups -> Document -> Part: mesh of a body
//! ```
//!
//! The file is parsed in one pass. Texture coordinates, materials and the statements of faces are read by further
//! passes (`appearance`, `material`, `statements`) if a format needs them. The parser accepts polygons of any size,
//! texture coordinates, normals, several objects and groups, negative indices, vertex colors, a fourth coordinate, LF,
//! CR or CRLF line ends, continued lines, names with spaces, bytes that are not UTF-8, and unknown statements. Tests
//! compare the result with [obj-rs](https://crates.io/crates/obj-rs), which accepts fewer files and keeps no byte
//! ranges.

mod appearance;
mod corner;
mod document;
mod error;
mod groups;
mod library;
mod lines;
mod material;
mod numbers;
mod parse;
mod part;
mod statements;

use std::path::Path;

pub use appearance::Appearance;
pub use document::Document;
pub use error::{ObjError, ObjProblem};
pub use groups::Group;
pub use library::Library;
pub use material::MaterialColor;
pub(crate) use material::cap_material;
pub use parse::IgnoredStatement;
pub use part::Part;
pub(crate) use statements::{CONTEXT, FaceStatements, NO_TEXTURE};

use supple::Mesh;

/// Reads the surface of an OBJ file.
///
/// # Errors
/// As [`Document::read`] and [`Document::mesh`]. The message of the error is `path:line: problem`.
pub fn read(path: impl AsRef<Path>) -> Result<Mesh, ObjError> {
    read_object(path, None)
}

/// Reads the surface of one object or group of an OBJ file, or of the whole file.
///
/// # Errors
/// As [`Document::read`] and [`Document::mesh`]. The message of the error is `path:line: problem`.
pub fn read_object(path: impl AsRef<Path>, object: Option<&str>) -> Result<Mesh, ObjError> {
    Document::read(path)?.mesh(object)
}
