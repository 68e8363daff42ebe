//! Scope `regional`: a scale of the correction for each vertex, so that volume is regained where it was lost.
//!
//! A single `lambda` per body also shrinks parts that were not stretched. Here each region has its own
//! `lambda`: the volume that its vertices have lost, divided by the volume that they gain per unit of
//! `lambda`. A region is a vertex with the vertices up to one link away in z, y and x. The scale of a vertex
//! is the mean over the regions that contain it, computed by the adjoint of the same window sums, so that
//! neighboring vertices have similar scales.

use fearless_simd::{Simd, dispatch};

use super::adjacency::Adjacency;
use super::line::{Moving, value_and_slope};
use super::measure::differences;
use crate::parallel::Executor;
use crate::simd::level;

/// Number of passes. The first makes most of the correction, and the second corrects its overshoot.
const PASSES: usize = 2;

/// Regularization: damps regions whose volume gradient is below this fraction of that at rest.
const MIN_GRADIENT: f32 = 0.4;

/// Bound of a region's `lambda` in each pass, as a fraction of the cap. In parts that collapse, for example
/// around a sharp edge, a larger scale would crease the body instead of restoring its volume.
const MAX_SCALE: f32 = 0.5;

/// Number of vertices in a task.
const CHUNK: usize = 4096;

/// Rest values of the regions of a body.
#[derive(Clone, Debug)]
pub(super) struct Regional {
    /// Volume of each vertex at rest, in cubed cells.
    rest: Vec<f64>,
    /// Volume gradient of each region at rest: its gain per unit of `lambda`.
    gradients: Vec<f32>,
    /// Number of regions that contain each vertex.
    region_counts: Vec<f32>,
}

/// Scales of a deformed body, with their buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct RegionalScratch {
    /// Lost volume and volume gradient: of each vertex, then summed over each region.
    losses: Buffer<2>,
    /// `lambda` of each region, then summed over the regions of each vertex.
    lambdas: Buffer<1>,
    /// Displacement of each point, in units of its direction.
    pub(super) scales: Vec<f32>,
}

impl RegionalScratch {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.losses.bytes() + self.lambdas.bytes() + size_of_val(&*self.scales)
    }
}

impl Regional {
    /// Computes the rest values. `points`: the lattice at rest, with its field.
    pub(super) fn new(adjacency: &Adjacency, points: &[Moving]) -> Self {
        let executor = Executor::sequential();
        let volume = |row: &[u32; 6]| dispatch!(level(), simd => volume(simd, row, points))[0];
        let rest = adjacency.rows.iter().map(volume).collect();
        let mut this = Self { rest, gradients: Vec::new(), region_counts: Vec::new() };
        let (mut losses, mut count) = (Buffer::default(), Buffer::default());
        this.measure(&executor, adjacency, points, &mut losses);
        this.gradients = losses.values.iter().map(|[_, gradient]| *gradient).collect();
        count.resize(adjacency.len(), [1.0]);
        count.sum(&executor, adjacency, [2, 1, 0]);
        this.region_counts = count.values.iter().map(|[count]| *count).collect();
        this
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.rest) + size_of_val(&*self.gradients) + size_of_val(&*self.region_counts)
    }

    /// Moves the points along their directions, by total scales below `caps[component]`.
    pub(super) fn correct(
        &self,
        scratch: &mut RegionalScratch,
        executor: &Executor,
        adjacency: &Adjacency,
        caps: &[f64],
        points: &mut [Moving],
    ) {
        let RegionalScratch { losses, lambdas, scales } = scratch;
        lambdas.resize(points.len(), [0.0]);
        scales.clear();
        scales.resize(points.len(), 0.0);
        for _ in 0..PASSES {
            self.measure(executor, adjacency, points, losses);
            let regions = losses.values.iter().zip(&self.gradients).zip(&adjacency.of_vertex);
            for ([lambda], ((loss, at_rest), component)) in lambdas.values.iter_mut().zip(regions) {
                *lambda = scale(*loss, *at_rest, caps[*component as usize] as f32);
            }
            lambdas.sum(executor, adjacency, [2, 1, 0]);
            let means = lambdas.values.iter().zip(&self.region_counts).map(|([sum], count)| sum / count);
            for (mean, (scale, point)) in means.zip(scales.iter_mut().zip(&mut *points)) {
                *scale += mean;
                point.advance(mean);
            }
        }
    }

    /// Computes for each region the volume lost since rest, and its volume gradient.
    fn measure(&self, executor: &Executor, adjacency: &Adjacency, points: &[Moving], losses: &mut Buffer<2>) {
        losses.resize(points.len(), [0.0; 2]);
        let rest = self.rest.chunks(CHUNK).zip(adjacency.rows.chunks(CHUNK));
        executor.for_each(rest.zip(losses.values.chunks_mut(CHUNK)), |((rest, rows), out)| {
            dispatch!(level(), simd => measure(simd, rows, points, rest, out));
        });
        losses.sum(executor, adjacency, [0, 1, 2]);
    }
}

