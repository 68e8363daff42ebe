//! Provides the buffers of an evaluation, and sums of cubics that do not depend on the number of threads.
//!
//! The cubics are volumes as functions of the scale `lambda`. They are stored as four coefficients, with the
//! coefficient of `lambda^k` at index `k`.

use std::ops::Range;

use super::adjacency::Adjacency;
use super::line::Moving;
use crate::lattice::Lattice;
use crate::parallel::Executor;

/// Magnitude to which coordinates are clamped, so that differences of positions stay finite in f32.
const MAX_COORDINATE: f32 = 1e37;

/// Input, output and buffers of an evaluation. The vectors grow to the size of the lattice and keep their
/// capacity.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Lattice vertices relative to the center of their component, so that f32 is accurate enough for
    /// determinants.
    pub(super) points: Vec<Moving>,
    /// Coefficients of the volume of each component, in cubed cells.
    pub(super) coefficients: Vec<[f64; 4]>,
    /// Points of the embedded surface.
    pub(super) surface_points: Vec<Moving>,
    /// Slopes of the lattice along the axes, for smooth surface points.
    pub(super) slopes: Vec<[Moving; 3]>,
    /// Slope weights, for smooth surface points. They depend on the deformed lattice and not on `lambda`, so that
    /// the volume is a cubic.
    pub(super) slope_weights: Vec<f32>,
    /// Sum of each chunk of a [`ChunkedSum`].
    pub(super) sums: Vec<[f64; 4]>,
    centers: Vec<Center>,
}

/// Sum of the positions of a component, number of its vertices, and its center in whole cells.
#[derive(Clone, Debug, Default)]
struct Center {
    sum: [f64; 3],
    count: f64,
    center: [f32; 3],
}

impl Scratch {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let smooth = size_of_val(&*self.slopes) + size_of_val(&*self.slope_weights);
        size_of_val(&*self.points) + size_of_val(&*self.surface_points) + size_of_val(&*self.sums) + smooth
    }

    /// Sets the positions of the points to `positions`, relative to the center of their component. Keeps the
    /// directions.
    ///
    /// The center is the mean position of the vertices of the component, rounded to whole cells.
    pub(super) fn set_positions(&mut self, positions: &[[f32; 3]], adjacency: &Adjacency) {
        self.points.resize(adjacency.len(), Moving::default());
        self.coefficients.resize(adjacency.component_count, [0.0; 4]);
        self.centers.clear();
        self.centers.resize(adjacency.component_count, Center::default());
        let mut later = positions;
        for components in adjacency.runs() {
            let center = &mut self.centers[components[0] as usize];
            let (eights, rest) = later.split_off(..components.len()).unwrap_or_default().as_chunks::<8>();
            // Independent sums hide the latency of the additions.
            let mut sums = [[0.0; 3]; 8];
            for eight in eights {
                for (sum, p) in sums.as_flattened_mut().iter_mut().zip(eight.as_flattened()) {
                    *sum += f64::from(*p);
                }
            }
            for p in sums.into_iter().chain(rest.iter().map(|p| p.map(f64::from))) {
                center.sum.iter_mut().zip(p).for_each(|(sum, p)| *sum += p);
            }
            center.count += components.len() as f64;
        }
        for Center { sum, count, center } in &mut self.centers {
            // The subtraction of whole cells is exact for positions on the grid.
            *center = sum.map(|sum| (sum / *count).round() as f32);
        }
        let (mut later, mut points) = (positions, &mut *self.points);
        for components in adjacency.runs() {
            let center = self.centers[components[0] as usize].center;
            let positions = later.split_off(..components.len()).unwrap_or_default();
            let points = points.split_off_mut(..components.len()).unwrap_or_default();
            for (p, point) in positions.iter().zip(points) {
                point.set_position(std::array::from_fn(|k| {
                    (p[k] - center[k]).clamp(-MAX_COORDINATE, MAX_COORDINATE)
                }));
            }
        }
    }

    /// Returns the center of a component, in whole cells.
    pub(super) fn center(&self, component: usize) -> [f32; 3] {
        self.centers[component].center
    }

    /// Sets the positions of the points to the positions of the lattice vertices at rest.
    pub(super) fn set_rest_positions(&mut self, lattice: &Lattice, adjacency: &Adjacency) {
        let positions: Vec<[f32; 3]> =
            lattice.indices().iter().map(|index| index.map(|i| i as f32)).collect();
        self.set_positions(&positions, adjacency);
        self.slope_weights.clear();
        self.slope_weights.resize(adjacency.len(), 1.0);
    }
}

/// Number of determinants in a chunk. It is constant, so that the order of the additions is constant too.
pub(super) const CHUNK_DETERMINANTS: usize = 2048;

/// Sum of terms that are sorted by component, in chunks of consecutive terms of a component.
///
/// The terms of each chunk are added in order, in parallel with other chunks. Then the sums of the chunks are
/// added in order.
#[derive(Clone, Debug)]
pub(super) struct ChunkedSum {
    chunks: Vec<Chunk>,
}

/// Consecutive terms of a component.
#[derive(Clone, Debug)]
struct Chunk {
    /// Indices of the terms.
    terms: Range<usize>,
    component: usize,
}

impl ChunkedSum {
    /// Creates the chunks for `counts[c]` terms of each component `c`, with up to `size` terms in a chunk.
    pub(super) fn new(counts: &[usize], size: usize) -> Self {
        Self { chunks: Vec::new() }.then(counts, size)
    }

    /// Appends chunks for further terms: `counts[c]` terms of each component `c`, with up to `size` terms in
    /// a chunk. The indices of the terms continue.
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

    /// Adds `factor` times the sum of the terms of each component `c` to `out[c]`.
    ///
    /// * `sums`: buffer.
    /// * `sum_of_terms`: returns the sum of the terms with these indices.
    pub(super) fn add_to(
        &self,
        executor: &Executor,
        factor: f64,
        sums: &mut Vec<[f64; 4]>,
        out: &mut [[f64; 4]],
        sum_of_terms: impl Fn(Range<usize>) -> [f64; 4] + Sync,
    ) {
        sums.resize(self.chunks.len(), [0.0; 4]);
        executor.for_each(self.chunks.iter().zip(&mut *sums), |(chunk, sum)| {
            *sum = sum_of_terms(chunk.terms.clone());
        });
        for (chunk, chunk_sum) in self.chunks.iter().zip(sums) {
            for (total, coefficient) in out[chunk.component].iter_mut().zip(chunk_sum) {
                *total += factor * *coefficient;
            }
        }
    }
}
