//! The measure of Takamatsu & Kanai (2009): a volume at each lattice vertex, from its six neighbours.

use super::line::{Moving, determinant};
use super::sums::{ChunkedSum, DETERMINANTS, add, group_by_component};
use crate::parallel::Executor;

/// Sum over the vertices of `det[dx, dy, dz]`, with `da` half the difference of the two neighbours along axis `a`.
///
/// A missing neighbour is replaced by the vertex itself: a vertex on a face of a box then counts half a cell, on an
/// edge a quarter, in a corner an eighth, and a box of cells has exactly its own volume.
#[derive(Clone, Debug)]
pub(super) struct LatticeMeasure {
    neighbours: Vec<[u32; 6]>,
    sums: ChunkedSum,
}

impl LatticeMeasure {
    /// `neighbours[i]`: -x, +x, -y, +y, -z, +z of vertex `i`, itself where one is missing.
    pub(super) fn new(mut neighbours: Vec<[u32; 6]>, components: usize, of_vertex: &[u32]) -> Self {
        // A row names at least one vertex of its component, whichever way its neighbours are missing.
        let counts = group_by_component(&mut neighbours, components, |row| of_vertex[row[0] as usize]);
        Self { neighbours, sums: ChunkedSum::new(&counts, DETERMINANTS) }
    }

    /// Adds the coefficients of each component to `out`.
    pub(super) fn add_coefficients(&mut self, executor: &Executor, points: &[Moving], out: &mut [[f64; 4]]) {
        let rows = &self.neighbours;
        self.sums.add_to(executor, 1.0 / 8.0, out, |range| {
            let mut sum = [0.0; 4];
            for row in &rows[range] {
                let [x0, x1, y0, y1, z0, z1] = row.map(|i| points[i as usize].line());
                add(&mut sum, &determinant(x1.minus(x0), y1.minus(y0), z1.minus(z0)));
            }
            sum
        });
    }
}
