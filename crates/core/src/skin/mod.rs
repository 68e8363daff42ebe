//! The displayed mesh: positions and normals of the mesh vertices, computed from the lattice vertices.
//!
//! Vertices are evaluated in *chunks* of consecutive vertices. A *tile* is a small buffer of one thread,
//! whose rows hold the positions or the normals of one chunk; see `simd::tile`. The *one-ring* of a vertex
//! lists the neighbors of the vertex in order around it.
//!
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

pub use normals::{VertexNormals, vertex_normals};

use std::sync::OnceLock;

use crate::lattice::{Embedding, Slopes};
use crate::mesh::Mesh;
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::moving::Moving;
use crate::simd::xyzx::{Pair, Xyzx};
use crate::state::BodyFrame;
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
        match self {
            Self::Linear => "linear",
            Self::Smooth => "smooth",
        }
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

/// The input of an evaluation: the mesh, its embedding, and the positions of the lattice vertices.
#[derive(Clone, Copy)]
pub(crate) struct Pose<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) embedding: &'a Embedding,
    /// Position of each lattice vertex, in cells from the origin of the body frame.
    pub(crate) lattice: &'a [Xyzx],
    /// Slopes of the lattice, if the skin is smooth.
    pub(crate) slopes: Option<Slopes<'a>>,
    /// The motions of the mesh vertices to `lattice`, if they are known. Only for a smooth skin.
    pub(crate) motion: Option<SurfaceMotion<'a>>,
    /// The body frame: its origin and cell size in world space.
    pub(crate) frame: &'a BodyFrame,
}

/// The mesh vertices as points that move along straight lines, `p + lambda v`. The points of a component of the lattice
/// have the same `lambda`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceMotion<'a> {
    /// The mesh vertices, in the order of [`Embedding::by_cell`], relative to the center of their component.
    pub(crate) points: &'a [Moving],
    /// Component of each lattice vertex.
    pub(crate) component_of_vertex: &'a [u32],
    /// Motion of each component.
    pub(crate) components: &'a [ComponentMotion],
}

/// The motion of the points of a component of the lattice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ComponentMotion {
    /// The scale `lambda`, in cells.
    pub(crate) lambda: f32,
    /// The center, in cells from the origin of the body frame: `(x, y, z, x)`.
    pub(crate) center: Xyzx,
}

/// The output arrays, one entry per mesh vertex. `None` if an output is not computed.
pub(crate) struct Outputs<'a, P, N> {
    /// Positions in world space.
    pub(crate) positions: Option<&'a mut [[P; 3]]>,
    /// Unit normals.
    pub(crate) normals: Option<&'a mut [[N; 3]]>,
}

impl Pose<'_> {
    /// Returns the position of one mesh vertex.
    fn position(&self, vertex: usize) -> Xyzx {
        self.embedding.position(vertex, self.lattice, self.slopes)
    }
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
