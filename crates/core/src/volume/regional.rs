//! Scope `regional`: computes a scale of the correction for each vertex, so that the volume is restored where
//! it was lost.
//!
//! A single `lambda` for a component also shrinks parts of the component that were not stretched. Here each
//! region has a wanted scale `u`, and the scales `s` of the vertices are the minimum of
//!
//! ```text
//! sum over links (i, j) of  (s_i - s_j)^2  +  DATA × sum over regions i of  w_i (s_i - u_i)^2
//! ```
//!
//! There is one region for each vertex: the vertex, with the vertices up to one link away in z, y and x.
//! (These regions are independent of the regions of the shape matching.) The volume of a region is the sum of
//! the volumes of its vertices by the measure `lattice`. Its volume gradient is the derivative of this volume
//! with respect to a scale, at a scale of 0. The wanted scale restores the volume of the region. The weight is
//! the square of the volume gradient, relative to rest, so a region that hardly gains volume follows its
//! neighbors.
//!
//! The volume gradients at rest vary with the depth below the boundary, because the field is not linear. Scales
//! that follow these variations would bulge a thick bar that is stretched evenly. Volume gradients are therefore
//! scaled: those at rest, per volume, are replaced by their means; see [`smoothing_length`].
//!
//! The minimum is approximated by Chebyshev iterations with the Jacobi preconditioner (Golub & Varga 1961),
//! from the mean wanted scale of each component. They need no sums over vertices, so the scales of a
//! component do not depend on other components.

use fearless_simd::{Simd, dispatch};

use super::adjacency::Adjacency;
use super::line::{Moving, value_and_slope};
use super::measure::differences;
use crate::parallel::Executor;
use crate::simd::level;

/// Weight of the wanted scales relative to the links.
const DATA: f32 = 6.0;

/// Number of iterations for the scales of a deformed body.
const ITERATIONS: usize = 6;

/// Range of eigenvalues that the iterations reduce. The eigenvalues of the preconditioned matrix are between
/// 0 and 2; those below the range belong to regions with small weights.
const EIGENVALUES: [f32; 2] = [0.2, 1.9];

/// Regularization: damps regions whose volume gradient is below this fraction of their volume gradient at
/// rest.
const MIN_GRADIENT: f32 = 0.2;

/// Least volume of a region from which its wanted scale is computed, relative to its volume at rest. A region
/// that is flat or inside out counts as one with this volume.
const MIN_VOLUME: f32 = 0.1;

/// Greatest weight of a region. A region at rest has the weight 1, approximately.
const MAX_WEIGHT: f32 = 4.0;

/// Least divergence of the field, that is, volume gradient per volume, that counts.
const MIN_DIVERGENCE: f32 = 1e-3;

/// Number of vertices that one task processes.
const CHUNK: usize = 4096;

/// Volumes and volume gradients of a body at rest.
#[derive(Clone, Debug)]
pub(super) struct Regional {
    /// Volume of each vertex at rest, in cubed cells.
    rest: Vec<f64>,
    /// State of each region at rest.
    regions: Vec<Region>,
    /// Number of links of each vertex.
    links: Vec<f32>,
}

/// State of a region at rest.
#[derive(Clone, Copy, Debug)]
struct Region {
    volume: f32,
    /// Square of the scaled volume gradient.
    gradient_squared: f32,
    /// Factor of the volume gradient.
    factor: f32,
}

/// Scales of a deformed body, and buffers to compute them.
#[derive(Clone, Debug, Default)]
pub(super) struct RegionalScratch {
    /// Pairs (volume loss, volume gradient): for each vertex, then summed over each region. Then the pairs
    /// (weight, weight times wanted scale), both times [`DATA`].
    regions: Buffer,
    /// For each component: sum of the weights, and sum of the weighted wanted scales.
    means: Vec<[f64; 2]>,
    /// Change of each scale in the last iteration.
    changes: Vec<f32>,
    /// Scales before the iteration.
    previous: Vec<f32>,
    /// Scale of each vertex: the displacement of its point, as a multiple of the point's direction.
    pub(super) scales: Vec<f32>,
}

impl RegionalScratch {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let scales = size_of_val(&*self.changes) + size_of_val(&*self.previous) + size_of_val(&*self.scales);
        self.regions.bytes() + size_of_val(&*self.means) + scales
    }

    /// Sets the scales to their mean in each component, for the weights and wanted scales in `regions`.
    fn start_at_means(&mut self, adjacency: &Adjacency) {
        let Self { regions, means, changes, previous, scales } = self;
        means.clear();
        means.resize(adjacency.component_count, [0.0; 2]);
        let components = || adjacency.component_of_vertex.iter().map(|&component| component as usize);
        for (region, component) in regions.values.iter().zip(components()) {
            for (sum, value) in means[component].iter_mut().zip(region) {
                *sum += f64::from(*value);
            }
        }
        changes.clear();
        changes.resize(adjacency.len(), 0.0);
        previous.resize(adjacency.len(), 0.0);
        scales.clear();
        scales.extend(components().map(|component| {
            let [weight, weighted] = means[component];
            if weight > 0.0 { (weighted / weight) as f32 } else { 0.0 }
        }));
    }
}

