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
//! component do not depend on other components. All sums over links run in [`Blocks`] of eight vertices.

mod scales;

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, dispatch, f32x8};

use self::scales::{Scales, equation};
use super::adjacency::Adjacency;
use super::blocks::{Blocks, Chunk};
use super::line::{self, Moving, value_and_slope};
use crate::lattice::Lattice;
use crate::parallel::Executor;
use crate::simd::lanes::{Block, LANES, Row, block_and_lane, load, store};
use crate::simd::level;
use crate::simd::vector::Product;

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

/// Volumes and volume gradients of a body at rest.
#[derive(Clone, Debug)]
pub(super) struct Regional {
    blocks: Blocks,
    /// Volume of each vertex at rest, in cubed cells.
    rest: Vec<f32>,
    /// Regions at rest, in rows of eight.
    regions: Vec<Block<3>>,
}

/// Rows of the regions at rest.
const VOLUME: usize = 0;
/// Square of the scaled volume gradient.
const GRADIENT_SQUARED: usize = 1;
/// Factor of the volume gradient.
const FACTOR: usize = 2;
/// Scales of a deformed body, and buffers to compute them. Arrays are in [`Blocks`].
#[derive(Clone, Debug, Default)]
pub(super) struct RegionalScratch {
    /// Rows (volume loss, volume gradient): of each vertex, then summed over each region. Then the [`equation`] of each
    /// scale.
    regions: Vec<Block<2>>,
    /// Values of `regions` before the sum along the current axis.
    previous: Vec<Block<2>>,
    /// The displacement of each point, as a multiple of its direction.
    scales: Scales,
    /// Ratio of the rest volume of each region in force to that at rest. Empty if all are 1.
    ratios: Vec<Row>,
}

impl RegionalScratch {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.regions)
            + size_of_val(&*self.previous)
            + self.scales.bytes()
            + size_of_val(&*self.ratios)
    }

    /// Sets the sizes of the buffers.
    fn resize(&mut self, blocks: &Blocks) {
        blocks.resize(&mut self.regions);
        blocks.resize(&mut self.previous);
        self.scales.resize(blocks);
    }
}

impl Regional {
    /// Computes the volumes and volume gradients at rest.
    ///
    /// * `points`: the lattice at rest, with its field.
    /// * `thickness`: thickness of each component, in cells.
    pub(super) fn new(
        lattice: &Lattice,
        adjacency: &Adjacency,
        points: &[Moving],
        thickness: &[f64],
    ) -> Self {
        let blocks = Blocks::new(lattice, adjacency);
        let executor = Executor::sequential();
        let mut scratch = RegionalScratch::default();
        scratch.resize(&blocks);
        // With volumes of 0 at rest, the loss of a region is its negative volume.
        let mut this =
            Self { rest: vec![0.0; points.len()], regions: vec![[Row::ZERO; 3]; blocks.len()], blocks };
        this.vertex_losses(&executor, adjacency, points, &mut scratch);
        let places = this.blocks.slots.iter().map(|&slot| block_and_lane(slot));
        let rest = places.map(|(block, lane)| -scratch.regions[block][0][lane]).collect();
        this.sum_regions(&executor, &mut scratch);
        let sums = scratch.regions.clone();
        this.smooth_gradients(&mut scratch, thickness);
        for ((region, sums), means) in this.regions.iter_mut().zip(&sums).zip(&scratch.scales.values) {
            // Lanes without a vertex stay zero.
            for lane in (0..LANES).filter(|&lane| sums[0][lane] < 0.0) {
                let (volume, gradient) = (-sums[0][lane], sums[1][lane]);
                region[VOLUME][lane] = volume;
                let factor = (means[0][lane] / (gradient / volume).max(MIN_DIVERGENCE)).clamp(0.25, 4.0);
                let least = MIN_DIVERGENCE * volume;
                region[GRADIENT_SQUARED][lane] = (factor * gradient).powi(2) + least * least;
                region[FACTOR][lane] = if factor.is_finite() { factor } else { 1.0 };
            }
        }
        Self { rest, ..this }
    }

