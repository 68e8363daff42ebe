//! The pieces of a broken body, as frames need them.

use supple::mesh::Mesh;
use supple::{Body, Lattice, Origin, PieceMesh};

use super::Source;
use super::record::Recorder;

/// Number of elements that are hashed at a time.
const BLOCK: usize = 4096;

/// The pieces of a body that is broken, and its input.
#[derive(Clone, Copy, Debug)]
pub struct Pieces<'a> {
    /// Hash of the mesh at rest and of the links of the lattice. Writers rebuild their texts when it changes. Unlike
    /// [`Body::topology_version`] it also differs after a state was restored that broke in another way.
    pub(super) identity: u64,
    /// The mesh of the pieces.
    pub(super) mesh: &'a Mesh,
    /// Its origin.
    pub(super) origin: &'a PieceMesh,
    /// The lattice of the body.
    pub(super) lattice: &'a Lattice,
    /// Input of the body.
    pub(super) source: Source<'a>,
    /// Factor by which the input was scaled.
    scale: f64,
    /// Whether the vertices may belong to several pieces, each of which turns differently.
    is_broken: bool,
}

impl<'a> Pieces<'a> {
    /// Returns the pieces of a body; `None` while it is whole. `source`: the input of the body.
    pub fn of(body: &'a Body, source: Source<'a>) -> Option<Self> {
        let (mesh, origin) = body.mesh().zip(body.piece_mesh())?;
        let lattice = body.lattice();
        let scale = body.scale().of_lengths();
        let identity = identity(mesh, lattice);
        Some(Self { identity, mesh, origin, lattice, source, scale, is_broken: true })
    }

    /// The mesh of a body that is refined and not broken. `origin`: that of `mesh` on the mesh of the input.
    pub(super) fn refined(
        body: &'a Body,
        source: Source<'a>,
        (mesh, origin): (&'a Mesh, &'a PieceMesh),
    ) -> Self {
        let lattice = body.lattice();
        Self { identity: 0, mesh, origin, lattice, source, scale: 1.0, is_broken: false }
    }

    /// Returns the piece of each vertex.
    pub(super) fn of_vertices(&self) -> Vec<u32> {
        if self.is_broken { self.mesh.component_of_vertices() } else { vec![0; self.mesh.vertices().len()] }
    }

    /// Returns the texture coordinates of the corners of the caps, in the unit of the input, as are the `vt` of faces
    /// that are mapped by lengths: a body that is scaled has the same texture, scaled.
    pub(super) fn cap_uvs(&self) -> impl Iterator<Item = [f32; 2]> {
        self.origin.cap_uvs().iter().map(|uv| uv.map(|number| (number / self.scale) as f32))
    }
}

/// Returns a hash of a mesh and of the links of a lattice.
fn identity(mesh: &Mesh, lattice: &Lattice) -> u64 {
    let mut recorder = Recorder::default();
    recorder.append(lattice.links());
    // In blocks, so that no copy of the mesh is made.
    for block in mesh.vertices().chunks(BLOCK) {
        let numbers = block.iter().flat_map(|vertex| vertex.iter().copied().flat_map(f64::to_le_bytes));
        recorder.append(&numbers.collect::<Vec<u8>>());
    }
    for block in mesh.triangles().chunks(BLOCK) {
        let corners = block.as_flattened().iter().copied().flat_map(u32::to_le_bytes);
        recorder.append(&corners.collect::<Vec<u8>>());
    }
    recorder.record().hash
}

/// Corners of a face and their weights. Their sum is 1; unused entries have weight 0.
pub(super) type Blend = [(usize, f64); 3];

/// Returns the place of a vertex of the pieces on a face of the whole mesh, from its origin.
pub(super) fn on_face(origin: &Origin, vertex: u32, face: &[u32]) -> Blend {
    let corner = |vertex: u32| face.iter().position(|&other| other == vertex).unwrap_or(0);
    match *origin {
        Origin::Vertex(vertex) => [(corner(vertex), 1.0), (0, 0.0), (0, 0.0)],
        Origin::Edge { vertices: [a, b], t } => [(corner(a), 1.0 - t), (corner(b), t), (0, 0.0)],
        Origin::Face { vertices, weights } => std::array::from_fn(|k| (corner(vertices[k]), weights[k])),
        // No face of the surface has a vertex inside the mesh.
        Origin::Cap { .. } => [(corner(vertex), 1.0), (0, 0.0), (0, 0.0)],
    }
}
