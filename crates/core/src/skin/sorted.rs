//! Normals, with or without positions, of a mesh whose order tears neighbours apart: sorted, and put back.

use fearless_simd::{Simd, SimdBase, dispatch, f32x8};

use super::Shown;
use super::turning::Turning;
use super::write::World;
use crate::lattice::Embedding;
use crate::mesh::Mesh;
use crate::mesh::normals::components;
use crate::mesh::rings::CHUNK;
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::level;
use crate::simd::padded::Pair;

/// Vertices that one thread puts back at a time.
const GROUP: usize = 512;

/// Parts of the longest edge of the bounds; vertices in the same ones may stand in any order.
const PARTS: f64 = 1024.0;

/// Welded vertices, sorted.
#[derive(Debug)]
pub(super) struct Sorted {
    turning: Turning,
    /// Where each vertex is among them.
    slots: Vec<u32>,
    count: usize,
}

impl Sorted {
    /// Sorts the vertices of a mesh along a curve through space.
    pub(super) fn new(mesh: &Mesh, embedding: &Embedding) -> Self {
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
        let (own, count) = ((0..points.len() as u32).collect::<Vec<_>>(), points.len());
        let turning = Turning::new(&triangles, &own, embedding, points);
        Self { turning, slots, count }
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.turning.bytes() + size_of_val(&*self.slots)
    }

    /// Writes the positions in the world, if they are asked for, and the unit normals. `records` receives the position
    /// in cells, `(x, y, z, x)`, and the normal, `(z, x, y, z)`, of each sorted vertex.
    pub(super) fn show<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        shown: Shown,
        positions: Option<&mut [[P; 3]]>,
        normals: &mut [[N; 3]],
        records: &mut Vec<Pair>,
    ) {
        let Self { turning, slots, count } = self;
        records.resize(*count, [0.0; 8]);
        executor.share(records.chunks_mut(CHUNK).enumerate(), |(chunk, records)| {
            turning.turn(chunk, shown, |near, normals, places| {
                for (record, place) in records.iter_mut().zip(places) {
                    record[..4].copy_from_slice(&near.get(place.position));
                    record[4..].copy_from_slice(&normals.get(place.normal));
                }
            });
        });
        for (slot, normal) in turning.singles(shown) {
            records[slot][4..].copy_from_slice(&normal);
        }
        let own = |group: usize| slots[group * GROUP..].iter().map(|&slot| &records[slot as usize]);
        match positions {
            Some(positions) => {
                let both = positions.chunks_mut(GROUP).zip(normals.chunks_mut(GROUP));
                executor.share(both.enumerate(), |(group, (positions, normals))| {
                    dispatch!(level(), simd => {
                        let world = World::new(simd, shown.frame);
                        for ((position, normal), record) in positions.iter_mut().zip(normals).zip(own(group)) {
                            let (local, direction) = simd.split_f32x8(f32x8::load_array_ref(simd, record));
                            *position = world.position(simd, local);
                            *normal = components(direction.to_array()).map(N::of);
                        }
                    });
                });
            }
            None => executor.share(normals.chunks_mut(GROUP).enumerate(), |(group, normals)| {
                for (normal, [.., z, x, y, again]) in normals.iter_mut().zip(own(group)) {
                    *normal = components([*z, *x, *y, *again]).map(N::of);
                }
            }),
        }
    }
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
