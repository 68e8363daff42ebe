//! The mesh and the volume correction of a body in pieces. They are created when they are needed, after an event in
//! which joints broke.

use super::{Body, Surface};
use crate::fracture::{CutMesh, FaceSource, Origin};
use crate::lattice::Embedding;
use crate::mesh::{Mesh, RefinedMesh};
use crate::skin::{Skin, SkinKind};
use crate::volume::{Correction, Preservation, VolumeMeasure, VolumeMeasures, VolumeOptions};

/// How the mesh of the pieces of a body follows from the mesh of the whole body.
#[derive(Clone, Debug)]
pub struct PieceMesh {
    whole: Mesh,
    origins: Vec<Origin>,
    face_sources: Vec<FaceSource>,
    cap_uvs: Vec<[f64; 2]>,
}

impl PieceMesh {
    /// Returns where the vertices and faces of a refined mesh lie on the mesh `whole` that it was refined from. It has
    /// no caps.
    pub fn of_refined(whole: &Mesh, refined: &RefinedMesh) -> Self {
        let given = (0..whole.vertices().len() as u32).map(Origin::Vertex);
        let new = refined.points.iter().map(|&(vertices, weights)| match weights {
            [_, t, 0.0] if t > 0.0 => Origin::Edge { vertices: [vertices[0], vertices[1]], t },
            _ => Origin::Face { vertices, weights },
        });
        let source = |&(face, is_part): &(u32, bool)| match is_part {
            true => FaceSource::Part(face),
            false => FaceSource::Whole(face),
        };
        Self {
            whole: whole.clone(),
            origins: given.chain(new).collect(),
            face_sources: refined.sources.iter().map(source).collect(),
            cap_uvs: Vec::new(),
        }
    }

    /// Returns the mesh of the whole body, in the model's frame.
    pub fn whole(&self) -> &Mesh {
        &self.whole
    }

    /// Returns where each vertex of the pieces lies on the mesh of the whole body, shape `(k,)`.
    pub fn origins(&self) -> &[Origin] {
        &self.origins
    }

    /// Returns the origin of each face of the pieces. Faces of the surfaces of cracks come last.
    pub fn face_sources(&self) -> &[FaceSource] {
        &self.face_sources
    }

    /// Returns texture coordinates in the planes of the cracks, in the length unit of the mesh: one pair for each
    /// corner of each face of the surfaces of cracks, in the order of the faces.
    pub fn cap_uvs(&self) -> &[[f64; 2]] {
        &self.cap_uvs
    }
}

impl Body {
    /// Returns the piece of each vertex of the displayed mesh, shape `(k,)`: its number in
    /// [`Lattice::components`](crate::lattice::Lattice::components). `None` for a bare lattice.
    pub fn piece_of_mesh_vertices(&self) -> Option<Vec<u32>> {
        let embedding = &self.surface()?.embedding;
        let components = self.lattice.components();
        let piece = |vertex| components.of_vertex[embedding.corners(vertex)[0] as usize];
        Some((0..embedding.len()).map(piece).collect())
    }

    /// Returns the mesh of the whole body, in the model's frame; `None` for a bare lattice. Unlike [`Body::mesh`] it
    /// stays the same when the body breaks.
    pub fn whole_mesh(&self) -> Option<&Mesh> {
        match &self.breaking {
            Some(breaking) => breaking.whole.as_ref(),
            None => self.mesh(),
        }
    }

    /// Returns how the mesh of the pieces follows from that of the whole body; `None` while the body is whole, and of a
    /// bare lattice. [`Body::mesh`] returns the mesh of the pieces.
    pub fn piece_mesh(&self) -> Option<&PieceMesh> {
        self.surface().and_then(|surface| surface.pieces.as_deref())
    }

    /// Returns the displayed mesh; `None` for a bare lattice. After an event, the first call cuts the mesh of the whole
    /// body.
    pub(crate) fn surface(&self) -> Option<&Surface> {
        self.surface.as_ref().map(|surface| surface.get_or_init(|| self.cut_surface()))
    }

    /// Returns the volume correction; `None` if it is off. After an event, the first call creates it.
    pub(crate) fn correction(&self) -> Option<&Correction> {
        self.correction.get_or_init(|| self.pieces_correction()).as_ref()
    }

    /// Returns the measures for volume reports. The first call creates them.
    pub(crate) fn measures(&self) -> &VolumeMeasures {
        let surface = || self.surface().map(Surface::volume_surface);
        self.measures.get_or_init(|| VolumeMeasures::new(&self.lattice, surface()))
    }

    /// Returns the measures for volume reports, if they were created.
    pub(crate) fn built_measures(&self) -> Option<&VolumeMeasures> {
        self.measures.get()
    }

    /// Creates the mesh of the pieces. If it has more vertices than a mesh can have, it is the mesh of the whole body.
    fn cut_surface(&self) -> Surface {
        let breaking = self.breaking.as_ref().expect("only breaking defers the mesh");
        let whole = breaking.whole.clone().expect("a body with a surface has a mesh");
        let (mesh, embedding, pieces) = match breaking.fracture.cut_mesh(&whole, &self.lattice) {
            Ok(CutMesh { mesh, hosts, origins, face_sources, cap_uvs, .. }) => {
                let embedding = Embedding::in_cells(&self.lattice, mesh.vertices(), &hosts);
                (mesh, embedding, Some(Box::new(PieceMesh { whole, origins, face_sources, cap_uvs })))
            }
            Err(_) => {
                let embedding = Embedding::new(&self.lattice, whole.vertices());
                (whole, embedding, None)
            }
        };
        let embedding = match self.skin {
            SkinKind::Linear => embedding,
            SkinKind::Smooth => embedding.smoothed(&self.lattice),
        };
        Surface { mesh, embedding, skin: Skin::default(), pieces }
    }

    /// Creates the volume correction of the pieces. If the measure `mesh` cannot use their mesh, the volume of the
    /// cells is preserved.
    fn pieces_correction(&self) -> Option<Correction> {
        let surface = self.surface().map(Surface::volume_surface);
        let create = |options: &VolumeOptions| Correction::new(&self.lattice, surface, options);
        let cells = VolumeOptions { measure: Preservation::By(VolumeMeasure::Cells), ..self.volume };
        create(&self.volume).or_else(|_| create(&cells)).unwrap_or_default()
    }
}
