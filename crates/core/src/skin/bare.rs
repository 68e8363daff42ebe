//! Positions without normals: each vertex by itself.

use super::Shown;
use super::runs::{Runs, RunsOf};
use super::write::write_positions;
use crate::lattice::Embedding;
use crate::mesh::rings::{CHUNK, Layout};
use crate::parallel::Executor;
use crate::simd::Coordinate;
use crate::simd::tile::{offset, with_tiles};

/// What positions alone need.
#[derive(Debug)]
pub(super) struct Bare {
    runs: Runs,
    /// Where each vertex is in the tile of its chunk, as an offset.
    places: Vec<u16>,
}

impl Bare {
    /// Prepares the vertices of a mesh.
    pub(super) fn new(embedding: &Embedding) -> Self {
        let vertices: Vec<u32> = (0..embedding.len() as u32).collect();
        let mut runs = RunsOf::new(embedding, &vertices);
        let mut places = Vec::with_capacity(vertices.len());
        for chunk in vertices.chunks(CHUNK) {
            places.extend(runs.rows(chunk).into_iter().map(offset));
            runs.add(chunk);
        }
        Self { runs: runs.finish(), places }
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.runs.bytes() + size_of_val(&*self.places)
    }

    /// Writes the positions in the world.
    pub(super) fn show<T: Coordinate>(&self, executor: &Executor, shown: Shown, positions: &mut [[T; 3]]) {
        executor.share(positions.chunks_mut(CHUNK).enumerate(), |(chunk, positions)| {
            with_tiles(|near, _| {
                self.runs.carry(chunk, shown.lattice, near.pairs());
                let places = self.places[chunk * CHUNK..].iter().copied();
                write_positions(near, places, shown.frame, positions);
            });
        });
    }
}
