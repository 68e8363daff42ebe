//! Normals, with or without positions: each vertex and those around it.

use super::Shown;
use super::runs::{Runs, RunsOf};
use super::write::{write_normals, write_positions};
use crate::coordinate::Coordinate;
use crate::dynamics::BodyFrame;
use crate::lattice::Embedding;
use crate::mesh::normals::{around_one, components};
use crate::mesh::rings::{CHUNK, Rings};
use crate::parallel::Executor;
use crate::tile::with_tiles;

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

    /// Writes the positions, if they are asked for, and the unit normals: positions in the world if there is a frame,
    /// else in cells.
    pub(super) fn show<P: Coordinate, N: Coordinate>(
        &self,
        executor: &Executor,
        shown: Shown,
        frame: Option<&BodyFrame>,
        positions: Option<&mut [[P; 3]]>,
        normals: &mut [[N; 3]],
    ) {
        let chunk = |chunk: usize, positions: Option<&mut [[P; 3]]>, normals: &mut [[N; 3]]| {
            with_tiles(|near, found| {
                self.runs.carry(chunk, shown.lattice, near.pairs());
                self.rings.find_normals(chunk, near, found);
                let places = self.rings.places(chunk);
                if let Some(positions) = positions {
                    write_positions(near, places.iter().map(|place| place.position), frame, positions);
                }
                write_normals(found, places.iter().map(|place| place.normal), normals);
            });
        };
        match positions {
            Some(positions) => {
                let both = |k: usize, positions: &mut [_], normals: &mut [_]| chunk(k, Some(positions), normals);
                executor.groups2(positions, normals, CHUNK, both);
            }
            None => executor.groups(normals, CHUNK, |k, normals| chunk(k, None, normals)),
        }
        self.show_singles(shown, normals);
    }

    /// The normals of vertices whose rings find no room in a tile.
    fn show_singles<T: Coordinate>(&self, shown: Shown, normals: &mut [[T; 3]]) {
        let at = |vertex: u32| shown.embedding.carried(self.points[vertex as usize] as usize, shown.lattice);
        for single in self.rings.singles() {
            let normal = around_one(at(single.centre), single.ring.iter().map(|&vertex| at(vertex)));
            normals[single.vertex as usize] = components(normal).map(T::of);
        }
    }
}