/// Returns the `lambda` of a region with the volume loss `lost` and the volume gradient `gradient`.
///
/// The result is `lost / gradient`, regularized by [`MIN_GRADIENT`] and bounded by [`MAX_SCALE`]. `at_rest`
/// is the gradient at rest.
#[inline]
fn scale([lost, gradient]: [f32; 2], at_rest: f32, cap: f32) -> f32 {
    let (floor, bound) = (MIN_GRADIENT * at_rest, MAX_SCALE * cap);
    let unbounded = lost * gradient / (gradient * gradient + floor * floor);
    // Smooth clamp: nearly the identity for small ratios; the magnitude never exceeds the bound.
    let ratio = (unbounded / bound).clamp(-1e9, 1e9);
    let bounded = bound * ratio / (1.0 + ratio * ratio).sqrt();
    if bounded.is_finite() { bounded } else { 0.0 }
}

/// Returns the volume of a vertex by the measure `lattice`, and its gain per unit of `lambda`.
#[inline(always)]
fn volume<S: Simd>(simd: S, row: &[u32; 6], points: &[Moving]) -> [f64; 2] {
    let (x, y, z) = differences(simd, row, points);
    value_and_slope(x, y, z).map(|volume| volume / 8.0)
}

/// Writes the volume loss and the volume gradient of some vertices to `out`.
#[inline(always)]
fn measure<S: Simd>(simd: S, rows: &[[u32; 6]], points: &[Moving], rest: &[f64], out: &mut [[f32; 2]]) {
    for ((row, rest), out) in rows.iter().zip(rest).zip(out) {
        let [now, gradient] = volume(simd, row, points);
        *out = [(rest - now) as f32, gradient as f32];
    }
}

/// Buffer of `N` values per vertex for sums over regions.
#[derive(Clone, Debug, Default)]
struct Buffer<const N: usize> {
    values: Vec<[f32; N]>,
    previous: Vec<[f32; N]>,
}

impl<const N: usize> Buffer<N> {
    /// Sets the length; new elements are `value`.
    fn resize(&mut self, len: usize, value: [f32; N]) {
        self.values.resize(len, value);
        self.previous.resize(len, value);
    }

    /// Returns the memory in bytes.
    fn bytes(&self) -> usize {
        size_of_val(&*self.values) + size_of_val(&*self.previous)
    }

    /// Replaces each value by the sum over its vertex and its neighbors along an axis, for each axis in
    /// turn.
    fn sum(&mut self, executor: &Executor, adjacency: &Adjacency, axes: [usize; 3]) {
        for axis in axes {
            std::mem::swap(&mut self.values, &mut self.previous);
            let previous = &self.previous;
            let rows = adjacency.rows.chunks(CHUNK).enumerate();
            executor.for_each(rows.zip(self.values.chunks_mut(CHUNK)), |((chunk, rows), values)| {
                for ((i, row), value) in (chunk * CHUNK..).zip(rows).zip(values) {
                    *value = previous[i];
                    for side in [2 * axis, 2 * axis + 1] {
                        let neighbor = row[side] as usize;
                        if neighbor != i {
                            for k in 0..N {
                                value[k] += previous[neighbor][k];
                            }
                        }
                    }
                }
            });
        }
    }
}
