//! The measure `mesh`: the exact signed volume of the embedded surface.

use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f32x8, f64x4};

use super::line::{Arm, Determinants, Line, Moving, load};
use super::sums::{ChunkedSum, DETERMINANTS, Scratch};
use crate::lattice::{Embedding, monomials, polynomial};
use crate::parallel::Executor;
use crate::simd::level;

/// Number of surface points in a batch, which one task interpolates.
const BATCH: usize = 1024;

/// Number of patches in a chunk of the sum.
const PATCHES: usize = 64;

/// Measure `mesh`: the sum of `det[a, b, c] / 6` over the triangles.
///
/// A surface point is a linear combination of lattice vertices, and moves along a straight line as they do;
/// the volume is therefore an exact cubic. Cells with many triangles store them as a [`Patch`]. In a fine
/// mesh in a coarse lattice only the triangles that cross cell boundaries are then summed one by one.
#[derive(Clone, Debug)]
pub(super) struct MeshMeasure {
    patches: Vec<Patch>,
    /// Runs of surface points by cell, batch by batch.
    runs: Vec<Run>,
    /// End of the runs of each batch.
    ends: Vec<usize>,
    /// Trilinear weights of each surface point.
    weights: Vec<[f32; 8]>,
    /// Triangles that are in no patch.
    triangles: Vec<[u32; 3]>,
    /// Sum over the patches, then over the triangles.
    sums: ChunkedSum,
}

/// Parts of a [`MeshMeasure`], sorted by component.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) patches: Vec<Patch>,
    /// Number of patches of each component.
    pub(super) patch_counts: Vec<usize>,
    /// Other triangles, oriented outwards (inwards for a cavity).
    pub(super) triangles: Vec<[u32; 3]>,
    /// Number of other triangles of each component.
    pub(super) triangle_counts: Vec<usize>,
}

/// Run of surface points in one cell.
#[derive(Clone, Debug)]
struct Run {
    corners: [u32; 8],
    /// Number of points.
    points: usize,
}

impl MeshMeasure {
    /// Creates the measure. `points`: mesh vertices, to which the triangles' corners are indices.
    pub(super) fn new(parts: Parts, points: &[u32], embedding: &Embedding) -> Self {
        let Parts { patches, patch_counts, triangles, triangle_counts } = parts;
        let cell = |point: u32| embedding.cell(point as usize);
        let (mut runs, mut ends) = (Vec::new(), Vec::new());
        for batch in points.chunks(BATCH) {
            let cells = batch.chunk_by(|&a, &b| cell(a) == cell(b));
            runs.extend(
                cells.map(|points| Run {
                    corners: embedding.corners(points[0] as usize),
                    points: points.len(),
                }),
            );
            ends.push(runs.len());
        }
        Self {
            patches,
            runs,
            ends,
            weights: points.iter().map(|&point| embedding.weights(point as usize)).collect(),
            triangles,
            sums: ChunkedSum::new(&patch_counts, PATCHES).then(&triangle_counts, DETERMINANTS),
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let points = size_of_val(&*self.weights) + size_of_val(&*self.runs);
        size_of_val(&*self.patches) + points + size_of_val(&*self.triangles)
    }

    /// Adds the coefficients of each component to those of `scratch`.
    pub(super) fn add_coefficients(&self, executor: &Executor, scratch: &mut Scratch) {
        let Scratch { points: lattice, surface_points, sums, coefficients, .. } = scratch;
        surface_points.resize(self.weights.len(), Moving::default());
        let (runs, ends) = (&self.runs, &self.ends);
        let batches = surface_points.chunks_mut(BATCH).zip(self.weights.chunks(BATCH));
        executor.for_each(batches.enumerate(), |(batch, (surface_points, weights))| {
            let first = if batch == 0 { 0 } else { ends[batch - 1] };
            dispatch!(level(), simd => interpolate(simd, &runs[first..ends[batch]], lattice, weights, surface_points));
        });
        let (patches, surface_points, triangles) = (&self.patches, &*surface_points, &self.triangles);
        self.sums.add_to(executor, 1.0 / 6.0, sums, coefficients, |range| {
            dispatch!(level(), simd => {
                let mut sum = Determinants::zero(simd);
                if range.end <= patches.len() {
                    for patch in &patches[range] {
                        patch.add_to(simd, lattice, &mut sum);
                    }
                } else {
                    for triangle in &triangles[range.start - patches.len()..range.end - patches.len()] {
                        let [a, b, c] = load(simd, surface_points, triangle);
                        sum.add(Line::zxy(simd, a), Arm::new(simd, b - a), Arm::new(simd, c - a));
                    }
                }
                sum.coefficients()
            })
        });
    }
}

/// Interpolates surface points: each is the weighted mean of the corners of its cell.
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
        // Relative to the first corner: the differences are small, which keeps rounding errors small.
        let mut corners = load(simd, lattice, &run.corners);
        for k in 1..8 {
            corners[k] -= corners[0];
        }
        for (point, weights) in points.by_ref().take(run.points) {
            let mut offset = corners[1] * weights[1];
            for k in 2..8 {
                offset = corners[k].mul_add(f32x8::splat(simd, weights[k]), offset);
            }
            point.store(corners[0] + offset);
        }
    }
}

