//! Evaluates the measure `mesh`: the exact signed volume of the embedded surface, as a cubic in the scale
//! `lambda`.
//!
//! `det[a, b, c]` is the scalar triple product `a . (b × c)`.

use fearless_simd::{Simd, SimdBase, dispatch, f32x8};

use super::line::{CrossFactor, Determinants, FastDeterminants, Line, Moving, load};
use super::patch::Patch;
use super::smooth_points::{LocalCoordinates, Run, SmoothLattice, interpolate_smooth, update_slopes};
use super::sums::{CHUNK_DETERMINANTS, ChunkedSum, Scratch};
use crate::lattice::{Embedding, Smoothing};
use crate::parallel::Executor;
use crate::simd::level;
use crate::simd::vector::Product;

/// Number of surface points that one task interpolates.
const BATCH: usize = 1024;

/// Number of quads whose determinants are added in f32.
const FAST_QUADS: usize = 8;

/// Number of patches in a chunk of the sum.
const CHUNK_PATCHES: usize = 64;

/// Measure `mesh`: the sum of `det[a, b, c] / 6` over the triangles, with the corners `a`, `b`, `c` of a
/// triangle.
///
/// A surface point is a linear combination of lattice vertices. It moves along a straight line as `lambda`
/// changes, because the lattice vertices do; the volume is therefore an exact cubic. With trilinear positions, the
/// triangles of a cell with many triangles are stored as a [`Patch`]. Only the other triangles are summed: in a fine
/// mesh in a coarse lattice, mostly the triangles that cross cell boundaries. With smooth positions all triangles are
/// summed, because 32 coefficients describe a cell.
///
/// Triangles are summed in pairs with a common edge, as quads `a, b, c, d` of the triangles `a, b, c` and `a, c, d`.
/// The sum of their two determinants is `a . ((c - a) × (d - b))`. A triangle without a partner has `d = a`.
#[derive(Clone, Debug)]
pub(super) struct MeshMeasure {
    patches: Vec<Patch>,
    /// Runs of surface points. No run crosses the boundary between two batches of [`BATCH`] points.
    runs: Vec<Run>,
    /// End of the runs of each batch, as an index into `runs`.
    run_ends: Vec<usize>,
    point_count: usize,
    positions: Positions,
    /// Quads of the triangles that are in no patch.
    quads: Vec<[u32; 4]>,
    /// Chunks of the patches, then of the quads.
    sums: ChunkedSum,
}

/// How the surface points follow the lattice.
#[derive(Clone, Debug)]
enum Positions {
    /// Trilinear weights of each surface point for the corners of its cell.
    Trilinear(Vec<[f32; 8]>),
    /// Local coordinates of each surface point in its cell, and the stencils of the smooth positions.
    Smooth(LocalCoordinates, Smoothing),
}

/// Terms of a [`MeshMeasure`], sorted by component.
#[derive(Debug, Default)]
pub(super) struct MeshTerms {
    pub(super) patches: Vec<Patch>,
    /// Number of patches of each component.
    pub(super) patch_counts: Vec<usize>,
    /// Quads of the triangles that are in no patch, with normals that point out of the body (on the boundary of a
    /// cavity, into the cavity).
    pub(super) quads: Vec<[u32; 4]>,
    /// Number of these quads of each component.
    pub(super) quad_counts: Vec<usize>,
}

impl MeshMeasure {
    /// Creates the measure. `points`: mesh vertex of each surface point. The corners of `terms.quads` are
    /// indices into `points`.
    pub(super) fn new(terms: MeshTerms, points: &[u32], embedding: &Embedding) -> Self {
        let MeshTerms { patches, patch_counts, quads, quad_counts } = terms;
        let cell = |point: u32| embedding.cell(point as usize);
        let (mut runs, mut run_ends) = (Vec::new(), Vec::new());
        for batch in points.chunks(BATCH) {
            let cells = batch.chunk_by(|&a, &b| cell(a) == cell(b));
            runs.extend(
                cells.map(|points| Run {
                    corners: embedding.corners(points[0] as usize),
                    points: points.len(),
                }),
            );
            run_ends.push(runs.len());
        }
        Self {
            patches,
            runs,
            run_ends,
            positions: match embedding.smoothing() {
                None => Positions::Trilinear(
                    points.iter().map(|&point| embedding.weights(point as usize)).collect(),
                ),
                Some(smoothing) => Positions::Smooth(
                    LocalCoordinates::new(points.iter().map(|&point| embedding.local(point as usize))),
                    smoothing.clone(),
                ),
            },
            point_count: points.len(),
            quads,
            sums: ChunkedSum::new(&patch_counts, CHUNK_PATCHES).then(&quad_counts, CHUNK_DETERMINANTS),
        }
    }

