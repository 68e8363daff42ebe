//! Reads the surfaces of model files: OBJ, GLB and glTF, STL, PLY.
//!
//! ```text
//! bytes -> formats: the format by content -> gltf, stl, ply -> Surface -> OBJ text -> Document
//! ```
//!
//! A file of another format than OBJ becomes a [`Document`] with the text of its surface as OBJ, so that its frames,
//! objects, texture coordinates and materials are those of an OBJ file. `docs/formats.md` says what is read of each
//! format. A new format is a file with two functions and its entry in `formats`.
//!
//! Counts and ranges of a file are compared with its size before memory is allocated for them.

mod error;
mod formats;
mod gltf;
mod names;
mod ply;
mod stl;
mod surface;
mod weld;

use std::path::{Path, PathBuf};

use supple::Mesh;

use crate::file;
use crate::obj::Document;

pub use error::ModelError;
pub(crate) use gltf::buffer_files;
pub use names::{EXTENSIONS, is_model};
pub(crate) use names::{names, not_read};

/// Reads the surface of a model file, or of one of its objects or groups.
///
/// # Errors
/// As [`read_document`] and [`Document::mesh`].
pub fn read(path: impl AsRef<Path>, object: Option<&str>) -> Result<Mesh, ModelError> {
    Ok(read_document(path)?.grouped_mesh(object)?)
}

/// Reads a model file. Its content determines the format; its extension does if the content is of no known format.
///
/// # Errors
/// If the file cannot be read, is not a regular file, has another format, or is invalid. The error names the file and the
/// line or element.
pub fn read_document(path: impl AsRef<Path>) -> Result<Document, ModelError> {
    let path = path.as_ref();
    let bytes =
        file::read(path, u64::MAX).map_err(|source| ModelError::Read { path: path.to_owned(), source })?;
    from_bytes(path, bytes)
}

/// Reads a model file from its bytes in memory. Errors name `path`. The paths of material libraries, buffers and images
/// are relative to the directory of `path`.
///
/// # Errors
/// As [`read_document`].
pub fn from_bytes(path: impl Into<PathBuf>, bytes: Vec<u8>) -> Result<Document, ModelError> {
    let path = path.into();
    let format = formats::of(&path, &bytes)?;
    (format.read)(&path, bytes)
}
