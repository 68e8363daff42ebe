//! The measure of Takamatsu & Kanai (2009): a volume at each lattice vertex, from its six neighbours.

use fearless_simd::{Simd, dispatch};

use super::line::{Arm, Determinants, Line, Moving, load};
use super::measure::Scratch;
use super::sums::{ChunkedSum, DETERMINANTS, group_by_component};
use crate::parallel::Executor;
use crate::simd::level;

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

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.neighbours)
    }

    /// Adds the coefficients of each component to those of `scratch`.
    pub(super) fn add_coefficients(&self, executor: &Executor, scratch: &mut Scratch) {
        let Scratch { points, sums, coefficients, .. } = scratch;
        let rows = &self.neighbours;
        self.sums.add_to(
            executor,
            1.0 / 8.0,
            sums,
            coefficients,
            |range| dispatch!(level(), simd => sum(simd, &rows[range], points)),
        );
    }
}

/// The sum over vertices with these neighbours.
#[inline(always)]
fn sum<S: Simd>(simd: S, rows: &[[u32; 6]], points: &[Moving]) -> [f64; 4] {
    let mut sum = Determinants::zero(simd);
    for row in rows {
        let (x, y, z) = differences(simd, row, points);
        sum.add(x, y, z);
    }
    sum.coefficients()
}

/// The differences of the neighbours of a vertex along each axis: eight times its volume is their determinant.
#[inline(always)]
pub(super) fn differences<S: Simd>(simd: S, row: &[u32; 6], points: &[Moving]) -> (Line<S>, Arm<S>, Arm<S>) {
    let [x0, x1, y0, y1, z0, z1] = load(simd, points, row);
    (Line::zxy(simd, x1 - x0), Arm::new(simd, y1 - y0), Arm::new(simd, z1 - z0))
}
