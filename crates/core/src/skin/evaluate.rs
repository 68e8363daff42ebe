//! Evaluates the positions and normals of all vertices, chunk by chunk. Interpolates the positions of a chunk
//! into a tile, computes the normals of the chunk in a second tile, and writes the outputs from the two
//! tiles.

use fearless_simd::{Simd, SimdBase, dispatch, f32x4, f32x8, f64x4};

use super::mesh_update::{EmbeddedPoints, EmbeddedPointsBuilder};
use super::normals::{ring_normal, to_xyz};
use super::one_ring_blocks::{CHUNK, OneRingBlocks, TileLayout, TileOffsets};
use super::pose::Pose;
use crate::lattice::Embedding;
use crate::mesh::Mesh;
use crate::parallel::Executor;
use crate::simd::tile::{Tile, offset, with_tiles};
use crate::simd::vector::Product;
use crate::simd::xyzx::{Pair, Xyzx};
use crate::simd::{Coordinate, level};
use crate::state::BodyFrame;

/// Largest ratio of interpolated points to vertices for evaluation in input order. Above this ratio,
/// evaluation in Morton order is faster.
const MAX_POINTS_PER_VERTEX: usize = 2;

/// Number of Morton cells along the longest side of the bounding box. Vertices in one Morton cell keep their
/// order.
const MORTON_CELLS: f64 = 1024.0;

/// Tables for the evaluation of positions without normals.
#[derive(Debug)]
pub(super) struct Positions {
    embedded: EmbeddedPoints,
    /// Offset of each vertex in the tile of its chunk.
    offsets: Vec<u16>,
}

impl Positions {
    pub(super) fn new(embedding: &Embedding) -> Self {
        let vertices: Vec<u32> = (0..embedding.len() as u32).collect();
        let mut embedded = EmbeddedPointsBuilder::new(embedding, &vertices);
        let mut offsets = Vec::with_capacity(vertices.len());
        for chunk in vertices.chunks(CHUNK) {
            offsets.extend(embedded.rows(chunk).into_iter().map(offset));
            embedded.add(chunk);
        }
        Self { embedded: embedded.finish(), offsets }
    }

    /// Returns the memory of the tables, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.embedded.bytes() + size_of_val(&*self.offsets)
    }

    /// Writes the positions in world space.
    pub(super) fn evaluate<T: Coordinate>(&self, executor: &Executor, pose: Pose, positions: &mut [[T; 3]]) {
        executor.for_each(positions.chunks_mut(CHUNK).enumerate(), |(chunk, positions)| {
            with_tiles(|tile, _| {
                self.embedded.interpolate(chunk, pose, tile.pairs());
                let offsets = self.offsets[chunk * CHUNK..].iter().copied();
                write_positions(tile, offsets, pose.frame, positions);
            });
        });
    }
}

/// Tables for the evaluation of normals, with or without positions.
///
/// Vertices are evaluated in input order if most neighbors are then in common chunks, and in Morton order
/// otherwise.
#[derive(Debug)]
pub(super) enum Normals {
    /// Evaluation in input order.
    InOrder(Neighborhoods),
    /// Evaluation in Morton order.
    Reordered(Reordered),
}

impl Normals {
    pub(super) fn new(mesh: &Mesh, embedding: &Embedding) -> Self {
        let points = (0..embedding.len() as u32).collect();
        let vertices = Neighborhoods::new(mesh.surface(), mesh.weld(), embedding, points);
        if vertices.has_locality() {
            Self::InOrder(vertices)
        } else {
            Self::Reordered(Reordered::new(mesh, embedding))
        }
    }

    /// Returns the memory of the tables, in bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::InOrder(vertices) => vertices.bytes(),
            Self::Reordered(vertices) => vertices.bytes(),
        }
    }

    /// Writes the unit normals, and the positions in world space unless `positions` is empty.
    ///
    /// `records`: scratch, overwritten.
    pub(super) fn evaluate<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        pose: Pose,
        positions: &mut [[P; 3]],
        normals: &mut [[N; 3]],
        records: &mut Vec<Pair>,
    ) {
        match self {
            Self::InOrder(vertices) => vertices.evaluate(executor, pose, positions, normals),
            Self::Reordered(vertices) => vertices.evaluate(executor, pose, positions, normals, records),
        }
    }
}