    /// Sets the scales to the mean volume gradient, per volume, within about [`smoothing_length`] of each vertex.
    ///
    /// The means `q` minimize the sum over links of `(q_i - q_j)^2` plus the sum over regions of
    /// `w (q_i - g_i / v_i)^2`, with `w = 6 / length^2` for a region of 27 cells. `scratch.regions` has the negative
    /// volumes and the volume gradients.
    fn smooth_gradients(&self, scratch: &mut RegionalScratch, thickness: &[f64]) {
        dispatch!(level(), simd => {
            for block in 0..self.blocks.len() {
                let length = smoothing_length(thickness[self.blocks.components[block] as usize]);
                let factor = 6.0 / (27.0 * length * length);
                let [loss, gradient]: [f32x8<_>; 2] = load(simd, &scratch.regions[block]);
                let (row, sums) = equation(simd, [loss * -factor, gradient * factor], self.blocks.links(simd, block));
                store(row, &mut scratch.regions[block]);
                scratch.scales.block_sums[block] = sums;
            }
        });
        let longest = thickness.iter().fold(1.0_f32, |longest, &t| longest.max(smoothing_length(t)));
        let low = 1.0 / (1.0 + longest * longest);
        // The error decreases by exp(-2 sqrt(low / high)) per iteration: this many reduce it to 1 %.
        let iterations = (4.0 * longest).ceil() as usize;
        let range = [low, EIGENVALUES[1]];
        let RegionalScratch { regions, scales, .. } = scratch;
        scales.iterate(&Executor::sequential(), (&self.blocks, thickness.len()), regions, iterations, range);
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.blocks.bytes() + size_of_val(&*self.rest) + size_of_val(&*self.regions)
    }

    /// Sets the ratio of the rest volume around each vertex; `None` if all are 1.
    pub(super) fn set_rest(&self, scratch: &mut RegionalScratch, ratio: Option<&dyn Fn(usize) -> f64>) {
        scratch.ratios.clear();
        if let Some(ratio) = ratio {
            scratch.ratios.resize(self.blocks.len(), Row::all(1.0));
            for (vertex, &slot) in self.blocks.slots.iter().enumerate() {
                let (block, lane) = block_and_lane(slot);
                scratch.ratios[block][lane] = ratio(vertex) as f32;
            }
        }
    }

    /// Computes the scales, and moves the points by them along their directions. Writes the displacements to `offsets`.
    ///
    /// The magnitude of each scale is below the cap of the component, `caps[component]`.
    pub(super) fn correct(
        &self,
        scratch: &mut RegionalScratch,
        executor: &Executor,
        adjacency: &Adjacency,
        caps: &[f64],
        (points, offsets): (&mut [Moving], &mut Vec<[f32; 3]>),
    ) {
        scratch.resize(&self.blocks);
        self.vertex_losses(executor, adjacency, points, scratch);
        self.sum_regions(executor, scratch);
        let RegionalScratch { regions, scales, ratios, .. } = scratch;
        let rows = self.blocks.split(regions).zip(self.blocks.split(&mut scales.block_sums));
        executor.for_each(self.blocks.chunks.iter().zip(rows), |(chunk, (rows, sums))| {
            dispatch!(level(), simd => {
                for (block, (row, block_sums)) in chunk.blocks.clone().zip(rows.iter_mut().zip(sums)) {
                    let ratio = ratios.get(block).map(|ratio| f32x8::load_array_ref(simd, ratio));
                    let (sums, rest) = (load(simd, row), load(simd, &self.regions[block]));
                    let (sums, rest) = ratio.map_or((sums, rest), |ratio| grown(simd, sums, rest, ratio));
                    let weights = weighted_scales(simd, sums, rest);
                    let (equation, sums) = equation(simd, weights, self.blocks.links(simd, block));
                    store(equation, row);
                    *block_sums = sums;
                }
            });
        });
        scales.iterate(executor, (&self.blocks, caps.len()), regions, ITERATIONS, EIGENVALUES);
        offsets.resize(points.len(), [0.0; 3]);
        let vertices = self.blocks.split_vertices(points).zip(self.blocks.split_vertices(offsets));
        let parts = self.blocks.split(&mut scales.values).zip(vertices);
        executor.for_each(self.blocks.chunks.iter().zip(parts), |(chunk, (scales, (points, offsets)))| {
            dispatch!(level(), simd => {
                for (scales, &component) in scales.iter_mut().zip(&self.blocks.components[chunk.blocks.clone()]) {
                    let [scale] = load(simd, scales);
                    store([bounded(simd, scale, caps[component as usize] as f32)], scales);
                }
            });
            let first = chunk.blocks.start;
            let slots = &self.blocks.slots[chunk.vertices.clone()];
            for ((&slot, point), offset) in slots.iter().zip(points).zip(offsets) {
                let (block, lane) = block_and_lane(slot);
                let scale = scales[block - first][0][lane];
                *offset = point.direction().map(|v| scale * v);
                point.advance(scale);
            }
        });
    }

