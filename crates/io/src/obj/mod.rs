//! Reads the surfaces of Wavefront OBJ files, and keeps the bytes of each file so that it can be written back
//! unchanged.
//!
//! ```text
//! bytes -> lines: statements, words -> parse, with numbers, corner, groups -> Document -> Part: mesh of a body
//! ```
//!
//! The file is parsed in one pass. Texture coordinates, materials, the statements of faces and the colors of vertices are
//! read by further passes (`appearance`, `material`, `statements`, `maps`) if they are needed. The parser accepts polygons of any size,
//! texture coordinates, normals, several objects and groups, negative indices, vertex colors, a fourth coordinate, LF,
//! CR or CRLF line ends, continued lines, names with spaces, bytes that are not UTF-8, and unknown statements.
//!
//! The parser is own code, because [obj-rs](https://crates.io/crates/obj-rs) keeps no byte ranges, and refuses or panics
//! at many of these variants. Material libraries are read with obj-rs, [`from_raw`] takes surfaces that were read with it,
//! and tests compare the two parsers.

mod appearance;
mod color;
mod corner;
mod document;
mod error;
mod groups;
mod image;
mod library;
mod lines;
mod maps;
mod material;
mod numbers;
mod parse;
mod part;
mod scaled;
mod statements;

use std::path::Path;

pub use appearance::Appearance;
pub use color::MaterialColor;
pub(crate) use color::{cap_material, library_text};
pub use document::Document;
pub(crate) use document::Origin;
pub use error::{ObjError, ObjProblem};
pub use groups::Group;
pub(crate) use image::is_image_name;
pub use image::{EmbeddedImage, Image, ImageKind};
pub use library::Library;
pub(crate) use maps::{COLORS, WHITE};
pub use parse::IgnoredStatement;
pub use part::Part;
pub(crate) use statements::{CONTEXT, FaceStatements, NO_TEXTURE};

use ::obj::raw::object::{Polygon, RawObj};
use supple::{Mesh, MeshError};

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
    Document::read(path)?.grouped_mesh(object)
}

/// Returns the surface of an OBJ file that was read with obj-rs. Its vertices are the positions in their order; texture
/// coordinates, normals, groups, lines and points are not used.
///
/// ```
/// let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
/// let raw = obj::raw::parse_obj(text.as_bytes())?;
/// let mesh = supple_io::obj::from_raw(&raw)?;
/// assert!(mesh.is_closed());
/// let body = supple::Body::builder(mesh).lattice_vertices(100).build()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`Mesh::new`].
pub fn from_raw(raw: &RawObj) -> Result<Mesh, MeshError> {
    // An index beyond 32 bits is out of range.
    let index = |vertex: usize| u32::try_from(vertex).unwrap_or(u32::MAX);
    let corners = |polygon: &Polygon| match polygon {
        Polygon::P(corners) => corners.iter().map(|&vertex| index(vertex)).collect(),
        Polygon::PT(corners) | Polygon::PN(corners) => corners.iter().map(|corner| index(corner.0)).collect(),
        Polygon::PTN(corners) => corners.iter().map(|corner| index(corner.0)).collect(),
    };
    let vertices = raw.positions.iter().map(|&(x, y, z, _)| [x, y, z].map(f64::from)).collect();
    let faces: Vec<Vec<u32>> = raw.polygons.iter().map(corners).collect();
    Mesh::new(vertices, &faces)
}
