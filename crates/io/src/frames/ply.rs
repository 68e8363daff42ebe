//! PLY frames: binary little endian.
//!
//! Turk 1994, "The PLY polygon file format": a header in text, then the elements one after another.

use supple::mesh::Mesh;

/// Template of a PLY file: the header and the faces, which all frames share.
#[derive(Debug)]
pub(super) struct Ply {
    header: Vec<u8>,
    faces: Vec<u8>,
}

impl Ply {
    /// Creates a template. Faces are polygons if all have the same number of corners; otherwise they are
    /// triangles, because common readers (trimesh) accept binary lists of one length only. Faces with fewer
    /// than three corners are left out.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let polygons = || mesh.faces().filter(|face| face.len() > 2);
        let first = polygons().next().map_or(0, <[u32]>::len);
        let written: Vec<&[u32]> = if polygons().all(|face| face.len() == first) {
            polygons().collect()
        } else {
            mesh.triangles().iter().map(<[u32; 3]>::as_slice).collect()
        };
        // Like most writers, stores the number of corners as a byte if it fits.
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

    /// Returns the size of a frame with this number of vertices, in bytes.
    pub(super) fn len(&self, vertices: usize) -> u64 {
        (self.header.len() + 24 * vertices + self.faces.len()) as u64
    }

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
