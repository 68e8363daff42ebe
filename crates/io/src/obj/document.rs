//! Defines [`Document`]: the bytes of an OBJ file, and the byte ranges of its elements.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Point3;

use super::color::MaterialColor;
use super::error::{ObjError, ObjProblem};
use super::numbers::Numbers;
use super::parse::{IgnoredStatement, NO_NORMAL, Parsed, parse};
use super::{Group, Library, library};
use crate::file;

/// Contents of an OBJ file: the bytes, the surface, and the names of the objects and groups.
///
/// Texture coordinates, materials, lines, points and free-form statements are kept but not interpreted.
///
/// A file of another format becomes a document with the text of its surface as OBJ: see [`model`](crate::model).
#[derive(Debug)]
pub struct Document {
    path: PathBuf,
    raw: Vec<u8>,
    parsed: Parsed,
    origin: Option<Arc<Origin>>,
}

/// The parts of a file of another format than OBJ that the OBJ text of its document does not contain.
#[derive(Debug, Default)]
pub(crate) struct Origin {
    /// Materials by the names in `usemtl` statements, each name once.
    pub(crate) materials: Vec<(String, MaterialColor)>,
    /// Maps by their names, each name once, with a finite number for each `v`.
    pub(crate) maps: Vec<(String, Vec<f32>)>,
    /// Descriptions of what was not read, such as `2 primitives of lines`.
    pub(crate) ignored: Vec<String>,
}