/// Vertices and their one-rings, in an order that keeps most neighbors in common chunks.
#[derive(Debug)]
pub(super) struct Neighborhoods {
    embedded: EmbeddedPoints,
    rings: OneRingBlocks,
    /// Index of each vertex in the embedding.
    points: Vec<u32>,
}

impl Neighborhoods {
    /// Builds the tables. Vertex `k` is point `points[k]` of the embedding. `triangles` and `weld` refer to
    /// these vertices.
    fn new(triangles: &[[u32; 3]], weld: &[u32], embedding: &Embedding, points: Vec<u32>) -> Self {
        let mut embedded = EmbeddedPointsBuilder::new(embedding, &points);
        let rings = OneRingBlocks::new(triangles, weld, &mut embedded);
        Self { embedded: embedded.finish(), rings, points }
    }

    /// Returns whether the chunks need few neighbors from other chunks.
    fn has_locality(&self) -> bool {
        self.embedded.len() <= MAX_POINTS_PER_VERTEX * self.points.len()
    }

    fn bytes(&self) -> usize {
        self.embedded.bytes() + self.rings.bytes() + size_of_val(&*self.points)
    }

    /// Evaluates a chunk. Calls `write` with the tile of positions, the tile of normals, and the offsets of
    /// the chunk's vertices in both tiles.
    fn evaluate_chunk(&self, chunk: usize, pose: Pose, write: impl FnOnce(&Tile, &Tile, &[TileOffsets])) {
        with_tiles(|tile, normals| {
            self.embedded.interpolate(chunk, pose, tile.pairs());
            self.rings.find_normals(chunk, tile, normals);
            write(tile, normals, self.rings.offsets(chunk));
        });
    }

    /// Iterates over the vertices whose one-rings do not fit in a tile, with their unit normals.
    fn oversized(&self, pose: Pose) -> impl Iterator<Item = (usize, Xyzx)> {
        let position = move |vertex: u32| pose.position(self.points[vertex as usize] as usize);
        self.rings.oversized.iter().map(move |oversized| {
            let ring = oversized.ring.iter().map(|&vertex| position(vertex));
            (oversized.vertex as usize, ring_normal(position(oversized.center), ring))
        })
    }

    /// Writes the outputs, as [`Normals::evaluate`].
    fn evaluate<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        pose: Pose,
        positions: &mut [[P; 3]],
        normals: &mut [[N; 3]],
    ) {
        executor.for_each(chunks(positions, normals), |(chunk, positions, normals)| {
            self.evaluate_chunk(chunk, pose, |tile, normal_tile, offsets| {
                write_positions(tile, offsets.iter().map(|entry| entry.position), pose.frame, positions);
                for (out, entry) in normals.iter_mut().zip(offsets) {
                    *out = to_xyz(normal_tile.get(entry.normal)).map(N::of);
                }
            });
        });
        for (vertex, normal) in self.oversized(pose) {
            normals[vertex] = to_xyz(normal).map(N::of);
        }
    }
}

/// Welded vertices in Morton order. They are evaluated in this order, and the results are copied to the mesh
/// vertices.
#[derive(Debug)]
pub(super) struct Reordered {
    vertices: Neighborhoods,
    /// Index in `vertices` of each mesh vertex.
    reordered: Vec<u32>,
}

impl Reordered {
    fn new(mesh: &Mesh, embedding: &Embedding) -> Self {
        let (low, high) = mesh.bounds();
        let cell = (high - low).amax() / MORTON_CELLS;
        let mut points: Vec<u32> = (0..).zip(mesh.weld()).filter(|(v, w)| v == *w).map(|(v, _)| v).collect();
        points.sort_by_cached_key(|&point| {
            morton((mesh.vertices()[point as usize] - low).map(|x| (x / cell) as u32).into())
        });
        let mut reordered = vec![0; embedding.len()];
        (0..).zip(&points).for_each(|(index, &point)| reordered[point as usize] = index);
        for vertex in 0..reordered.len() {
            reordered[vertex] = reordered[mesh.weld()[vertex] as usize];
        }
        let triangles: Vec<_> =
            mesh.surface().iter().map(|t| t.map(|corner| reordered[corner as usize])).collect();
        // The vertices are welded already, so each is its own representative.
        let weld: Vec<u32> = (0..points.len() as u32).collect();
        Self { vertices: Neighborhoods::new(&triangles, &weld, embedding, points), reordered }
    }