    /// Returns the stencils of smooth positions, or `None` if positions are trilinear.
    pub(super) fn smoothing(&self) -> Option<&Smoothing> {
        match &self.positions {
            Positions::Trilinear(_) => None,
            Positions::Smooth(_, smoothing) => Some(smoothing),
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let positions = match &self.positions {
            Positions::Trilinear(weights) => size_of_val(&**weights),
            // The embedding counts the stencils, which are shared.
            Positions::Smooth(local, _) => local.bytes(),
        };
        size_of_val(&*self.patches) + positions + size_of_val(&*self.runs) + size_of_val(&*self.quads)
    }

    /// Adds the volume of each component to `scratch.coefficients`.
    pub(super) fn add_coefficients(&self, executor: &Executor, scratch: &mut Scratch) {
        let Scratch { points: lattice, surface_points, slopes, slope_weights, sums, coefficients, .. } =
            scratch;
        surface_points.resize(self.point_count, Moving::default());
        if let Some(smoothing) = self.smoothing() {
            update_slopes(smoothing, lattice, slopes);
        }
        let (runs, run_ends) = (&self.runs, &self.run_ends);
        let (slopes, slope_weights) = (&*slopes, &*slope_weights);
        executor.for_each(surface_points.chunks_mut(BATCH).enumerate(), |(batch, surface_points)| {
            let first = if batch == 0 { 0 } else { run_ends[batch - 1] };
            let runs = &runs[first..run_ends[batch]];
            let start = batch * BATCH;
            dispatch!(level(), simd => match &self.positions {
                Positions::Trilinear(weights) => {
                    interpolate(simd, runs, lattice, &weights[start..], surface_points);
                }
                Positions::Smooth(local, _) => {
                    let lattice = SmoothLattice { points: lattice, slopes, slope_weights };
                    interpolate_smooth(simd, runs, lattice, (local, start), surface_points);
                }
            });
        });
        let (patches, surface_points, quads) = (&self.patches, &*surface_points, &self.quads);
        self.sums.add_to(executor, 1.0 / 6.0, sums, coefficients, |range| {
            if range.end <= patches.len() {
                let patches = &patches[range];
                return dispatch!(level(), simd => {
                    let mut sum = Determinants::zero(simd);
                    for patch in patches {
                        patch.add_to(simd, lattice, &mut sum);
                    }
                    sum.coefficients()
                });
            }
            let quads = &quads[range.start - patches.len()..range.end - patches.len()];
            if self.smoothing().is_some() {
                return short_quad_sum(quads, surface_points);
            }
            dispatch!(level(), simd => quad_sum(simd, quads, surface_points))
        });
    }
}

/// Returns [`quad_sum`] with terms in f32, or in f64 if a term overflows.
fn short_quad_sum(quads: &[[u32; 4]], points: &[Moving]) -> [f64; 4] {
    let sum = dispatch!(level(), simd => fast_quad_sum(simd, quads, points));
    if sum.iter().all(|coefficient| coefficient.is_finite()) {
        return sum;
    }
    dispatch!(level(), simd => quad_sum(simd, quads, points))
}

/// Returns six times the sum of the volumes of quads.
#[inline(always)]
fn quad_sum<S: Simd>(simd: S, quads: &[[u32; 4]], surface_points: &[Moving]) -> [f64; 4] {
    let mut sum = Determinants::zero(simd);
    for quad in quads {
        let [a, b, c, d] = load(simd, surface_points, quad);
        sum.add(Line::zxy(simd, a), CrossFactor::new(simd, c - a), CrossFactor::new(simd, d - b));
    }
    sum.coefficients()
}

/// Returns [`quad_sum`] with terms in f32. The coefficients are not finite if a term overflows.
#[inline(always)]
fn fast_quad_sum<S: Simd>(simd: S, quads: &[[u32; 4]], surface_points: &[Moving]) -> [f64; 4] {
    let mut sum = FastDeterminants::zero(simd);
    for quads in quads.chunks(FAST_QUADS) {
        for quad in quads {
            let [a, b, c, d] = load(simd, surface_points, quad);
            sum.add(simd, a, c - a, d - b);
        }
        sum.flush(simd);
    }
    sum.coefficients()
}

/// Computes surface points: each is the weighted mean of the corners of its cell.
#[inline(always)]
fn interpolate<S: Simd>(
    simd: S,
    runs: &[Run],
    lattice: &[Moving],
    weights: &[[f32; 8]],
    surface_points: &mut [Moving],
) {
    let mut points = surface_points.iter_mut().zip(weights);
    for run in runs {
        // Sums differences from the first corner. They are small, which keeps rounding errors small.
        let mut corners = load(simd, lattice, &run.corners);
        for k in 1..8 {
            corners[k] -= corners[0];
        }
        for (point, weights) in points.by_ref().take(run.points) {
            let mut offset = corners[1] * weights[1];
            for k in 2..8 {
                offset = corners[k].times_plus(f32x8::splat(simd, weights[k]), offset);
            }
            point.store(corners[0] + offset);
        }
    }
}
