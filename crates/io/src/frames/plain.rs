//! Writes OBJ frames of a mesh that was not read from a file.

use super::number;
use super::pieces::Pieces;
use crate::obj::cap_material;
use supple::FaceSource;
use supple::mesh::Mesh;

/// Text of the faces, which is the same in all frames with the same topology. Each frame writes its vertices before
/// this text.
#[derive(Debug)]
pub(super) struct PlainObj {
    faces: Vec<u8>,
}

impl PlainObj {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut faces = String::new();
        mesh.faces().filter(|face| face.len() > 2).for_each(|face| append_face(&mut faces, face, None));
        Self { faces: faces.into_bytes() }
    }

    /// The pieces of the body `name`. Its caps have a material and texture coordinates.
    pub(super) fn of_pieces(pieces: &Pieces<'_>, name: &str) -> Self {
        let mut text = String::new();
        for [u, v] in pieces.cap_uvs() {
            text += &format!("vt {u} {v}\n");
        }
        let (mut texture, mut in_caps) = (0, false);
        for (face, source) in pieces.mesh.faces().zip(pieces.origin.face_sources()) {
            let is_cap = matches!(source, FaceSource::Cap { .. });
            if is_cap && !std::mem::replace(&mut in_caps, true) {
                text += &format!("usemtl {}\n", cap_material(name));
            }
            if face.len() > 2 {
                append_face(&mut text, face, is_cap.then_some(texture));
            }
            texture += if is_cap { face.len() } else { 0 };
        }
        Self { faces: text.into_bytes() }
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

/// Appends the text of a face. `texture`: the `vt` of its first corner, from 0.
fn append_face(text: &mut String, face: &[u32], texture: Option<usize>) {
    text.push('f');
    for (index, corner) in face.iter().enumerate() {
        text.push(' ');
        text.push_str(&(corner + 1).to_string());
        if let Some(texture) = texture {
            text.push('/');
            text.push_str(&(texture + index + 1).to_string());
        }
    }
    text.push('\n');
}
