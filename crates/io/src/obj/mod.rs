//! Wavefront OBJ: reading surfaces from it, and keeping what is needed to write it back byte for byte.
//!
//! ```text
//! bytes -> lines (statements, words) -> parse (with corner, groups) -> Document -> Part: the mesh of an object
//! ```
//!
//! The bytes are passed over once. Everything that real files hold is taken: polygons of any size, texture
//! coordinates, normals, several `o` and `g`, negative indices, vertex colours, a fourth coordinate, any line ends,
//! continued lines, names with spaces, bytes that are no UTF-8, statements of other programs. Tests compare what is
//! read with [obj-rs](https://crates.io/crates/obj-rs), which takes plainer files and keeps no places.

mod corner;
mod document;
mod error;
mod groups;
mod library;
mod lines;
mod parse;
mod part;

use std::path::Path;

pub use document::Document;
pub use error::{ObjError, ObjProblem};
pub use groups::Group;
pub use library::Library;
pub use parse::IgnoredStatement;
pub use part::Part;

use supple::Mesh;

/// Reads the surface of an OBJ file.
///
/// # Errors
/// As [`Document::read`] and [`Document::mesh`]; shown as `path:line: problem`.
pub fn read(path: impl AsRef<Path>) -> Result<Mesh, ObjError> {
    read_object(path, None)
}

/// Reads the surface of one object or group of an OBJ file, or of the whole file.
///
/// # Errors
/// As [`Document::read`] and [`Document::mesh`]; shown as `path:line: problem`.
pub fn read_object(path: impl AsRef<Path>, object: Option<&str>) -> Result<Mesh, ObjError> {
    Document::read(path)?.mesh(object)
}
