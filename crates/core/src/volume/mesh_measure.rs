//! The exact signed volume of the embedded surface.

use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f32x8, f64x4};

use super::line::{Arm, Determinants, Line, Moving, load};
use super::sums::{ChunkedSum, DETERMINANTS, Scratch};
use crate::lattice::{Embedding, monomials, polynomial};
use crate::parallel::Executor;
use crate::simd::level;

/// Surface points in a batch: what one thread carries at a time.
const BATCH: usize = 1024;

/// Patches in a chunk.
const PATCHES: usize = 64;

/// Sum over the triangles of `det[a, b, c] / 6`. The surface is linear in the lattice: a point on it moves along a
/// straight line as the lattice vertices do, and the volume is an exact cubic.
///
/// Where many triangles lie in one cell they are a [`Patch`]; of a fine mesh in a coarse lattice, that leaves those
/// that cross from cell to cell.
#[derive(Clone, Debug)]
pub(super) struct MeshMeasure {
    patches: Vec<Patch>,
    /// Of each batch of points those of each cell, and where its runs end.
    runs: Vec<Run>,
    ends: Vec<usize>,
    weights: Vec<[f32; 8]>,
    triangles: Vec<[u32; 3]>,
    /// Of the patches, then of the triangles.
    sums: ChunkedSum,
}

/// The parts of a [`MeshMeasure`], one component after the other.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) patches: Vec<Patch>,
    /// Patches of each component.
    pub(super) patch_counts: Vec<usize>,
    /// Other triangles, turned outwards (inwards for a cavity).
    pub(super) triangles: Vec<[u32; 3]>,
    /// Other triangles of each component.
    pub(super) triangle_counts: Vec<usize>,
}

/// Points in one cell.
#[derive(Clone, Debug)]
struct Run {
    corners: [u32; 8],
    points: usize,
}

impl MeshMeasure {
    /// `points`: the mesh vertices of the triangles, whose corners are numbers among these.
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

    /// Memory that it takes.
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
        executor.share(batches.enumerate(), |(batch, (surface_points, weights))| {
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

/// Carries the points of some cells along: each is the weighted mean of the corners of its cell.
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
        // From one corner on: small numbers, of which little is lost to rounding.
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

/// Products of three different basis functions of eight.
const MOMENTS: usize = 56;

/// From how many triangles on a patch is cheaper than the triangles: it takes 21 determinants and 56 sums.
pub(super) const WORTHWHILE: usize = 16;

/// Triangles whose corners all lie in one cell.
///
/// In a cell a surface point is `sum_i f_i(x, y, z) m_i`, with `f = 1, x, y, xy, z, xz, yz, xyz` and `m_i` the
/// differences of the cell's corners along those axes. The sum of `det[a, b, c]` over triangles is then
/// `sum_{i<j<k} M_ijk det[m_i, m_j, m_k]`, and `M_ijk`, the sum of the minors of `f` at the corners, is constant.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    corners: [u32; 8],
    /// `M_ijk`, in the order of [`triples`].
    moments: [f64; MOMENTS],
}

/// The pairs `j < k`, for each the `i < j`.
fn triples() -> impl Iterator<Item = [usize; 3]> {
    (1..8).flat_map(|j| (j + 1..8).flat_map(move |k| (0..j).map(move |i| [i, j, k])))
}

impl Patch {
    /// `corners`: those of the cell. `triangles`: places of their corners in the cell.
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

    /// Adds the sum of `det[a, b, c]`.
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
