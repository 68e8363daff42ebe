//! Reads GLB and glTF files, with the crate gltf.
//!
//! ```text
//! bytes -> container: JSON, binary chunk -> buffers -> accessors -> nodes: places -> meshes, with skin, materials,
//! maps -> Surface
//! ```
//!
//! The iterators of the crate panic at accessors that do not fit their buffers, and so does its check of indices of
//! accessors. Both are checked before.

mod accessors;
mod buffers;
mod container;
mod maps;
mod materials;
mod meshes;
mod nodes;
mod skin;

use std::path::{Path, PathBuf};

use self::accessors::Accessors;
use self::buffers::Buffers;
use self::materials::Materials;
use self::meshes::Meshes;
use super::error::{Fault, ModelError};
use super::surface::Surface;
use crate::obj::Document;

/// Returns whether bytes are those of a GLB file, or JSON with the key of a glTF file.
pub(super) fn is(bytes: &[u8]) -> bool {
    container::is(bytes)
}

/// Reads a file from its bytes.
pub(super) fn read(path: &Path, bytes: Vec<u8>) -> Result<Document, ModelError> {
    let failed = |fault| ModelError::of(path, fault);
    let (document, chunk) = container::parse(&bytes).map_err(failed)?;
    let buffers = Buffers::read(path, &document, chunk)?;
    surface(path, &document, &buffers, bytes.len()).map_err(failed)?.into_document(path)
}

/// Returns the paths of the buffers of a file that are files of their own. A file that is not glTF has none.
pub(crate) fn buffer_files(path: &Path, bytes: &[u8]) -> Vec<PathBuf> {
    if !is(bytes) {
        return Vec::new();
    }
    container::parse(bytes).map_or(Vec::new(), |(document, _)| buffers::files(path, &document))
}

/// Returns the surface of all meshes in the scene. `size` is the size of the file, in bytes.
fn surface(
    path: &Path,
    document: &::gltf::Document,
    buffers: &Buffers,
    size: usize,
) -> Result<Surface, Fault> {
    let accessors = Accessors::new(buffers, size);
    let places = nodes::places(document)?;
    let materials = Materials::new(path, document.as_json(), buffers);
    let mut meshes = Meshes::new(materials, &accessors);
    for node in nodes::of_scene(document) {
        meshes.append(&node, &places)?;
    }
    meshes.finish()
}
