//! Normals, with or without positions, of a mesh whose order tears neighbours apart: sorted, and put back.

use fearless_simd::{SimdBase, dispatch, f32x4};

use super::Shown;
use super::turning::Turning;
use super::write::World;
use crate::coordinate::Coordinate;
use crate::lattice::Embedding;
use crate::mesh::Mesh;
use crate::parallel::{Executor, level};
use crate::padded::padded;

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
    /// In cells.
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
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
        let triangles: Vec<_> = mesh.triangles().iter().map(|t| t.map(|corner| slots[corner as usize])).collect();
        let (own, count) = ((0..points.len() as u32).collect::<Vec<_>>(), points.len());
        let turning = Turning::new(&triangles, &own, embedding, points);
        Self { turning, slots, positions: vec![[0.0; 3]; count], normals: vec![[0.0; 3]; count] }
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        let Self { turning, slots, positions, normals } = self;
        turning.bytes() + size_of_val(&**slots) + size_of_val(&**positions) + size_of_val(&**normals)
    }

    /// Writes the positions in the world, if they are asked for, and the unit normals.
    pub(super) fn show<P: Coordinate, N: Coordinate>(
        &mut self,
        executor: &Executor,
        shown: Shown,
        positions: Option<&mut [[P; 3]]>,
        normals: &mut [[N; 3]],
    ) {
        let Self { turning, slots, positions: sorted, normals: sorted_normals } = self;
        turning.show(executor, shown, None, positions.is_some().then_some(&mut sorted[..]), sorted_normals);
        let put_back = |group: usize, normals: &mut [[N; 3]]| {
            for (normal, &slot) in normals.iter_mut().zip(&slots[group * GROUP..]) {
                *normal = sorted_normals[slot as usize].map(N::of);
            }
        };
        match positions {
            Some(positions) => executor.groups2(positions, normals, GROUP, |group, positions, normals| {
                dispatch!(level(), simd => {
                    let world = World::new(simd, shown.frame);
                    for (position, &slot) in positions.iter_mut().zip(&slots[group * GROUP..]) {
                        *position = world.position(simd, f32x4::load_array(simd, padded(sorted[slot as usize])));
                    }
                });
                put_back(group, normals);
            }),
            None => executor.groups(normals, GROUP, put_back),
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