impl Document {
    /// Reads a file.
    ///
    /// # Errors
    /// If the file cannot be read, is not a regular file (but a directory, a pipe, a device), is not an OBJ
    /// file, has no faces, or contains an index out of range or a number that is malformed or not finite. The
    /// error names the file and, if the problem is in one line, the line.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ObjError> {
        let path = path.as_ref();
        let raw = file::read(path, u64::MAX).map_err(|source| ObjError {
            path: path.into(),
            line: None,
            problem: ObjProblem::Read(source),
        })?;
        Self::from_bytes(path, raw)
    }

    /// Reads a file from its bytes in memory. Errors name `path`, and `mtllib` paths are relative to the
    /// directory of `path`.
    ///
    /// # Errors
    /// As [`Document::read`].
    pub fn from_bytes(path: impl Into<PathBuf>, raw: Vec<u8>) -> Result<Self, ObjError> {
        let path = path.into();
        match parse(&raw) {
            Ok(parsed) => Ok(Self { path, raw, parsed, origin: None }),
            Err((line, problem)) => Err(ObjError { path, line, problem }),
        }
    }

    /// Returns the document of a file of another format, whose surface has the OBJ text `raw`.
    ///
    /// # Errors
    /// As [`Document::read`].
    pub(crate) fn of_origin(path: &Path, raw: Vec<u8>, origin: Origin) -> Result<Self, ObjError> {
        Ok(Self { origin: Some(Arc::new(origin)), ..Self::from_bytes(path, raw)? })
    }

    /// Returns the document of a changed text of this file.
    ///
    /// # Errors
    /// As [`Document::read`].
    pub(crate) fn with_bytes(&self, raw: Vec<u8>) -> Result<Self, ObjError> {
        Ok(Self { origin: self.origin.clone(), ..Self::from_bytes(self.path.clone(), raw)? })
    }

    /// Returns whether the file is an OBJ file. Otherwise the bytes and line numbers are not those of the file.
    pub fn is_obj(&self) -> bool {
        self.origin.is_none()
    }

    /// Returns descriptions of the parts of a file of another format that were not read, such as `2 primitives of lines`.
    pub fn ignored_parts(&self) -> &[String] {
        self.origin.as_ref().map_or(&[], |origin| &origin.ignored)
    }

    /// Returns the materials of a file of another format; none for an OBJ file, whose materials are in its libraries.
    pub(crate) fn own_materials(&self) -> &[(String, MaterialColor)] {
        self.origin.as_ref().map_or(&[], |origin| &origin.materials)
    }

    /// Returns the maps of a file of another format; `None` for an OBJ file, whose maps are in its text.
    pub(super) fn own_maps(&self) -> Option<&[(String, Vec<f32>)]> {
        self.origin.as_ref().map(|origin| &origin.maps[..])
    }

    /// Returns the path of the file, as given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.raw
    }

    /// Returns the number of `v` statements.
    pub fn vertex_count(&self) -> usize {
        self.parsed.positions.len()
    }

    /// Returns the number of `vn` statements.
    pub fn normal_count(&self) -> usize {
        self.parsed.normals.len()
    }

    /// Returns the number of faces with three corners or more.
    pub fn face_count(&self) -> usize {
        self.parsed.face_count()
    }

    /// Returns the number of lines in the file.
    pub fn line_count(&self) -> usize {
        self.parsed.lines
    }

    /// Returns the number of faces with fewer than three corners, which the mesh omits, and the line of the
    /// first such face.
    pub fn short_faces(&self) -> (usize, Option<usize>) {
        (self.parsed.short_faces, self.parsed.first_short_face)
    }

    /// Returns the objects (`o`) and groups (`g`) that have faces, in the order of their first statements.
    pub fn groups(&self) -> impl Iterator<Item = &Group> {
        self.parsed.groups.iter().filter(|group| !group.is_alias)
    }

    /// Returns the ignored statements: unknown keywords, lines, points, free-form curves and surfaces.
    pub fn ignored_statements(&self) -> &[IgnoredStatement] {
        &self.parsed.ignored
    }

    /// Returns the material libraries in `mtllib` statements, in order.
    pub fn libraries(&self) -> Vec<Library> {
        library::find(&self.raw, &self.parsed.libraries, self.directory())
    }

    /// Returns the directory that `mtllib` paths are relative to.
    pub(crate) fn directory(&self) -> &Path {
        match self.path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        }
    }

    /// Returns the positions of all `v` statements.
    pub(crate) fn positions(&self) -> &[[f64; 3]] {
        &self.parsed.positions
    }

    /// Returns the vectors of all `vn` statements.
    pub(crate) fn normals(&self) -> &[[f32; 3]] {
        &self.parsed.directions
    }

    /// Returns the byte ranges of the numbers in all `v` statements.
    pub(crate) fn vertex_numbers(&self) -> &[Numbers] {
        &self.parsed.vertices
    }

    /// Returns the byte ranges of the numbers in all `vn` statements.
    pub(crate) fn normal_numbers(&self) -> &[Numbers] {
        &self.parsed.normals
    }

    /// Returns the `v` index, from 0, of each corner of a face.
    pub(crate) fn face(&self, face: u32) -> &[u32] {
        &self.parsed.corners[self.corners_of(face)]
    }

    /// Returns the `vn` index, from 0, of each corner of a face. Returns `None` if a corner has no `vn`.
    pub(crate) fn face_normals(&self, face: u32) -> Option<&[u32]> {
        let normals = self.parsed.corner_normals.get(self.corners_of(face))?;
        normals.first().is_some_and(|&normal| normal != NO_NORMAL).then_some(normals)
    }

    /// Sets the positions of some `v`, which the text of the file may have rounded.
    pub(crate) fn set_positions<'a>(&mut self, positions: impl Iterator<Item = (u32, &'a Point3<f64>)>) {
        positions.for_each(|(v, position)| self.parsed.positions[v as usize] = (*position).into());
    }

    /// Returns the parsed contents, to change them.
    pub(super) fn parsed_mut(&mut self) -> &mut Parsed {
        &mut self.parsed
    }

    /// Returns whether the file has materials, as `usemtl` statements.
    pub(super) fn has_materials(&self) -> bool {
        self.parsed.has_materials
    }

    /// Returns the objects and groups that have faces, including aliases; see [`Group::is_alias`].
    pub(super) fn all_groups(&self) -> &[Group] {
        &self.parsed.groups
    }

    /// Returns an error about this file as a whole.
    pub(super) fn error(&self, problem: ObjProblem) -> ObjError {
        ObjError { path: self.path.clone(), line: None, problem }
    }

    /// Returns the range of a face in arrays with one entry per corner.
    pub(crate) fn corners_of(&self, face: u32) -> std::ops::Range<usize> {
        let offsets = &self.parsed.offsets;
        offsets[face as usize] as usize..offsets[face as usize + 1] as usize
    }
}