impl Regional {
    /// Computes the volumes and volume gradients at rest.
    ///
    /// * `points`: the lattice at rest, with its field.
    /// * `thickness`: thickness of each component, in cells.
    pub(super) fn new(adjacency: &Adjacency, points: &[Moving], thickness: &[f64]) -> Self {
        let executor = Executor::sequential();
        let volume = |neighbors: &[u32; 6]| {
            dispatch!(level(), simd => volume_and_gradient(simd, neighbors, points))[0]
        };
        let rest: Vec<f64> = adjacency.neighbors.iter().map(volume).collect();
        let links = (0..adjacency.len()).map(|vertex| adjacency.linked(vertex).count() as f32).collect();
        // With volumes of 0 at rest, the loss of a region is its negative volume.
        let mut this = Self { rest: vec![0.0; rest.len()], regions: Vec::new(), links };
        let mut scratch = RegionalScratch::default();
        this.region_losses(&executor, adjacency, points, &mut scratch.regions);
        let regions: Vec<[f32; 2]> = scratch.regions.values.iter().map(|[loss, g]| [-loss, *g]).collect();
        this.smooth_gradients(&mut scratch, adjacency, thickness, &regions);
        let region = |([volume, gradient], mean): (&[f32; 2], &f32)| {
            let factor = (mean / (gradient / volume).max(MIN_DIVERGENCE)).clamp(0.25, 4.0);
            let least = MIN_DIVERGENCE * volume;
            Region {
                volume: *volume,
                gradient_squared: (factor * gradient).powi(2) + least * least,
                factor: if factor.is_finite() { factor } else { 1.0 },
            }
        };
        this.regions = regions.iter().zip(&scratch.scales).map(region).collect();
        this.rest = rest;
        this
    }

    /// Sets the scales to the mean volume gradient, per volume, within about [`smoothing_length`] of each vertex.
    ///
    /// The means `q` minimize the sum over links of `(q_i - q_j)^2` plus the sum over regions of
    /// `w (q_i - g_i / v_i)^2`, with `w = 6 / length^2` for a region of 27 cells.
    fn smooth_gradients(
        &self,
        scratch: &mut RegionalScratch,
        adjacency: &Adjacency,
        thickness: &[f64],
        regions: &[[f32; 2]],
    ) {
        let components = adjacency.component_of_vertex.iter().map(|&component| component as usize);
        for ((value, [volume, gradient]), component) in
            scratch.regions.values.iter_mut().zip(regions).zip(components)
        {
            let length = smoothing_length(thickness[component]);
            let weight = 6.0 * volume / (27.0 * length * length);
            *value = [weight, weight * (gradient / volume)];
        }
        scratch.start_at_means(adjacency);
        let longest = thickness.iter().fold(1.0_f32, |longest, &t| longest.max(smoothing_length(t)));
        let low = 1.0 / (1.0 + longest * longest);
        // The error decreases by exp(-2 sqrt(low / high)) per iteration: this many reduce it to 1 %.
        let iterations = (4.0 * longest).ceil() as usize;
        let range = [low, EIGENVALUES[1]];
        self.iterate(scratch, &Executor::sequential(), adjacency, iterations, range);
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.rest) + size_of_val(&*self.regions) + size_of_val(&*self.links)
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
        self.region_losses(executor, adjacency, points, &mut scratch.regions);
        for (region, rest) in scratch.regions.values.iter_mut().zip(&self.regions) {
            *region = weighted_scale(*region, rest);
        }
        scratch.start_at_means(adjacency);
        self.iterate(scratch, executor, adjacency, ITERATIONS, EIGENVALUES);
        let components = adjacency.component_of_vertex.iter();
        for ((scale, component), point) in scratch.scales.iter_mut().zip(components).zip(points) {
            *scale = bounded(*scale, caps[*component as usize] as f32);
            point.advance(*scale);
        }
    }

    /// Runs Chebyshev iterations for the minimum, from the present scales. `eigenvalues`: range of eigenvalues
    /// that they reduce.
    fn iterate(
        &self,
        scratch: &mut RegionalScratch,
        executor: &Executor,
        adjacency: &Adjacency,
        iterations: usize,
        eigenvalues: [f32; 2],
    ) {
        let RegionalScratch { regions, changes, previous, scales, .. } = scratch;
        let [low, high] = eigenvalues;
        let (center, radius) = ((high + low) / 2.0, (high - low) / 2.0);
        let mut rho = radius / center;
        // Factors of the last change and of the preconditioned residual.
        let mut factors = [0.0, 1.0 / center];
        for _ in 0..iterations {
            std::mem::swap(scales, previous);
            let before = &*previous;
            let vertices = adjacency.neighbors.chunks(CHUNK).zip(regions.values.chunks(CHUNK));
            let vertices = vertices.zip(self.links.chunks(CHUNK)).enumerate();
            let out = changes.chunks_mut(CHUNK).zip(scales.chunks_mut(CHUNK));
            executor.for_each(vertices.zip(out), |((chunk, ((neighbors, regions), links)), out)| {
                let vertices = (chunk * CHUNK..).zip(neighbors).zip(regions.iter().zip(links));
                for (((i, neighbors), (region, links)), (change, scale)) in
                    vertices.zip(out.0.iter_mut().zip(out.1))
                {
                    // A missing neighbor is the vertex itself, and adds nothing.
                    let ([weight, weighted], s) = (*region, before[i]);
                    let differences: f32 = neighbors.iter().map(|&j| before[j as usize] - s).sum();
                    let residual = (differences + weighted - weight * s) / (links + weight);
                    *change = factors[0] * *change + factors[1] * residual;
                    *scale = s + *change;
                }
            });
            let next = 1.0 / (2.0 * center / radius - rho);
            factors = [next * rho, 2.0 * next / radius];
            rho = next;
        }
    }

    /// Computes the volume loss since rest and the volume gradient of each region.
    fn region_losses(
        &self,
        executor: &Executor,
        adjacency: &Adjacency,
        points: &[Moving],
        losses: &mut Buffer,
    ) {
        losses.resize(points.len());
        let rest = self.rest.chunks(CHUNK).zip(adjacency.neighbors.chunks(CHUNK));
        executor.for_each(rest.zip(losses.values.chunks_mut(CHUNK)), |((rest, neighbors), out)| {
            dispatch!(level(), simd => vertex_losses(simd, neighbors, points, rest, out));
        });
        losses.sum(executor, adjacency);
    }
}

