//! Positions and normals of all vertices, chunk by chunk: each chunk is carried into a tile, its normals are found there, and the
//! outputs are written from there.

use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f32x4, f32x8, f64x4};

use super::Pose;
use super::normals::{around_one, components};
use super::rings::{CHUNK, Place, Rings, TileLayout};
use super::trilinear::{EmbeddedPoints, EmbeddedPointsBuilder};
use crate::lattice::Embedding;
use crate::mesh::Mesh;
use crate::parallel::Executor;
use crate::simd::tile::{Tile, offset, with_tiles};
use crate::simd::xyzx::{Pair, Xyzx};
use crate::simd::{Coordinate, level};
use crate::state::BodyFrame;

/// How many vertices may have to be carried for each one that is shown before it pays to reorder them.
const MAX_POINTS_PER_VERTEX: usize = 2;

/// Parts of the longest edge of the bounds; reordered vertices in the same ones may stand in any order.
const PARTS: f64 = 1024.0;

/// The positions alone: each vertex by itself.
#[derive(Debug)]
pub(super) struct Positions {
    embedded: EmbeddedPoints,
    /// Where each vertex is in the tile of its chunk, as an offset.
    places: Vec<u16>,
}

impl Positions {
    pub(super) fn new(embedding: &Embedding) -> Self {
        let vertices: Vec<u32> = (0..embedding.len() as u32).collect();
        let mut embedded = EmbeddedPointsBuilder::new(embedding, &vertices);
        let mut places = Vec::with_capacity(vertices.len());
        for chunk in vertices.chunks(CHUNK) {
            places.extend(embedded.rows(chunk).into_iter().map(offset));
            embedded.add(chunk);
        }
        Self { embedded: embedded.finish(), places }
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.embedded.bytes() + size_of_val(&*self.places)
    }

    /// Writes the positions in the world.
    pub(super) fn evaluate<T: Coordinate>(&self, executor: &Executor, pose: Pose, positions: &mut [[T; 3]]) {
        executor.share(positions.chunks_mut(CHUNK).enumerate(), |(chunk, positions)| {
            with_tiles(|near, _| {
                self.embedded.interpolate(chunk, pose.lattice, near.pairs());
                let places = self.places[chunk * CHUNK..].iter().copied();
                write_positions(near, places, pose.frame, positions);
            });
        });
    }
}

/// Normals, with or without positions: in the order of the input, if that keeps neighbours together, or in one that does.
#[derive(Debug)]
pub(super) enum Normals {
    InOrder(Neighborhoods),
    Reordered(Reordered),
}

impl Normals {
    pub(super) fn new(mesh: &Mesh, embedding: &Embedding) -> Self {
        let own = (0..embedding.len() as u32).collect();
        let vertices = Neighborhoods::new(mesh.triangles(), mesh.weld(), embedding, own);
        if vertices.keep_together() {
            Self::InOrder(vertices)
        } else {
            Self::Reordered(Reordered::new(mesh, embedding))
        }
    }

    /// Memory that they take.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::InOrder(vertices) => vertices.bytes(),
            Self::Reordered(vertices) => vertices.bytes(),
        }
    }

    /// Writes the positions in the world, unless `positions` is empty, and the unit normals.
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

/// Vertices and their one-rings, in an order that keeps neighbours together for the most part.
#[derive(Debug)]
pub(super) struct Neighborhoods {
    embedded: EmbeddedPoints,
    rings: Rings,
    /// The point of the embedding that each vertex is.
    points: Vec<u32>,
}

impl Neighborhoods {
    /// Prepares vertices: vertex `k` is point `points[k]` of the embedding.
    fn new(triangles: &[[u32; 3]], weld: &[u32], embedding: &Embedding, points: Vec<u32>) -> Self {
        let mut embedded = EmbeddedPointsBuilder::new(embedding, &points);
        let rings = Rings::new(triangles, weld, &mut embedded);
        Self { embedded: embedded.finish(), rings, points }
    }

    /// Whether few vertices have to be carried beside those of each chunk.
    fn keep_together(&self) -> bool {
        self.embedded.len() <= MAX_POINTS_PER_VERTEX * self.points.len()
    }

    fn bytes(&self) -> usize {
        self.embedded.bytes() + self.rings.bytes() + size_of_val(&*self.points)
    }

    /// Carries the vertices of a chunk and those around it, finds the normals, and calls `write` with the tiles of both and the
    /// places of the vertices in them.
    fn evaluate_chunk(&self, chunk: usize, pose: Pose, write: impl FnOnce(&Tile, &Tile, &[Place])) {
        with_tiles(|near, normals| {
            self.embedded.interpolate(chunk, pose.lattice, near.pairs());
            self.rings.find_normals(chunk, near, normals);
            write(near, normals, self.rings.places(chunk));
        });
    }

    /// The normals of vertices whose one-rings do not fit in a tile, by vertex.
    fn singles(&self, pose: Pose) -> impl Iterator<Item = (usize, Xyzx)> {
        let at = move |vertex: u32| {
            pose.embedding.extrapolated(self.points[vertex as usize] as usize, pose.lattice)
        };
        self.rings.singles().iter().map(move |single| {
            let ring = single.ring.iter().map(|&vertex| at(vertex));
            (single.vertex as usize, around_one(at(single.center), ring))
        })
    }

