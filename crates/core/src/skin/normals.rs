//! Area-weighted vertex normals, each summed over the one-ring of its vertex.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8};

use nalgebra::Vector3;

use super::one_ring_blocks::{CHUNK, NO_NORMAL, OneRingBlock, OneRingBlocks, TileLayout};
use crate::mesh::Mesh;
use crate::simd::level;
use crate::simd::tile::{Tile, with_tiles};
use crate::simd::vector::Product;
use crate::simd::xyzx::{Eight, Xyzx, broadcast_lanes, rotate_lanes, squared_lengths, store, xyzx};

/// Area-weighted vertex normals, prepared for many frames of one surface.
///
/// Welded vertices have the same normal, so that seams are not visible. The normal of a vertex without a
/// triangle of positive area is zero.
///
/// Each normal is one sum over the one-ring of its vertex, in a fixed order. The sums of different vertices
/// do not write to common memory.
#[derive(Clone, Debug)]
pub struct VertexNormals {
    rings: OneRingBlocks,
    /// The vertices of each tile, in the order of its rows.
    members: Vec<Vec<u32>>,
}

impl VertexNormals {
    /// Prepares the normals of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        Self::of_triangles(mesh.surface(), mesh.weld())
    }

    fn of_triangles(triangles: &[[u32; 3]], weld: &[u32]) -> Self {
        let mut members = Vec::new();
        Self { rings: OneRingBlocks::new(triangles, weld, &mut members), members }
    }

    /// Writes the unit normal of each vertex to `out`, given the position of each vertex.
    ///
    /// Only the first call in each thread allocates memory.
    ///
    /// # Panics
    /// If the length of `positions` or `out` is not the number of vertices of the mesh.
    pub fn compute(&mut self, positions: &[[f32; 3]], out: &mut [[f32; 3]]) {
        let Self { rings, members } = self;
        assert_eq!(positions.len(), rings.len(), "`positions` must have one entry per vertex");
        assert_eq!(out.len(), rings.len(), "`out` must have one entry per vertex");
        let position = |vertex: u32| xyzx(positions[vertex as usize]);
        for (chunk, out) in out.chunks_mut(CHUNK).enumerate() {
            with_tiles(|tile, normals| {
                for (row, &vertex) in tile.rows().iter_mut().zip(&members[chunk]) {
                    *row = position(vertex);
                }
                rings.find_normals(chunk, tile, normals);
                for (out, entry) in out.iter_mut().zip(rings.offsets(chunk)) {
                    *out = to_xyz(normals.get(entry.normal));
                }
            });
        }
        for oversized in &rings.oversized {
            let ring = oversized.ring.iter().map(|&vertex| position(vertex));
            out[oversized.vertex as usize] = to_xyz(ring_normal(position(oversized.center), ring));
        }
    }
}

impl TileLayout for Vec<Vec<u32>> {
    fn rows(&self, vertices: &[u32]) -> Vec<usize> {
        (0..vertices.len()).collect()
    }

    fn add(&mut self, vertices: &[u32]) {
        self.push(vertices.to_vec());
    }
}

/// Computes the area-weighted vertex normals of one frame: the one-shot form of [`VertexNormals`].
///
/// * `triangles`: corners as indices into `positions`, shape `(m, 3)`.
/// * `positions`: shape `(n, 3)`.
/// * `weld`: for each vertex, the vertex to which it is welded (itself if it is not welded), shape `(n,)`.
/// * `out`: the unit normals, shape `(n, 3)`.
///
/// # Panics
/// If lengths differ or an index is out of range.
pub fn vertex_normals(triangles: &[[u32; 3]], positions: &[[f32; 3]], weld: &[u32], out: &mut [[f32; 3]]) {
    VertexNormals::of_triangles(triangles, weld).compute(positions, out);
}

/// Converts a normal from the lane order `(z, x, y)` of the cross products to `(x, y, z)`.
#[inline(always)]
pub(super) fn to_xyz([z, x, y, _]: Xyzx) -> [f32; 3] {
    [x, y, z]
}