/// Number of triples of the eight basis functions.
const MOMENTS: usize = 56;

/// Least number of triangles for which a patch is cheaper: a patch costs 21 determinants and 56 sums.
pub(super) const MIN_PATCH_TRIANGLES: usize = 16;

/// Patch: triangles whose corners all lie in one cell.
///
/// A surface point in a cell is `sum_i f_i(x, y, z) m_i`, with `f = 1, x, y, xy, z, xz, yz, xyz` and `m_i`
/// the differences of the cell's corners along these axes. The sum of `det[a, b, c]` over triangles is then
/// `sum_{i<j<k} M_ijk det[m_i, m_j, m_k]`, where `M_ijk`, the sum of the minors of `f` at the triangles'
/// corners, is constant.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    corners: [u32; 8],
    /// `M_ijk`, in the order of [`triples`].
    moments: [f64; MOMENTS],
}

/// Returns the triples `i < j < k`: all pairs `j < k`, and for each pair all `i < j`.
fn triples() -> impl Iterator<Item = [usize; 3]> {
    (1..8).flat_map(|j| (j + 1..8).flat_map(move |k| (0..j).map(move |i| [i, j, k])))
}

impl Patch {
    /// Creates a patch. `corners`: those of the cell. `triangles`: positions of their corners in the cell.
    pub(super) fn new(corners: [u32; 8], triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let mut moments = [0.0; MOMENTS];
        for triangle in triangles {
            let [a, b, c] = triangle.map(|place| monomials(1.0, place.map(f64::from)));
            for (moment, [i, j, k]) in moments.iter_mut().zip(triples()) {
                *moment += a[i] * (b[j] * c[k] - b[k] * c[j])
                    + a[j] * (b[k] * c[i] - b[i] * c[k])
                    + a[k] * (b[i] * c[j] - b[j] * c[i]);
            }
        }
        Self { corners, moments }
    }

    /// Adds the sum of `det[a, b, c]` over the triangles to `sum`.
    #[inline(always)]
    pub(super) fn add_to<S: Simd>(&self, simd: S, lattice: &[Moving], sum: &mut Determinants<S>) {
        let terms = polynomial(load(simd, lattice, &self.corners));
        let (mut rows, mut arms) = ([Line::zero(simd); 8], [Arm::new(simd, terms[0]); 8]);
        for k in 0..8 {
            rows[k] = Line::zxy(simd, terms[k]);
            arms[k] = Arm::new(simd, terms[k]);
        }
        let mut moments = self.moments.iter();
        for j in 1..8 {
            for k in j + 1..8 {
                let mut weighted = Line::zero(simd);
                for i in 0..j {
                    let moment = moments.next().copied().unwrap_or_default();
                    weighted = weighted.plus_times(rows[i], f64x4::splat(simd, moment));
                }
                sum.add(weighted, arms[j], arms[k]);
            }
        }
    }
}