    fn evaluate<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        pose: Pose,
        positions: &mut [[P; 3]],
        normals: &mut [[N; 3]],
    ) {
        executor.share(chunks(positions, normals), |(chunk, positions, normals)| {
            self.evaluate_chunk(chunk, pose, |near, found, places| {
                write_positions(near, places.iter().map(|place| place.position), pose.frame, positions);
                for (out, place) in normals.iter_mut().zip(places) {
                    *out = components(found.get(place.normal)).map(N::of);
                }
            });
        });
        for (vertex, normal) in self.singles(pose) {
            normals[vertex] = components(normal).map(N::of);
        }
    }
}

/// Welded vertices along a curve through space, evaluated in that order and put back.
#[derive(Debug)]
pub(super) struct Reordered {
    vertices: Neighborhoods,
    /// Where each mesh vertex is among them.
    slots: Vec<u32>,
}

impl Reordered {
    fn new(mesh: &Mesh, embedding: &Embedding) -> Self {
        let (low, high) = mesh.bounds();
        let part = (high - low).amax() / PARTS;
        let mut points: Vec<u32> = (0..).zip(mesh.weld()).filter(|(v, w)| v == *w).map(|(v, _)| v).collect();
        points.sort_by_cached_key(|&point| {
            morton((mesh.vertices()[point as usize] - low).map(|x| (x / part) as u32).into())
        });
        let mut slots = vec![0; embedding.len()];
        (0..).zip(&points).for_each(|(slot, &point)| slots[point as usize] = slot);
        for vertex in 0..slots.len() {
            slots[vertex] = slots[mesh.weld()[vertex] as usize];
        }
        let triangles: Vec<_> =
            mesh.triangles().iter().map(|t| t.map(|corner| slots[corner as usize])).collect();
        let own: Vec<u32> = (0..points.len() as u32).collect();
        Self { vertices: Neighborhoods::new(&triangles, &own, embedding, points), slots }
    }

    fn bytes(&self) -> usize {
        self.vertices.bytes() + size_of_val(&*self.slots)
    }

    /// `records` receives the position of each vertex in cells, `(x, y, z, x)`, and its normal, `(z, x, y, z)`.
    fn evaluate<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        pose: Pose,
        positions: &mut [[P; 3]],
        normals: &mut [[N; 3]],
        records: &mut Vec<Pair>,
    ) {
        let Self { vertices, slots } = self;
        records.resize(vertices.points.len(), [0.0; 8]);
        executor.share(records.chunks_mut(CHUNK).enumerate(), |(chunk, records)| {
            vertices.evaluate_chunk(chunk, pose, |near, normals, places| {
                for (record, place) in records.iter_mut().zip(places) {
                    record[..4].copy_from_slice(&near.get(place.position));
                    record[4..].copy_from_slice(&normals.get(place.normal));
                }
            });
        });
        for (slot, normal) in vertices.singles(pose) {
            records[slot][4..].copy_from_slice(&normal);
        }
        executor.share(chunks(positions, normals), |(chunk, positions, normals)| {
            let own = || slots[chunk * CHUNK..].iter().map(|&slot| &records[slot as usize]);
            dispatch!(level(), simd => {
                let world = World::new(simd, pose.frame);
                for (position, record) in positions.iter_mut().zip(own()) {
                    let (local, _) = simd.split_f32x8(f32x8::load_array_ref(simd, record));
                    *position = world.position(simd, local);
                }
            });
            for (normal, [.., z, x, y, again]) in normals.iter_mut().zip(own()) {
                *normal = components([*z, *x, *y, *again]).map(N::of);
            }
        });
    }
}

/// Chunks of positions, empty if there are none, and of normals, numbered.
fn chunks<'a, P: Send, N: Send>(
    mut positions: &'a mut [P],
    normals: &'a mut [N],
) -> impl ExactSizeIterator<Item = (usize, &'a mut [P], &'a mut [N])> + Send {
    normals.chunks_mut(CHUNK).enumerate().map(move |(chunk, normals)| {
        let own = CHUNK.min(positions.len());
        (chunk, positions.split_off_mut(..own).unwrap_or_default(), normals)
    })
}

/// The place of a grid index on the Z-shaped curve through space (Morton 1966): the bits of its coordinates in turn.
fn morton(index: [u32; 3]) -> u64 {
    let mut code = 0;
    for bit in 0..21 {
        for (axis, coordinate) in index.iter().enumerate() {
            code |= u64::from(coordinate >> bit & 1) << (3 * bit + axis);
        }
    }
    code
}

/// From cells to the world.
#[derive(Clone, Copy)]
struct World<S: Simd> {
    origin: f64x4<S>,
    cell: f64x4<S>,
}

impl<S: Simd> World<S> {
    #[inline(always)]
    fn new(simd: S, frame: &BodyFrame) -> Self {
        let [x, y, z] = frame.origin.coords.into();
        Self { origin: f64x4::load_array(simd, [x, y, z, x]), cell: f64x4::splat(simd, frame.cell_size) }
    }

    /// The position in the world of one in cells.
    #[inline(always)]
    fn position<T: Coordinate>(self, simd: S, local: f32x4<S>) -> [T; 3] {
        let (local, _) = simd.widen_f32x8(simd.combine_f32x4(local, local));
        T::narrow(simd, local.mul_add(self.cell, self.origin))
    }
}

/// Writes the positions in the tile at `places`, as many as there is room for.
fn write_positions<T: Coordinate>(
    near: &Tile,
    places: impl Iterator<Item = u16>,
    frame: &BodyFrame,
    out: &mut [[T; 3]],
) {
    dispatch!(level(), simd => {
        let world = World::new(simd, frame);
        for (out, place) in out.iter_mut().zip(places) {
            *out = world.position(simd, near.one(simd, place));
        }
    });
}
