//! Scope `regional`: computes a scale of the correction for each vertex, so that the volume is restored where
//! it was lost.
//!
//! A single `lambda` for a component also shrinks parts of the component that were not stretched. Here each
//! region has its own scale: the volume that its vertices have lost, divided by its volume gradient. The
//! volume gradient is the derivative of the volume with respect to a scale, at a scale of 0. The volume of a
//! vertex is defined by the measure `lattice`.
//!
//! There is one region for each vertex: the vertex, with the vertices up to one link away in z, y and x.
//! (These regions are independent of the regions of the shape matching.) Sums over the vertices of each
//! region are computed axis by axis. The scale of a vertex is the mean of the scales of the regions that
//! contain it, computed by the adjoint of these sums. Neighboring vertices therefore have similar scales.

use fearless_simd::{Simd, dispatch};

use super::adjacency::Adjacency;
use super::line::{Moving, value_and_slope};
use super::measure::differences;
use crate::parallel::Executor;
use crate::simd::level;

/// Number of passes. The first pass makes most of the correction, and the second pass corrects the overshoot
/// of the first pass.
const PASSES: usize = 2;

/// Regularization: damps regions whose volume gradient is below this fraction of their volume gradient at
/// rest.
const MIN_GRADIENT: f32 = 0.4;

/// Bound of the scale of a region in each pass, as a fraction of the cap. In parts of a body that collapse,
/// for example around a sharp edge, a larger scale would crease the body instead of restoring its volume.
const MAX_SCALE: f32 = 0.5;

/// Number of vertices that one task processes.
const CHUNK: usize = 4096;

/// Volumes and volume gradients of a body at rest.
#[derive(Clone, Debug)]
pub(super) struct Regional {
    /// Volume of each vertex at rest, in cubed cells.
    rest: Vec<f64>,
    /// Volume gradient of each region at rest.
    gradients: Vec<f32>,
    /// Number of regions that contain each vertex.
    region_counts: Vec<f32>,
}

/// Scales of a deformed body, and buffers to compute them.
#[derive(Clone, Debug, Default)]
pub(super) struct RegionalScratch {
    /// Pairs (volume loss, volume gradient): for each vertex, then summed over each region.
    losses: Buffer<2>,
    /// Scale of each region, then the sum of the scales of the regions that contain each vertex.
    region_scales: Buffer<1>,
    /// Scale of each vertex: the displacement of its point, as a multiple of the point's direction.
    pub(super) scales: Vec<f32>,
}

impl RegionalScratch {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.losses.bytes() + self.region_scales.bytes() + size_of_val(&*self.scales)
    }
}

