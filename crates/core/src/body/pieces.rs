//! The mesh and the volume correction of a body in pieces. They are created when they are needed, after an event in
//! which joints broke.

use super::piece_mesh::PieceMesh;
use super::soft_body::Body;
use super::surface::Surface;
use crate::fracture::CutMesh;
use crate::lattice::{Embedding, Smoothing};
use crate::mesh::Mesh;
use crate::volume::{Correction, Preservation, VolumeMeasure, VolumeMeasures, VolumeOptions};

impl Body {
    /// Returns the mesh in the model's frame, or `None` for a bare lattice.
    pub fn mesh(&self) -> Option<&Mesh> {
        self.surface().map(|surface| &surface.mesh)
    }

    /// Returns the stencils of a smooth skin; `None` if the skin is linear.
    pub(crate) fn smoothing(&self) -> Option<&Smoothing> {
        self.surface().and_then(|surface| surface.embedding.smoothing())
    }

    /// Returns the piece of each vertex of the displayed mesh, shape `(k,)`: its number in
    /// [`Lattice::components`](crate::lattice::Lattice::components). `None` for a bare lattice.
    pub fn piece_of_mesh_vertices(&self) -> Option<Vec<u32>> {
        let embedding = &self.surface()?.embedding;
        let components = self.shape.lattice.components();
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

    /// Returns the map from the mesh of the whole body to the mesh of the pieces; `None` while the body is whole, and
    /// of a bare lattice. [`Body::mesh`] returns the mesh of the pieces.
    pub fn piece_mesh(&self) -> Option<&PieceMesh> {
        self.surface().and_then(|surface| surface.pieces.as_deref())
    }

    /// Returns the displayed mesh; `None` for a bare lattice. After an event, the first call cuts the mesh of the whole
    /// body.
    pub(crate) fn surface(&self) -> Option<&Surface> {
        self.shape.surface.as_ref().map(|surface| surface.get_or_init(|| self.cut_surface()))
    }

    /// Returns the volume correction; `None` if it is off. After an event, the first call creates it.
    pub(crate) fn correction(&self) -> Option<&Correction> {
        self.display.correction.get_or_init(|| self.pieces_correction()).as_ref()
    }

    /// Returns the measures for volume reports. The first call creates them.
    pub(crate) fn measures(&self) -> &VolumeMeasures {
        let surface = || self.surface().map(Surface::volume_surface);
        self.display.measures.get_or_init(|| VolumeMeasures::new(&self.shape.lattice, surface()))
    }

    /// Returns the measures for volume reports, if they were created.
    pub(crate) fn built_measures(&self) -> Option<&VolumeMeasures> {
        self.display.measures.get()
    }

    /// Creates the mesh of the pieces. If it has more vertices than a mesh can have, it is the mesh of the whole body.
    fn cut_surface(&self) -> Surface {
        let breaking = self.breaking.as_ref().expect("only breaking defers the mesh");
        let whole = breaking.whole.clone().expect("a body with a surface has a mesh");
        let (mesh, embedding, pieces) = match breaking.fracture.cut_mesh(&whole, &self.shape.lattice) {
            Ok(CutMesh { mesh, hosts, origins, face_sources, cap_uvs, .. }) => {
                let embedding = Embedding::in_cells(&self.shape.lattice, mesh.vertices(), &hosts);
                (mesh, embedding, Some(Box::new(PieceMesh { whole, origins, face_sources, cap_uvs })))
            }
            Err(_) => {
                let embedding = Embedding::new(&self.shape.lattice, whole.vertices());
                (whole, embedding, None)
            }
        };
        Surface::new(mesh, embedding, (&self.shape.lattice, self.settings.skin), pieces)
    }

    /// Creates the volume correction of the pieces. If the measure `mesh` cannot use their mesh, the volume of the
    /// cells is preserved.
    fn pieces_correction(&self) -> Option<Correction> {
        let surface = self.surface().map(Surface::volume_surface);
        let create = |options: &VolumeOptions| Correction::new(&self.shape.lattice, surface, options);
        let cells = VolumeOptions { measure: Preservation::By(VolumeMeasure::Cells), ..self.settings.volume };
        create(&self.settings.volume).or_else(|_| create(&cells)).unwrap_or_default()
    }
}
