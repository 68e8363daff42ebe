//! Vertex normals of a moving surface.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8};

use nalgebra::Vector3;

use super::rings::{CHUNK, EightRings, NO_NORMAL, Rings, TileLayout};
use crate::mesh::Mesh;
use crate::simd::level;
use crate::simd::tile::{Tile, with_tiles};
use crate::simd::xyzx::{Eight, Xyzx, spread, squares, store, turned, xyzx};

/// Area-weighted vertex normals, prepared for many frames of one surface.
///
/// Vertices that were welded share a normal, so no seam shows. A normal of a vertex without area around it is zero.
///
/// The area vectors of the triangles around a vertex are summed where they are needed, not where they arise: each
/// normal is one sum in one order, and nothing is added to memory that others add to.
#[derive(Clone, Debug)]
pub struct VertexNormals {
    rings: Rings,
    /// The vertices of each tile, in their order.
    members: Vec<Vec<u32>>,
}

impl VertexNormals {
    /// Prepares the normals of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        Self::of_triangles(mesh.triangles(), mesh.weld())
    }

    fn of_triangles(triangles: &[[u32; 3]], weld: &[u32]) -> Self {
        let mut members = Vec::new();
        Self { rings: Rings::new(triangles, weld, &mut members), members }
    }

    /// Writes the unit normal of each vertex at `positions` (one per vertex) to `out` (one per vertex).
    ///
    /// Nothing is allocated after a thread's first time.
    ///
    /// # Panics
    /// If `positions` or `out` have another length than the mesh has vertices.
    pub fn compute(&mut self, positions: &[[f32; 3]], out: &mut [[f32; 3]]) {
        let Self { rings, members } = self;
        assert_eq!(positions.len(), rings.len(), "one position per vertex");
        assert_eq!(out.len(), rings.len(), "one normal per vertex");
        let at = |vertex: u32| xyzx(positions[vertex as usize]);
        for (chunk, out) in out.chunks_mut(CHUNK).enumerate() {
            with_tiles(|near, normals| {
                for (row, &vertex) in near.rows().iter_mut().zip(&members[chunk]) {
                    *row = at(vertex);
                }
                rings.find_normals(chunk, near, normals);
                for (out, place) in out.iter_mut().zip(rings.places(chunk)) {
                    *out = components(normals.get(place.normal));
                }
            });
        }
        for single in rings.singles() {
            let ring = single.ring.iter().map(|&vertex| at(vertex));
            out[single.vertex as usize] = components(around_one(at(single.center), ring));
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

/// Area-weighted vertex normals of one frame: the one-shot form of [`VertexNormals`].
///
/// `triangles` index `positions`; `weld` gives for each vertex the one whose normal it shares (itself, if none);
/// `out` has one normal per vertex.
///
/// # Panics
/// If lengths differ or an index is out of range.
pub fn vertex_normals(triangles: &[[u32; 3]], positions: &[[f32; 3]], weld: &[u32], out: &mut [[f32; 3]]) {
    VertexNormals::of_triangles(triangles, weld).compute(positions, out);
}

/// A normal from its row, `(z, x, y)` as cross products leave it.
#[inline(always)]
pub(super) fn components([z, x, y, _]: Xyzx) -> [f32; 3] {
    [x, y, z]
}

impl Rings {
    /// Finds the unit normals of a chunk whose vertices lie in the tile `near`.
    pub(super) fn find_normals(&self, chunk: usize, near: &Tile, normals: &mut Tile) {
        normals.rows()[NO_NORMAL] = [0.0; 4];
        dispatch!(level(), simd => {
            for (block, normals) in self.blocks(chunk).zip(normals.eights()) {
                around(simd, near, &self.block(block), normals);
            }
        });
    }
}

/// The unit normals of eight vertices.
#[inline(always)]
fn around<S: Simd>(simd: S, near: &Tile, rings: &EightRings, normals: &mut Eight) {
    let mut sums = sums(simd, near, rings);
    let squared = squares(simd, sums);
    let inverse = spread(simd, f32x8::splat(simd, 1.0) / squared.sqrt());
    for k in 0..4 {
        sums[k] *= inverse[k];
    }
    store(sums, normals);
    if !(squared.simd_ge(f32::MIN_POSITIVE) & squared.simd_le(f32::MAX)).all_true() {
        for (lane, normal) in normals.as_flattened_mut().as_chunks_mut().0.iter_mut().enumerate() {
            *normal = around_one(near.get(rings.centers[lane]), rings.ring(lane).map(|at| near.get(at)));
        }
    }
}

/// The sum of `(a - v) x (b - v)` along each of eight rings.
///
/// Two triangles that share `b` are one product: `(a - v) x (b - v) + (b - v) x (c - v) = (b - v) x (c - a)`.
#[inline(always)]
fn sums<S: Simd>(simd: S, near: &Tile, rings: &EightRings) -> [f32x8<S>; 4] {
    let centers = near.gather(simd, rings.centers);
    let mut before = near.gather(simd, rings.first);
    let mut sums = [f32x8::splat(simd, 0.0); 4];
    for [middle, after] in rings.pairs {
        let (middle, after) = (near.gather(simd, middle), near.gather(simd, after));
        for k in 0..4 {
            let (arm, edge) = (middle[k] - centers[k], after[k] - before[k]);
            // a yzx(b) - yzx(a) b is the cross product, turned by one.
            sums[k] = arm.mul_add(turned(simd, edge), sums[k]);
            sums[k] = (-turned(simd, arm)).mul_add(edge, sums[k]);
        }
        before = after;
    }
    sums
}

/// The unit normal of one vertex in `f64`, for squares that leave the range of `f32` and rings that no tile holds; zero
/// where no triangle has area.
pub(super) fn around_one(center: Xyzx, ring: impl Iterator<Item = Xyzx>) -> Xyzx {
    let wide = |[x, y, z, _]: Xyzx| Vector3::new(x, y, z).map(f64::from);
    let (mut sum, mut last) = (Vector3::zeros(), Vector3::zeros());
    for at in ring {
        let arm = wide(at) - wide(center);
        sum += last.cross(&arm);
        last = arm;
    }
    let [x, y, z] = sum.into();
    let length: f64 = (x * x + y * y + z * z).sqrt();
    if length > 0.0 { xyzx([z, x, y].map(|component| (component / length) as f32)) } else { [0.0; 4] }
}