    fn bytes(&self) -> usize {
        self.vertices.bytes() + size_of_val(&*self.reordered)
    }

    /// Writes the outputs, as [`Normals::evaluate`].
    ///
    /// `records`: scratch for the position of each vertex, `(x, y, z, x)` in cells, and its normal,
    /// `(z, x, y, z)`.
    fn evaluate<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        pose: Pose,
        positions: &mut [[P; 3]],
        normals: &mut [[N; 3]],
        records: &mut Vec<Pair>,
    ) {
        let Self { vertices, reordered } = self;
        records.resize(vertices.points.len(), [0.0; 8]);
        executor.for_each(records.chunks_mut(CHUNK).enumerate(), |(chunk, records)| {
            vertices.evaluate_chunk(chunk, pose, |tile, normals, offsets| {
                for (record, entry) in records.iter_mut().zip(offsets) {
                    record[..4].copy_from_slice(&tile.get(entry.position));
                    record[4..].copy_from_slice(&normals.get(entry.normal));
                }
            });
        });
        for (vertex, normal) in vertices.oversized(pose) {
            records[vertex][4..].copy_from_slice(&normal);
        }
        executor.for_each(chunks(positions, normals), |(chunk, positions, normals)| {
            let chunk_records = || reordered[chunk * CHUNK..].iter().map(|&index| &records[index as usize]);
            dispatch!(level(), simd => {
                let world = ToWorld::new(simd, pose.frame);
                for (position, record) in positions.iter_mut().zip(chunk_records()) {
                    let (local, _) = simd.split_f32x8(f32x8::load_array_ref(simd, record));
                    *position = world.position(simd, local);
                }
            });
            for (normal, [.., z, x, y, last]) in normals.iter_mut().zip(chunk_records()) {
                *normal = to_xyz([*z, *x, *y, *last]).map(N::of);
            }
        });
    }
}

/// Splits the outputs into numbered chunks. The chunks of `positions` are empty if `positions` is empty.
fn chunks<'a, P: Send, N: Send>(
    mut positions: &'a mut [P],
    normals: &'a mut [N],
) -> impl ExactSizeIterator<Item = (usize, &'a mut [P], &'a mut [N])> + Send {
    normals.chunks_mut(CHUNK).enumerate().map(move |(chunk, normals)| {
        let length = CHUNK.min(positions.len());
        (chunk, positions.split_off_mut(..length).unwrap_or_default(), normals)
    })
}

/// Returns the Morton code of a grid index (Morton 1966): the interleaved bits of the coordinates.
fn morton(index: [u32; 3]) -> u64 {
    let mut code = 0;
    for bit in 0..21 {
        for (axis, coordinate) in index.iter().enumerate() {
            code |= u64::from(coordinate >> bit & 1) << (3 * bit + axis);
        }
    }
    code
}

/// The map from the body frame, in cells, to world space.
#[derive(Clone, Copy)]
struct ToWorld<S: Simd> {
    origin: f64x4<S>,
    cell: f64x4<S>,
}

impl<S: Simd> ToWorld<S> {
    #[inline(always)]
    fn new(simd: S, frame: &BodyFrame) -> Self {
        let [x, y, z] = frame.origin.coords.into();
        Self { origin: f64x4::load_array(simd, [x, y, z, x]), cell: f64x4::splat(simd, frame.cell_size) }
    }

    /// Converts a position from the body frame, in cells, to world space.
    #[inline(always)]
    fn position<T: Coordinate>(self, simd: S, local: f32x4<S>) -> [T; 3] {
        let (local, _) = simd.widen_f32x8(simd.combine_f32x4(local, local));
        T::narrow(simd, local.times_plus(self.cell, self.origin))
    }
}

/// Converts the positions at `offsets` in the tile to world space, and writes them to `out` until `out` or
/// `offsets` ends.
fn write_positions<T: Coordinate>(
    tile: &Tile,
    offsets: impl Iterator<Item = u16>,
    frame: &BodyFrame,
    out: &mut [[T; 3]],
) {
    dispatch!(level(), simd => {
        let world = ToWorld::new(simd, frame);
        for (out, at) in out.iter_mut().zip(offsets) {
            *out = world.position(simd, tile.load(simd, at));
        }
    });
}
