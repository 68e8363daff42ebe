//! The displayed mesh: positions and normals of the mesh vertices, computed from the lattice vertices.
//!
//! Vertices are evaluated in *chunks* of consecutive vertices. A *tile* is a small buffer of one thread,
//! whose rows hold the positions or the normals of one chunk; see `simd::tile`. The *one-ring* of a vertex
//! lists the neighbors of the vertex in order around it.
//!
//! * [`pose`]: the input, the positions of the lattice vertices.
//! * [`evaluate`]: runs the following steps for all chunks, and writes the outputs from the tiles.
//! * [`mesh_update`]: the update of the mesh. Interpolates the vertices of a chunk, cell by cell, into a tile.
//! * [`normals`]: computes vertex normals from the one-rings.
//! * [`one_ring_blocks`], [`one_ring`]: the one-rings in blocks of eight. They are built once, and only if
//!   normals are evaluated.

mod evaluate;
mod mesh_update;
mod normals;
mod one_ring;
mod one_ring_blocks;
mod pose;

pub use normals::{VertexNormals, vertex_normals};
pub(crate) use pose::{ComponentMotion, Pose, SurfaceMotion};

use std::sync::OnceLock;

use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::xyzx::Pair;
use evaluate::{Normals, Positions};

/// How the mesh follows the lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SkinKind {
    /// Trilinear in each cell (Takamatsu & Kanai 2009). Where the body is strongly deformed, the surface has a crease
    /// at each face of a cell. The default.
    #[default]
    Linear,
    /// Smooth across the faces of the cells: the first derivatives are continuous. Where the lattice is bent or crushed
    /// so strongly that a smooth surface could fold, it is trilinear.
    Smooth,
}

impl SkinKind {
    /// All values, with their names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 2] = [("linear", Self::Linear), ("smooth", Self::Smooth)];

    /// Returns the name of the value in [`SkinKind::NAMED`].
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
    }
}

/// The evaluation tables of an embedded mesh. Each table is built at its first use. Buffers are in
/// [`SkinBuffers`].
#[derive(Debug, Default)]
pub(crate) struct Skin {
    positions: OnceLock<Positions>,
    normals: OnceLock<Normals>,
}

/// The buffers of an evaluation. Every evaluation overwrites them.
#[derive(Debug, Default)]
pub(crate) struct SkinBuffers(Vec<Pair>);

impl SkinBuffers {
    /// Returns the memory of the buffers, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

/// The output arrays, one entry per mesh vertex. `None` if an output is not computed.
pub(crate) struct Outputs<'a, P, N> {
    /// Positions in world space.
    pub positions: Option<&'a mut [[P; 3]]>,
    /// Unit normals.
    pub normals: Option<&'a mut [[N; 3]]>,
}

impl Skin {
    /// Returns the memory of the tables, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.positions.get().map_or(0, Positions::bytes) + self.normals.get().map_or(0, Normals::bytes)
    }

    /// Evaluates the mesh and writes the outputs.
    ///
    /// # Panics
    ///
    /// If the length of an output is not the number of mesh vertices.
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
            assert_eq!(length, pose.embedding.len(), "each output must have one entry per mesh vertex");
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
