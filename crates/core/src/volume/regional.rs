//! A scale of the correction for each vertex: volume is regained where it was lost.
//!
//! One `lambda` for all of a body shrinks parts that were not stretched. Here each region, a vertex with those up to one
//! link away in z, y and x, has a `lambda` of its own: what the volumes of its vertices have lost, over what they gain
//! per unit of `lambda`. A vertex takes the mean over the regions that hold it, by the adjoint of the same sums, so
//! that neighbours differ little.

use fearless_simd::{Simd, dispatch};

use super::adjacency::Adjacency;
use super::line::{Moving, value_and_slope};
use super::measure::differences;
use crate::parallel::Executor;
use crate::simd::level;

/// Passes: the first moves most, the second corrects where it moved too far.
const PASSES: usize = 2;

/// Regularization: damps regions that gain less per unit of `lambda` than this fraction of their gain at rest.
const LEAST_GAIN: f32 = 0.4;

/// Bound of a region's `lambda` in each pass, as a fraction of the cap: where parts collapse, as about a sharp edge, more
/// would crease the body rather than fill it.
const MOST: f32 = 0.5;

/// Vertices in a task.
const CHUNK: usize = 4096;

/// A body at rest, region by region.
#[derive(Clone, Debug)]
pub(super) struct Regional {
    /// Of each vertex at rest: its volume in cells.
    rest: Vec<f64>,
    /// Of each region at rest: how much it gains per unit of `lambda`.
    gains: Vec<f32>,
    /// How many regions hold each vertex.
    regions: Vec<f32>,
}

/// The scales of a deformed body, and the buffers that they take.
#[derive(Clone, Debug, Default)]
pub(super) struct RegionalScratch {
    /// Of each vertex, then of each region: what was lost, and what is gained per unit of `lambda`.
    lost: Buffer<2>,
    /// Of each region, then of each vertex.
    lambdas: Buffer<1>,
    /// How far each point went, in units of its direction.
    pub(super) scales: Vec<f32>,
}

impl RegionalScratch {
    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.lost.bytes() + self.lambdas.bytes() + size_of_val(&*self.scales)
    }
}

impl Regional {
    /// `points`: the lattice at rest, with its field.
    pub(super) fn new(adjacency: &Adjacency, points: &[Moving]) -> Self {
        let executor = Executor::sequential();
        let volume = |row: &[u32; 6]| dispatch!(level(), simd => volume(simd, row, points))[0];
        let rest = adjacency.rows.iter().map(volume).collect();
        let mut this = Self { rest, gains: Vec::new(), regions: Vec::new() };
        let (mut lost, mut count) = (Buffer::default(), Buffer::default());
        this.measure(&executor, adjacency, points, &mut lost);
        this.gains = lost.values.iter().map(|[_, gain]| *gain).collect();
        count.resize(adjacency.len(), [1.0]);
        count.sum(&executor, adjacency, [2, 1, 0]);
        this.regions = count.values.iter().map(|[count]| *count).collect();
        this
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.rest) + size_of_val(&*self.gains) + size_of_val(&*self.regions)
    }

    /// Moves the points along their directions, by scales below `caps[component]` in all.
    pub(super) fn give_back(
        &self,
        scratch: &mut RegionalScratch,
        executor: &Executor,
        adjacency: &Adjacency,
        caps: &[f64],
        points: &mut [Moving],
    ) {
        let RegionalScratch { lost, lambdas, scales } = scratch;
        lambdas.resize(points.len(), [0.0]);
        scales.clear();
        scales.resize(points.len(), 0.0);
        for _ in 0..PASSES {
            self.measure(executor, adjacency, points, lost);
            let regions = lost.values.iter().zip(&self.gains).zip(&adjacency.of_vertex);
            for ([lambda], ((lost, gain), component)) in lambdas.values.iter_mut().zip(regions) {
                *lambda = scale(*lost, *gain, caps[*component as usize] as f32);
            }
            lambdas.sum(executor, adjacency, [2, 1, 0]);
            let means = lambdas.values.iter().zip(&self.regions).map(|([sum], count)| sum / count);
            for (mean, (scale, point)) in means.zip(scales.iter_mut().zip(&mut *points)) {
                *scale += mean;
                point.advance(mean);
            }
        }
    }

    /// What each region has lost since it was at rest, and what it gains per unit of `lambda`.
    fn measure(&self, executor: &Executor, adjacency: &Adjacency, points: &[Moving], lost: &mut Buffer<2>) {
        lost.resize(points.len(), [0.0; 2]);
        let rest = self.rest.chunks(CHUNK).zip(adjacency.rows.chunks(CHUNK));
        executor.share(rest.zip(lost.values.chunks_mut(CHUNK)), |((rest, rows), out)| {
            dispatch!(level(), simd => measure(simd, rows, points, rest, out));
        });
        lost.sum(executor, adjacency, [0, 1, 2]);
    }
}

/// The `lambda` of a region that has lost so much and gains so much per unit, and gained `at_rest`.
#[inline]
fn scale([lost, gain]: [f32; 2], at_rest: f32, cap: f32) -> f32 {
    let (least, most) = (LEAST_GAIN * at_rest, MOST * cap);
    let wanted = lost * gain / (gain * gain + least * least);
    // The wish where it is small, and smoothly no more than the most.
    let wish = (wanted / most).clamp(-1e9, 1e9);
    let bounded = most * wish / (1.0 + wish * wish).sqrt();
    if bounded.is_finite() { bounded } else { 0.0 }
}

/// The volume of a vertex as the measure `lattice` has it, and what it gains per unit of `lambda`.
#[inline(always)]
fn volume<S: Simd>(simd: S, row: &[u32; 6], points: &[Moving]) -> [f64; 2] {
    let (x, y, z) = differences(simd, row, points);
    value_and_slope(x, y, z).map(|volume| volume / 8.0)
}

#[inline(always)]
fn measure<S: Simd>(simd: S, rows: &[[u32; 6]], points: &[Moving], rest: &[f64], out: &mut [[f32; 2]]) {
    for ((row, rest), out) in rows.iter().zip(rest).zip(out) {
        let [now, gain] = volume(simd, row, points);
        *out = [(rest - now) as f32, gain as f32];
    }
}

/// `N` numbers a vertex, summed in place.
#[derive(Clone, Debug, Default)]
struct Buffer<const N: usize> {
    values: Vec<[f32; N]>,
    before: Vec<[f32; N]>,
}

impl<const N: usize> Buffer<N> {
    /// Sets the length; values beyond the one before are `value`.
    fn resize(&mut self, len: usize, value: [f32; N]) {
        self.values.resize(len, value);
        self.before.resize(len, value);
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.values) + size_of_val(&*self.before)
    }

    /// Sums over each vertex and its neighbours along an axis, for some axes one after the other.
    fn sum(&mut self, executor: &Executor, adjacency: &Adjacency, axes: [usize; 3]) {
        for axis in axes {
            std::mem::swap(&mut self.values, &mut self.before);
            let before = &self.before;
            let rows = adjacency.rows.chunks(CHUNK).enumerate();
            executor.share(rows.zip(self.values.chunks_mut(CHUNK)), |((chunk, rows), values)| {
                for ((i, row), value) in (chunk * CHUNK..).zip(rows).zip(values) {
                    *value = before[i];
                    for side in [2 * axis, 2 * axis + 1] {
                        let neighbour = row[side] as usize;
                        if neighbour != i {
                            for k in 0..N {
                                value[k] += before[neighbour][k];
                            }
                        }
                    }
                }
            });
        }
    }
}
