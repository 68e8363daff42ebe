//! OBJ frames of a mesh that was read from a file: the file again, with new positions and normals.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::turned_normals::TurnedNormals;
use super::{library_path, number};
use crate::obj::{Document, Numbers, Part};

/// Stands for a `v` that the mesh does not have.
const KEPT: u32 = u32::MAX;

/// What changes in the text of a file, and where.
#[derive(Debug)]
pub(super) struct ObjTemplate {
    document: Arc<Document>,
    /// For each `v` the vertex of the mesh, or [`KEPT`].
    vertices: Vec<u32>,
    normals: TurnedNormals,
    /// The names of material libraries that change, and what they change to.
    libraries: Vec<(Range<usize>, Vec<u8>)>,
}

/// What is replaced next.
enum Change {
    Vertex,
    Normal,
    Library,
}

impl ObjTemplate {
    /// A template for frames that lie in `directory`, which must exist.
    pub(super) fn new(document: &Arc<Document>, part: &Part, directory: &Path) -> Self {
        let mut vertices = vec![KEPT; document.vertex_count()];
        for (vertex, of_file) in part.vertices().enumerate() {
            vertices[of_file as usize] = vertex as u32;
        }
        let rewritten = |library: crate::obj::Library| {
            Some((library.bytes.clone(), library_path::rewritten(&library, document.directory(), directory)?))
        };
        Self {
            vertices,
            normals: TurnedNormals::new(document, part),
            libraries: document.libraries().into_iter().filter_map(rewritten).collect(),
            document: document.clone(),
        }
    }

    /// Appends the file with the vertices of the mesh at `positions`.
    pub(super) fn fill(&self, positions: &[[f32; 3]], text: &mut Vec<u8>) {
        let raw = self.document.bytes();
        let mut vertices = self.document.vertex_numbers().iter().zip(&self.vertices).peekable();
        let mut normals = self.document.normal_numbers().iter().enumerate().peekable();
        let mut libraries = self.libraries.iter().peekable();
        let mut copied = 0;
        loop {
            // All three lists are in the order of the file.
            let candidates = [
                vertices.peek().map(|(numbers, _)| (numbers.start(), Change::Vertex)),
                normals.peek().map(|(_, numbers)| (numbers.start(), Change::Normal)),
                libraries.peek().map(|(range, _)| (range.start, Change::Library)),
            ];
            let Some((_, change)) = candidates.into_iter().flatten().min_by_key(|&(start, _)| start) else {
                break;
            };
            match change {
                Change::Vertex => {
                    if let Some((numbers, &vertex)) = vertices.next().filter(|&(_, &vertex)| vertex != KEPT) {
                        replace(raw, &mut copied, numbers, positions[vertex as usize], text);
                    }
                }
                Change::Normal => {
                    if let Some((normal, numbers)) =
                        normals.next().filter(|&(normal, _)| self.normals.is_used(normal))
                    {
                        replace(raw, &mut copied, numbers, self.normals.at(normal, positions), text);
                    }
                }
                Change::Library => {
                    if let Some((range, name)) = libraries.next() {
                        text.extend_from_slice(&raw[copied..range.start]);
                        text.extend_from_slice(name);
                        copied = range.end;
                    }
                }
            }
        }
        text.extend_from_slice(&raw[copied..]);
    }
}

/// Copies up to the numbers of a statement, and puts others in their place; what separates them is kept.
#[inline]
fn replace(raw: &[u8], copied: &mut usize, numbers: &Numbers, values: [f32; 3], text: &mut Vec<u8>) {
    for (range, value) in numbers.ranges().into_iter().zip(values) {
        text.extend_from_slice(&raw[*copied..range.start]);
        number::push(text, value);
        *copied = range.end;
    }
}