    /// Computes the volume loss since rest and the volume gradient of each vertex.
    fn vertex_losses(
        &self,
        executor: &Executor,
        adjacency: &Adjacency,
        points: &[Moving],
        scratch: &mut RegionalScratch,
    ) {
        let out = self.blocks.split(&mut scratch.regions);
        executor.for_each(self.blocks.chunks.iter().zip(out), |(chunk, out)| {
            out.fill([Row::ZERO; 2]);
            let Chunk { blocks, vertices } = chunk;
            let neighbors = &adjacency.neighbors[vertices.clone()];
            let (rest, slots) = (&self.rest[vertices.clone()], &self.blocks.slots[vertices.clone()]);
            dispatch!(level(), simd => {
                for ((neighbors, rest), &slot) in neighbors.iter().zip(rest).zip(slots) {
                    let [x0, x1, y0, y1, z0, z1] = line::load(simd, points, neighbors);
                    let [volume, gradient] = value_and_slope(simd, x1 - x0, y1 - y0, z1 - z0);
                    let (block, lane) = block_and_lane(slot);
                    let rows = &mut out[block - blocks.start];
                    (rows[0][lane], rows[1][lane]) = (rest - volume / 8.0, gradient / 8.0);
                }
            });
        });
    }

    /// Replaces the values of each vertex by the sums of the values of its region.
    ///
    /// For one axis after another, adds to each value the values of the two neighbors along the axis.
    fn sum_regions(&self, executor: &Executor, scratch: &mut RegionalScratch) {
        let RegionalScratch { regions, previous, .. } = scratch;
        for axis in 0..3 {
            std::mem::swap(regions, previous);
            let before = &*previous;
            let out = self.blocks.split(regions);
            executor.for_each(self.blocks.chunks.iter().zip(out), |(chunk, out)| {
                dispatch!(level(), simd => {
                    for (block, out) in chunk.blocks.clone().zip(out) {
                        let mut sums: [f32x8<_>; 2] = load(simd, &before[block]);
                        for c in 0..2 {
                            sums[c] += self.blocks.sum_along(simd, block, axis, (before, c));
                            sums[c] = self.blocks.filled(simd, block, sums[c]);
                        }
                        store(sums, out);
                    }
                });
            });
        }
    }
}

/// Returns the distance, in cells, over which volume gradients at rest are averaged: the thickness for bodies of
/// at least six cells, and less for thinner bodies, down to no averaging at four cells. The regions are three
/// cells wide, so they average thin bodies already.
fn smoothing_length(thickness: f64) -> f32 {
    (3.0 * (thickness - 4.0)).min(thickness).max(0.1) as f32
}

/// Returns [`DATA`] times the weights of eight regions, and this times the wanted scales. Not finite where there is
/// none.
///
/// The wanted scale is `2 v (sqrt(v0 / v) - 1) / g` with the volume `v`, the volume `v0` at rest and the volume
/// gradient `g`, regularized by [`MIN_GRADIENT`]: the scale that restores the volume of a stretched region
/// whose section changes by the square of `1 + s g / (2 v)`.
#[inline(always)]
fn weighted_scales<S: Simd>(simd: S, [loss, gradient]: [f32x8<S>; 2], rest: [f32x8<S>; 3]) -> [f32x8<S>; 2] {
    let [rest_volume, rest_squared, factor] = rest;
    let gradient = factor * gradient;
    let volume = (rest_volume - loss).max(rest_volume * MIN_VOLUME);
    let wanted_gain = volume * 2.0 * ((rest_volume / volume).sqrt() - f32x8::splat(simd, 1.0));
    let squared = gradient.times_plus(gradient, rest_squared * (MIN_GRADIENT * MIN_GRADIENT));
    let weight = (squared / rest_squared).min(f32x8::splat(simd, MAX_WEIGHT)) * DATA;
    [weight, weight * (wanted_gain * gradient / squared)]
}

/// Returns the loss and gradient, and the region at rest, of regions whose rest volumes are `ratio` times those at
/// rest.
#[inline(always)]
fn grown<S: Simd>(
    simd: S,
    [loss, gradient]: [f32x8<S>; 2],
    [volume, squared, factor]: [f32x8<S>; 3],
    ratio: f32x8<S>,
) -> ([f32x8<S>; 2], [f32x8<S>; 3]) {
    let loss = (ratio - f32x8::splat(simd, 1.0)).times_plus(volume, loss);
    // Gradients are areas: they grow as the power 2/3, their squares as 4/3.
    let mut growth = ratio.to_array();
    growth.iter_mut().for_each(|ratio| *ratio *= libm::cbrtf(*ratio));
    ([loss, gradient], [volume * ratio, squared * f32x8::load_array(simd, growth), factor])
}

/// Returns the scales, limited smoothly: nearly unchanged if they are small, and never beyond `cap`.
#[inline(always)]
fn bounded<S: Simd>(simd: S, scales: f32x8<S>, cap: f32) -> f32x8<S> {
    let [one, limit] = [f32x8::splat(simd, 1.0), f32x8::splat(simd, 1e9)];
    let ratio = (scales / cap).max(-limit).min(limit);
    let bounded = ratio * cap / ratio.times_plus(ratio, one).sqrt();
    // Where a scale is NaN, the clamped ratio depends on the processor.
    let is_number = scales.simd_eq(scales) & bounded.is_finite();
    is_number.select(bounded, f32x8::splat(simd, 0.0))
}
