//! Writes PLY frames in binary little endian.
//!
//! A file is a header in text, followed by the vertices and the faces: Turk 1994, "The PLY polygon file
//! format".

use supple::mesh::Mesh;

use super::Source;

/// Returns the size of a frame, in bytes.
pub(super) fn frame_bytes(source: &Source<'_>) -> u64 {
    let mesh = source.mesh();
    Ply::new(mesh).len(mesh.vertices().len())
}

/// Bytes of the header and of the faces, which are the same in all frames.
#[derive(Debug)]
pub(super) struct Ply {
    header: Vec<u8>,
    faces: Vec<u8>,
}

impl Ply {
    /// Creates the header and the faces of a mesh. Faces are written as polygons if all have the same number
    /// of corners, otherwise as triangles, because common readers (trimesh) require binary lists of equal
    /// length. They also take polygons for fans, so that meshes with concave faces are written as triangles. Faces with
    /// fewer than three corners are omitted.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let polygons = || mesh.faces().filter(|face| face.len() > 2);
        let first = polygons().next().map_or(0, <[u32]>::len);
        let written: Vec<&[u32]> = if polygons().all(|face| face.len() == first) && mesh.is_fanned() {
            polygons().collect()
        } else {
            mesh.triangles().iter().map(<[u32; 3]>::as_slice).collect()
        };
        // The number of corners is a byte if it fits, as in the files of most programs.
        let fits_byte = written.iter().all(|face| u8::try_from(face.len()).is_ok());
        let mut faces = Vec::new();
        for face in &written {
            if fits_byte {
                faces.push(face.len() as u8);
            } else {
                faces.extend_from_slice(&(face.len() as u32).to_le_bytes());
            }
            face.iter().for_each(|corner| faces.extend_from_slice(&corner.to_le_bytes()));
        }
        let header = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
             property float x\nproperty float y\nproperty float z\n\
             property float nx\nproperty float ny\nproperty float nz\n\
             element face {}\nproperty list {} int vertex_indices\nend_header\n",
            mesh.vertices().len(),
            written.len(),
            if fits_byte { "uchar" } else { "int" },
        );
        Self { header: header.into_bytes(), faces }
    }

    /// Returns the size, in bytes, of a frame with `vertices` vertices.
    pub(super) fn len(&self, vertices: usize) -> u64 {
        (self.header.len() + 24 * vertices + self.faces.len()) as u64
    }

    /// Appends the bytes of a frame to `bytes`.
    pub(super) fn fill(&self, positions: &[[f32; 3]], normals: &[[f32; 3]], bytes: &mut Vec<u8>) {
        bytes.extend_from_slice(&self.header);
        for (position, normal) in positions.iter().zip(normals) {
            let [x, y, z] = position.map(f32::to_le_bytes);
            let [nx, ny, nz] = normal.map(f32::to_le_bytes);
            bytes.extend_from_slice([x, y, z, nx, ny, nz].as_flattened());
        }
        bytes.extend_from_slice(&self.faces);
    }
}
