//! Normals, with or without positions: each vertex and those around it.

use super::Shown;
use super::runs::{Runs, RunsOf};
use super::write::{write_normals, write_positions};
use crate::lattice::Embedding;
use crate::mesh::normals::{around_one, components};
use crate::mesh::rings::{CHUNK, Place, Rings};
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::padded::Padded;
use crate::simd::tile::{Tile, with_tiles};

/// How many vertices may have to be carried for each one that is shown before it pays to sort them.
const MOST_CARRIED: usize = 2;

/// Vertices in an order that keeps neighbours together for the most part.
#[derive(Debug)]
pub(super) struct Turning {
    runs: Runs,
    rings: Rings,
    /// The point of the embedding that each vertex is.
    points: Vec<u32>,
}

impl Turning {
    /// Prepares vertices: vertex `k` is point `points[k]` of the embedding.
    pub(super) fn new(triangles: &[[u32; 3]], weld: &[u32], embedding: &Embedding, points: Vec<u32>) -> Self {
        let mut runs = RunsOf::new(embedding, &points);
        let rings = Rings::new(triangles, weld, &mut runs);
        Self { runs: runs.finish(), rings, points }
    }

    /// Whether the vertices around those of a chunk are few.
    pub(super) fn keeps_together(&self) -> bool {
        self.runs.len() <= MOST_CARRIED * self.points.len()
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.runs.bytes() + self.rings.bytes() + size_of_val(&*self.points)
    }

    /// Carries the vertices of a chunk and those around it, finds the normals, and hands on both, and where in them
    /// the vertices are.
    pub(super) fn turn(&self, chunk: usize, shown: Shown, hand_on: impl FnOnce(&Tile, &Tile, &[Place])) {
        with_tiles(|near, normals| {
            self.runs.carry(chunk, shown.lattice, near.pairs());
            self.rings.find_normals(chunk, near, normals);
            hand_on(near, normals, self.rings.places(chunk));
        });
    }

    /// The normals of vertices whose rings find no room in a tile, by vertex.
    pub(super) fn singles(&self, shown: Shown) -> impl Iterator<Item = (usize, Padded)> {
        let at =
            move |vertex: u32| shown.embedding.carried(self.points[vertex as usize] as usize, shown.lattice);
        self.rings.singles().iter().map(move |single| {
            let ring = single.ring.iter().map(|&vertex| at(vertex));
            (single.vertex as usize, around_one(at(single.centre), ring))
        })
    }

    /// Writes the positions in the world, if they are asked for, and the unit normals.
    pub(super) fn show<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        shown: Shown,
        positions: Option<&mut [[P; 3]]>,
        normals: &mut [[N; 3]],
    ) {
        match positions {
            Some(positions) => {
                let both = positions.chunks_mut(CHUNK).zip(normals.chunks_mut(CHUNK));
                executor.share(both.enumerate(), |(chunk, (positions, normals))| {
                    self.turn(chunk, shown, |near, found, places| {
                        let at = places.iter().map(|place| place.position);
                        write_positions(near, at, shown.frame, positions);
                        write_normals(found, places, normals);
                    });
                });
            }
            None => executor.share(normals.chunks_mut(CHUNK).enumerate(), |(chunk, normals)| {
                self.turn(chunk, shown, |_, found, places| write_normals(found, places, normals));
            }),
        }
        for (vertex, normal) in self.singles(shown) {
            normals[vertex] = components(normal).map(N::of);
        }
    }
}
