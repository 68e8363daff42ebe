//! The mesh update: the mesh carried along by the lattice, with its normals.
//!
//! Vertices are worked on in chunks. Those of a chunk, and for normals those around them, are carried cell by cell into
//! near memory; their normals are found there; and what was asked for is written from there.

mod bare;
mod runs;
mod sorted;
mod turning;
mod write;

use std::sync::OnceLock;

use crate::lattice::Embedding;
use crate::mesh::Mesh;
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::padded::{Padded, Pair};
use crate::state::BodyFrame;
use bare::Bare;
use sorted::Sorted;
use turning::Turning;

/// The tables of an embedded mesh, each built when it is first needed. Its buffers are [`SkinBuffers`].
#[derive(Debug, Default)]
pub(crate) struct Skin {
    bare: OnceLock<Bare>,
    turning: OnceLock<InOrder>,
}

/// The buffers of a mesh update. Every use overwrites them.
#[derive(Debug, Default)]
pub(crate) struct SkinBuffers(Vec<Pair>);

impl SkinBuffers {
    /// Memory that they take.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

/// Vertices in the order of the input, if that keeps neighbours together, or in one that does.
#[derive(Debug)]
enum InOrder {
    Own(Turning),
    Sorted(Sorted),
}

/// Where the lattice is, and the mesh in it.
#[derive(Clone, Copy)]
pub(crate) struct Shown<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) embedding: &'a Embedding,
    /// One row per lattice vertex, in cells from the body's origin.
    pub(crate) lattice: &'a [Padded],
    /// Where that origin is.
    pub(crate) frame: &'a BodyFrame,
}

/// What is asked for, one each per mesh vertex.
pub(crate) struct Asked<'a, P, N> {
    /// Positions in the world.
    pub(crate) positions: Option<&'a mut [[P; 3]]>,
    /// Unit normals.
    pub(crate) normals: Option<&'a mut [[N; 3]]>,
}

impl Skin {
    /// Memory that it takes.
    pub(crate) fn bytes(&self) -> usize {
        let turning = match self.turning.get() {
            None => 0,
            Some(InOrder::Own(turning)) => turning.bytes(),
            Some(InOrder::Sorted(sorted)) => sorted.bytes(),
        };
        self.bare.get().map_or(0, Bare::bytes) + turning
    }

    /// Moves the mesh with the lattice, and writes what is asked for.
    ///
    /// # Panics
    ///
    /// If there is another number of positions or normals than of mesh vertices.
    pub(crate) fn show<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        shown: Shown,
        asked: Asked<P, N>,
        buffers: &mut SkinBuffers,
    ) {
        let Asked { positions, normals } = asked;
        let lengths = [positions.as_ref().map(|p| p.len()), normals.as_ref().map(|n| n.len())];
        for length in lengths.into_iter().flatten() {
            assert_eq!(length, shown.embedding.len(), "one position, one normal per mesh vertex");
        }
        match (positions, normals) {
            (None, None) => {}
            (Some(positions), None) => {
                self.bare.get_or_init(|| Bare::new(shown.embedding)).show(executor, shown, positions);
            }
            (positions, Some(normals)) => match self.turning.get_or_init(|| InOrder::new(shown)) {
                InOrder::Own(turning) => turning.show(executor, shown, positions, normals),
                InOrder::Sorted(sorted) => sorted.show(executor, shown, positions, normals, &mut buffers.0),
            },
        }
    }
}

impl InOrder {
    fn new(Shown { mesh, embedding, .. }: Shown) -> Self {
        let own = (0..embedding.len() as u32).collect();
        let turning = Turning::new(mesh.triangles(), mesh.weld(), embedding, own);
        if turning.keeps_together() { Self::Own(turning) } else { Self::Sorted(Sorted::new(mesh, embedding)) }
    }
}