impl Regional {
    /// Computes the volumes and volume gradients at rest. `points`: the lattice at rest, with its field.
    pub(super) fn new(adjacency: &Adjacency, points: &[Moving]) -> Self {
        let executor = Executor::sequential();
        let volume = |neighbors: &[u32; 6]| {
            dispatch!(level(), simd => volume_and_gradient(simd, neighbors, points))[0]
        };
        let rest = adjacency.neighbors.iter().map(volume).collect();
        let mut this = Self { rest, gradients: Vec::new(), region_counts: Vec::new() };
        let (mut losses, mut count) = (Buffer::default(), Buffer::default());
        this.region_losses(&executor, adjacency, points, &mut losses);
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

    /// Computes the scales, and moves the points by them along their directions.
    ///
    /// The magnitude of each scale is below the cap of the component, `caps[component]`.
    pub(super) fn correct(
        &self,
        scratch: &mut RegionalScratch,
        executor: &Executor,
        adjacency: &Adjacency,
        caps: &[f64],
        points: &mut [Moving],
    ) {
        let RegionalScratch { losses, region_scales, scales } = scratch;
        region_scales.resize(points.len(), [0.0]);
        scales.clear();
        scales.resize(points.len(), 0.0);
        for _ in 0..PASSES {
            self.region_losses(executor, adjacency, points, losses);
            let regions = losses.values.iter().zip(&self.gradients).zip(&adjacency.component_of_vertex);
            let region_values = region_scales.values.iter_mut();
            for ([scale], ((loss, rest_gradient), component)) in region_values.zip(regions) {
                *scale = region_scale(*loss, *rest_gradient, caps[*component as usize] as f32);
            }
            region_scales.sum(executor, adjacency, [2, 1, 0]);
            let sums = region_scales.values.iter().zip(&self.region_counts);
            let means = sums.map(|([sum], count)| sum / count);
            for (mean, (scale, point)) in means.zip(scales.iter_mut().zip(&mut *points)) {
                *scale += mean;
                point.advance(mean);
            }
        }
    }

    /// Computes the volume loss since rest and the volume gradient of each region.
    fn region_losses(
        &self,
        executor: &Executor,
        adjacency: &Adjacency,
        points: &[Moving],
        losses: &mut Buffer<2>,
    ) {
        losses.resize(points.len(), [0.0; 2]);
        let rest = self.rest.chunks(CHUNK).zip(adjacency.neighbors.chunks(CHUNK));
        executor.for_each(rest.zip(losses.values.chunks_mut(CHUNK)), |((rest, neighbors), out)| {
            dispatch!(level(), simd => vertex_losses(simd, neighbors, points, rest, out));
        });
        losses.sum(executor, adjacency, [0, 1, 2]);
    }
}

/// Returns the scale of a region with the volume loss `loss` and the volume gradient `gradient`.
///
/// The scale is `loss / gradient`, regularized by [`MIN_GRADIENT`] and bounded by [`MAX_SCALE`] times `cap`.
/// `rest_gradient` is the volume gradient at rest.
#[inline]
fn region_scale([loss, gradient]: [f32; 2], rest_gradient: f32, cap: f32) -> f32 {
    let (min_gradient, bound) = (MIN_GRADIENT * rest_gradient, MAX_SCALE * cap);
    let unbounded = loss * gradient / (gradient * gradient + min_gradient * min_gradient);
    // Smooth clamp: nearly the identity for small ratios. The magnitude never exceeds the bound.
    let ratio = (unbounded / bound).clamp(-1e9, 1e9);
    let bounded = bound * ratio / (1.0 + ratio * ratio).sqrt();
    if bounded.is_finite() { bounded } else { 0.0 }
}

/// Returns the volume of a vertex by the measure `lattice`, and its volume gradient. `neighbors`: the
/// neighbors of the vertex, as in [`Adjacency::neighbors`].
#[inline(always)]
fn volume_and_gradient<S: Simd>(simd: S, neighbors: &[u32; 6], points: &[Moving]) -> [f64; 2] {
    let (x, y, z) = differences(simd, neighbors, points);
    value_and_slope(x, y, z).map(|volume| volume / 8.0)
}

/// Writes the volume loss and the volume gradient of consecutive vertices to `out`.
///
/// * `neighbors`: neighbors of each of these vertices.
/// * `points`: all points of the lattice.
/// * `rest`: volume of each of these vertices at rest.
#[inline(always)]
fn vertex_losses<S: Simd>(
    simd: S,
    neighbors: &[[u32; 6]],
    points: &[Moving],
    rest: &[f64],
    out: &mut [[f32; 2]],
) {
    for ((vertex_neighbors, rest), out) in neighbors.iter().zip(rest).zip(out) {
        let [volume, gradient] = volume_and_gradient(simd, vertex_neighbors, points);
        *out = [(rest - volume) as f32, gradient as f32];
    }
}

/// Buffer of `N` values per vertex for sums over regions.
#[derive(Clone, Debug, Default)]
struct Buffer<const N: usize> {
    values: Vec<[f32; N]>,
    /// Values before the sum along the current axis.
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

    /// Replaces the value of each vertex by the sum of the values of its region.
    ///
    /// For one axis after another, adds to each value the values of the two neighbors along the axis. `axes`:
    /// the order of the axes.
    fn sum(&mut self, executor: &Executor, adjacency: &Adjacency, axes: [usize; 3]) {
        for axis in axes {
            std::mem::swap(&mut self.values, &mut self.previous);
            let previous = &self.previous;
            let chunks = adjacency.neighbors.chunks(CHUNK).enumerate();
            executor.for_each(chunks.zip(self.values.chunks_mut(CHUNK)), |((chunk, neighbors), values)| {
                for ((i, vertex_neighbors), value) in (chunk * CHUNK..).zip(neighbors).zip(values) {
                    *value = previous[i];
                    for side in [2 * axis, 2 * axis + 1] {
                        let neighbor = vertex_neighbors[side] as usize;
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
