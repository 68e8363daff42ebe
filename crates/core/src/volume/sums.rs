//! Buffers of an evaluation, and sums of cubics in an order that does not depend on the number of threads.

use std::ops::Range;

use super::adjacency::Adjacency;
use super::line::Moving;
use crate::lattice::Lattice;
use crate::parallel::Executor;

/// Bound to which coordinates are clamped, so that differences of positions stay finite in f32.
const MAX_COORD: f64 = 1e37;

/// Input, output and buffers of an evaluation. They grow to the size of the lattice and keep their capacity.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Lattice vertices relative to the center of their component, so that f32 is accurate enough for
    /// determinants.
    pub(super) points: Vec<Moving>,
    /// Coefficients of each component's volume in cubed cells, that of `lambda^k` at index `k`.
    pub(super) coefficients: Vec<[f64; 4]>,
    /// Points of the embedded surface.
    pub(super) surface_points: Vec<Moving>,
    /// Sums over chunks.
    pub(super) sums: Vec<[f64; 4]>,
    /// Sum of the positions, their number, and the center, of each component.
    centers: Vec<([f64; 3], f64, [f64; 3])>,
}

impl Scratch {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.points) + size_of_val(&*self.surface_points) + size_of_val(&*self.sums)
    }

    /// Sets the points to `positions`, relative to the rounded mean of their component; keeps the directions.
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
            // Rounded to whole cells: the subtraction is then exact for positions on the grid.
            *center = sum.map(|sum| (sum / *count).round());
        }
        for ((p, &component), point) in positions.zip(&adjacency.of_vertex).zip(&mut self.points) {
            let (_, _, center) = &self.centers[component as usize];
            point.set_place(std::array::from_fn(|k| (p[k] - center[k]).clamp(-MAX_COORD, MAX_COORD) as f32));
        }
    }

    /// Sets the points' positions to those of the lattice at rest.
    pub(super) fn place_at_rest(&mut self, lattice: &Lattice, adjacency: &Adjacency) {
        self.place(lattice.indices().iter().map(|index| index.map(f64::from)), adjacency);
    }
}

/// Number of terms in a chunk of determinants. It is constant, so that the order of the additions is too.
pub(super) const DETERMINANTS: usize = 2048;

/// Chunked sum of terms sorted by component: adds the terms of each chunk in order, then the chunks in order.
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
    /// Creates the chunks of `counts[c]` terms of each component `c`, in order, with `size` terms in a chunk.
    pub(super) fn new(counts: &[usize], size: usize) -> Self {
        Self { chunks: Vec::new() }.then(counts, size)
    }

    /// Appends the chunks of further terms, again in the order of the components.
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

    /// Adds `factor` times the sum of each component's terms to `out`, one per component. `sums` is scratch.
    pub(super) fn add_to(
        &self,
        executor: &Executor,
        factor: f64,
        sums: &mut Vec<[f64; 4]>,
        out: &mut [[f64; 4]],
        terms: impl Fn(Range<usize>) -> [f64; 4] + Sync,
    ) {
        sums.resize(self.chunks.len(), [0.0; 4]);
        executor
            .for_each(self.chunks.iter().zip(&mut *sums), |(chunk, sum)| *sum = terms(chunk.terms.clone()));
        for (chunk, terms) in self.chunks.iter().zip(sums) {
            for (sum, term) in out[chunk.component].iter_mut().zip(terms) {
                *sum += factor * *term;
            }
        }
    }
}
