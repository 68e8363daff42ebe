//! Wavefront OBJ: reading surfaces from it, and keeping what is needed to write it back byte for byte.
//!
//! A scanner goes over the bytes once and hands [obj-rs](https://crates.io/crates/obj-rs) clean `v`, `vn` and `f`
//! statements. Everything that real files hold is taken: polygons of any size, texture coordinates, normals, several
//! `o` and `g`, negative indices, vertex colours, a fourth coordinate, any line ends, continued lines, names with
//! spaces, bytes that are no UTF-8, statements of other programs.

mod clean;
mod corner;
mod document;
mod error;
mod groups;
mod library;
mod lines;
mod part;
mod scan;

use std::path::Path;

pub use document::Document;
pub use error::{ObjError, ObjProblem};
pub use groups::Group;
pub use library::Library;
pub use part::Part;
pub use scan::IgnoredStatement;

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