/// Returns the distance, in cells, over which volume gradients at rest are averaged: the thickness for bodies of
/// at least six cells, and less for thinner bodies, down to no averaging at four cells. The regions are three
/// cells wide, so they average thin bodies already.
fn smoothing_length(thickness: f64) -> f32 {
    (3.0 * (thickness - 4.0)).min(thickness).max(0.1) as f32
}

/// Returns [`DATA`] times the weight of a region, and this times the wanted scale.
///
/// The wanted scale is `2 v (sqrt(v0 / v) - 1) / g` with the volume `v`, the volume `v0` at rest and the volume
/// gradient `g`, regularized by [`MIN_GRADIENT`]: the scale that restores the volume of a stretched region
/// whose section changes by the square of `1 + s g / (2 v)`.
#[inline]
fn weighted_scale([loss, gradient]: [f32; 2], rest: &Region) -> [f32; 2] {
    let gradient = rest.factor * gradient;
    let volume = (rest.volume - loss).max(MIN_VOLUME * rest.volume);
    let wanted_gain = 2.0 * volume * ((rest.volume / volume).sqrt() - 1.0);
    let squared = gradient * gradient + MIN_GRADIENT * MIN_GRADIENT * rest.gradient_squared;
    let weight = DATA * (squared / rest.gradient_squared).min(MAX_WEIGHT);
    let weighted = weight * (wanted_gain * gradient / squared);
    if weight.is_finite() && weighted.is_finite() { [weight, weighted] } else { [0.0; 2] }
}

/// Returns the scale, limited smoothly: nearly unchanged if it is small, and never beyond `cap`.
#[inline]
fn bounded(scale: f32, cap: f32) -> f32 {
    let ratio = (scale / cap).clamp(-1e9, 1e9);
    let bounded = cap * ratio / (1.0 + ratio * ratio).sqrt();
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

/// Buffer of two values per vertex for sums over regions.
#[derive(Clone, Debug, Default)]
struct Buffer {
    values: Vec<[f32; 2]>,
    /// Values before the sum along the current axis.
    previous: Vec<[f32; 2]>,
}

impl Buffer {
    /// Sets the length.
    fn resize(&mut self, len: usize) {
        self.values.resize(len, [0.0; 2]);
        self.previous.resize(len, [0.0; 2]);
    }

    /// Returns the memory in bytes.
    fn bytes(&self) -> usize {
        size_of_val(&*self.values) + size_of_val(&*self.previous)
    }

    /// Replaces the values of each vertex by the sums of the values of its region.
    ///
    /// For one axis after another, adds to each value the values of the two neighbors along the axis.
    fn sum(&mut self, executor: &Executor, adjacency: &Adjacency) {
        for axis in 0..3 {
            std::mem::swap(&mut self.values, &mut self.previous);
            let previous = &self.previous;
            let chunks = adjacency.neighbors.chunks(CHUNK).enumerate();
            executor.for_each(chunks.zip(self.values.chunks_mut(CHUNK)), |((chunk, neighbors), values)| {
                for ((i, vertex_neighbors), value) in (chunk * CHUNK..).zip(neighbors).zip(values) {
                    *value = previous[i];
                    for side in [2 * axis, 2 * axis + 1] {
                        let neighbor = vertex_neighbors[side] as usize;
                        if neighbor != i {
                            for k in 0..2 {
                                value[k] += previous[neighbor][k];
                            }
                        }
                    }
                }
            });
        }
    }
}
