//! Writes OBJ frames of a mesh that was not read from a file.

use super::number;
use supple::mesh::Mesh;

/// Text of the faces, which is the same in all frames. Each frame writes its vertices before this text.
#[derive(Debug)]
pub(super) struct PlainObj {
    faces: Vec<u8>,
}

impl PlainObj {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut faces = String::new();
        for face in mesh.faces().filter(|face| face.len() > 2) {
            faces.push('f');
            for corner in face {
                faces.push(' ');
                faces.push_str(&(corner + 1).to_string());
            }
            faces.push('\n');
        }
        Self { faces: faces.into_bytes() }
    }

    /// Appends the bytes of a frame to `text`.
    pub(super) fn fill(&self, positions: &[[f32; 3]], text: &mut Vec<u8>) {
        for position in positions {
            text.push(b'v');
            for &coordinate in position {
                text.push(b' ');
                number::append(text, coordinate);
            }
            text.push(b'\n');
        }
        text.extend_from_slice(&self.faces);
    }
}
