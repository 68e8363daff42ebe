//! The skin: the mesh as the lattice carries it along, with its normals.
//!
//! Vertices are evaluated in chunks. In the order of the data: the one-ring of a vertex ([`one_ring`]) and those of all vertices in
//! blocks of eight ([`rings`]), prepared once; the vertices of a chunk carried cell by cell into a tile, which is near memory
//! ([`trilinear`]), their normals ([`normals`]), and what is written from there ([`evaluate`]).

mod evaluate;
mod normals;
mod one_ring;
mod rings;
mod trilinear;

pub use normals::{VertexNormals, vertex_normals};

use std::sync::OnceLock;

use crate::lattice::Embedding;
use crate::mesh::Mesh;
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::xyzx::{Pair, Xyzx};
use crate::state::BodyFrame;
use evaluate::{Normals, Positions};

/// The tables of an embedded mesh, each built when it is first needed. Its buffers are [`SkinBuffers`].
#[derive(Debug, Default)]
pub(crate) struct Skin {
    positions: OnceLock<Positions>,
    normals: OnceLock<Normals>,
}

/// The buffers of an evaluation. Every use overwrites them.
#[derive(Debug, Default)]
pub(crate) struct SkinBuffers(Vec<Pair>);

impl SkinBuffers {
    /// Memory that they take.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

/// Where the lattice is, and the mesh in it.
#[derive(Clone, Copy)]
pub(crate) struct Pose<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) embedding: &'a Embedding,
    /// One row per lattice vertex, in cells from the body's origin.
    pub(crate) lattice: &'a [Xyzx],
    /// Where that origin is.
    pub(crate) frame: &'a BodyFrame,
}

/// Where the results are written, one each per mesh vertex.
pub(crate) struct Outputs<'a, P, N> {
    /// Positions in the world.
    pub(crate) positions: Option<&'a mut [[P; 3]]>,
    /// Unit normals.
    pub(crate) normals: Option<&'a mut [[N; 3]]>,
}

impl Skin {
    /// Memory that it takes.
    pub(crate) fn bytes(&self) -> usize {
        self.positions.get().map_or(0, Positions::bytes) + self.normals.get().map_or(0, Normals::bytes)
    }

    /// Moves the mesh with the lattice, and writes the outputs.
    ///
    /// # Panics
    ///
    /// If there is another number of positions or normals than of mesh vertices.
    pub(crate) fn evaluate<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        pose: Pose,
        outputs: Outputs<P, N>,
        buffers: &mut SkinBuffers,
    ) {
        let Outputs { positions, normals } = outputs;
        let lengths = [positions.as_ref().map(|p| p.len()), normals.as_ref().map(|n| n.len())];
        for length in lengths.into_iter().flatten() {
            assert_eq!(length, pose.embedding.len(), "one position, one normal per mesh vertex");
        }
        if let Some(out) = normals {
            let normals = self.normals.get_or_init(|| Normals::new(pose.mesh, pose.embedding));
            normals.evaluate(executor, pose, positions.unwrap_or_default(), out, &mut buffers.0);
        } else if let Some(out) = positions {
            let positions = self.positions.get_or_init(|| Positions::new(pose.embedding));
            positions.evaluate(executor, pose, out);
        }
    }
}