impl OneRingBlocks {
    /// Writes the unit normals of a chunk to `normals`, given the positions of the chunk's vertices and
    /// one-rings in `tile`.
    pub(super) fn find_normals(&self, chunk: usize, tile: &Tile, normals: &mut Tile) {
        normals.rows()[NO_NORMAL] = [0.0; 4];
        dispatch!(level(), simd => {
            for (block, normals) in self.blocks(chunk).zip(normals.blocks()) {
                block_normals(simd, tile, &self.block(block), normals);
            }
        });
    }
}

/// Writes the unit normals of the eight vertices of a block.
#[inline(always)]
fn block_normals<S: Simd>(simd: S, tile: &Tile, rings: &OneRingBlock, normals: &mut Eight) {
    let mut sums = area_vectors(simd, tile, rings);
    let length_squared = squared_lengths(simd, sums);
    let inverse = broadcast_lanes(simd, f32x8::splat(simd, 1.0) / length_squared.sqrt());
    for k in 0..4 {
        sums[k] *= inverse[k];
    }
    store(sums, normals);
    // Recomputes the normals in f64 if a squared length is zero, subnormal or not finite in f32.
    if !(length_squared.simd_ge(f32::MIN_POSITIVE) & length_squared.simd_le(f32::MAX)).all_true() {
        for (lane, normal) in normals.as_flattened_mut().as_chunks_mut().0.iter_mut().enumerate() {
            *normal = ring_normal(tile.get(rings.centers[lane]), rings.ring(lane).map(|at| tile.get(at)));
        }
    }
}

/// Returns, for each of eight one-rings, the sum of `(a - v) × (b - v)` over all pairs of consecutive entries
/// a and b, where v is the vertex that the one-ring surrounds.
///
/// The products of consecutive entries a, b and c are combined in one product:
/// `(a - v) × (b - v) + (b - v) × (c - v) = (b - v) × (c - a)`.
#[inline(always)]
fn area_vectors<S: Simd>(simd: S, tile: &Tile, rings: &OneRingBlock) -> [f32x8<S>; 4] {
    let centers = tile.gather(simd, rings.centers);
    let mut before = tile.gather(simd, rings.first);
    let mut sums = [f32x8::splat(simd, 0.0); 4];
    for [middle, after] in rings.pairs {
        let (middle, after) = (tile.gather(simd, middle), tile.gather(simd, after));
        for k in 0..4 {
            let (arm, edge) = (middle[k] - centers[k], after[k] - before[k]);
            // a * yzx(b) - yzx(a) * b is the cross product a × b in the lane order (z, x, y), where yzx(a) is
            // `rotate_lanes` of a.
            sums[k] = arm.times_plus(rotate_lanes(simd, edge), sums[k]);
            sums[k] = (-rotate_lanes(simd, arm)).times_plus(edge, sums[k]);
        }
        before = after;
    }
    sums
}

/// Returns the unit normal of one vertex, computed in `f64`, in the lane order `(z, x, y, z)`. Returns zero
/// if all triangles have zero area.
///
/// Used for normals whose squared length is outside the range of `f32`, and for one-rings that do not fit in
/// a tile.
pub(super) fn ring_normal(center: Xyzx, ring: impl Iterator<Item = Xyzx>) -> Xyzx {
    let wide = |[x, y, z, _]: Xyzx| Vector3::new(x, y, z).map(f64::from);
    let (mut sum, mut last) = (Vector3::zeros(), Vector3::zeros());
    for entry in ring {
        let arm = wide(entry) - wide(center);
        sum += last.cross(&arm);
        last = arm;
    }
    let [x, y, z] = sum.into();
    let length: f64 = (x * x + y * y + z * z).sqrt();
    if length > 0.0 { xyzx([z, x, y].map(|component| (component / length) as f32)) } else { [0.0; 4] }
}
