//! The buffers of an evaluation, and sums of cubics over many terms, of a shape that does not depend on the threads.

use std::ops::Range;

use super::adjacency::Adjacency;
use super::line::Moving;
use crate::lattice::Lattice;
use crate::parallel::Executor;

/// Beyond this a position is cut off, so that differences of positions stay finite.
const FARTHEST: f64 = 1e37;

/// Input, output and buffers of an evaluation. Grows to the size of the lattice once, and keeps its capacity.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Lattice vertices, relative to a center near their component, where single precision is fine enough for
    /// determinants.
    pub(super) points: Vec<Moving>,
    /// The coefficients of each component's volume in cubed cells, that of `lambda^k` at index `k`.
    pub(super) coefficients: Vec<[f64; 4]>,
    /// Surface points, and sums over chunks.
    pub(super) surface_points: Vec<Moving>,
    pub(super) sums: Vec<[f64; 4]>,
    /// Of each component: the sum of its positions, their number, and the center.
    centers: Vec<([f64; 3], f64, [f64; 3])>,
}

impl Scratch {
    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.points) + size_of_val(&*self.surface_points) + size_of_val(&*self.sums)
    }

    /// The places become `positions[i]` less the mean of the component; the directions are left as they are.
    pub(super) fn place(&mut self, positions: impl Iterator<Item = [f64; 3]> + Clone, adjacency: &Adjacency) {
        self.points.resize(adjacency.len(), Moving::default());
        self.coefficients.resize(adjacency.components, [0.0; 4]);
        self.centers.clear();
        self.centers.resize(adjacency.components, ([0.0; 3], 0.0, [0.0; 3]));
        for (p, &component) in positions.clone().zip(&adjacency.of_vertex) {
            let (sum, count, _) = &mut self.centers[component as usize];
            for (sum, p) in sum.iter_mut().zip(p) {
                *sum += p;
            }
            *count += 1.0;
        }
        for (sum, count, center) in &mut self.centers {
            // Whole cells: the subtraction is then exact for positions on the grid.
            *center = sum.map(|sum| (sum / *count).round());
        }
        for ((p, &component), point) in positions.zip(&adjacency.of_vertex).zip(&mut self.points) {
            let (_, _, center) = &self.centers[component as usize];
            point.set_place(std::array::from_fn(|k| (p[k] - center[k]).clamp(-FARTHEST, FARTHEST) as f32));
        }
    }

    /// The places become those of the lattice at rest.
    pub(super) fn place_at_rest(&mut self, lattice: &Lattice, adjacency: &Adjacency) {
        self.place(lattice.indices().iter().map(|index| index.map(f64::from)), adjacency);
    }
}

/// Terms in a chunk, where a term is a determinant. Fixed, so that the order of the additions is fixed.
pub(super) const DETERMINANTS: usize = 2048;

/// Terms sorted by component, cut into chunks: the terms of a chunk are summed in order, then the chunks in order.
#[derive(Clone, Debug)]
pub(super) struct ChunkedSum {
    chunks: Vec<Chunk>,
}

#[derive(Clone, Debug)]
struct Chunk {
    terms: Range<usize>,
    component: usize,
}

impl ChunkedSum {
    /// `counts[c]` terms of component `c`, one component after the other; `size` terms in a chunk.
    pub(super) fn new(counts: &[usize], size: usize) -> Self {
        Self { chunks: Vec::new() }.then(counts, size)
    }

    /// The same and more terms behind them, again one component after the other.
    pub(super) fn then(mut self, counts: &[usize], size: usize) -> Self {
        let mut first = self.chunks.last().map_or(0, |chunk| chunk.terms.end);
        for (component, count) in counts.iter().enumerate() {
            let end = first + count;
            while first < end {
                let next = end.min(first + size);
                self.chunks.push(Chunk { terms: first..next, component });
                first = next;
            }
        }
        self
    }

    /// Adds `factor` times the sum of the terms of each component to `out` (one per component). `sums` is scratch.
    pub(super) fn add_to(
        &self,
        executor: &Executor,
        factor: f64,
        sums: &mut Vec<[f64; 4]>,
        out: &mut [[f64; 4]],
        terms: impl Fn(Range<usize>) -> [f64; 4] + Sync,
    ) {
        sums.resize(self.chunks.len(), [0.0; 4]);
        executor.share(self.chunks.iter().zip(&mut *sums), |(chunk, sum)| *sum = terms(chunk.terms.clone()));
        for (chunk, terms) in self.chunks.iter().zip(sums) {
            for (sum, term) in out[chunk.component].iter_mut().zip(terms) {
                *sum += factor * *term;
            }
        }
    }
}
