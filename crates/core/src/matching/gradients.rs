//! Measures the deformation gradients of the regions, for bodies that break.
//!
//! F = A C⁻¹ is the matrix for which F y is closest to x - c over the vertices of a region, where y = x⁰ - c⁰, with the
//! rest covariance C = M⁻¹ Σ m/n y yᵀ (Müller et al. 2005, the product A_pq A_qq of section 4.2). In its plastic
//! shape S, a region is stretched by F S⁻¹. Of a region that is inflated to σ³ times its volume, F is divided by σ,
//! its stretch at rest.

use fearless_simd::{Simd, SimdFloat, SimdMask, dispatch, f32x16};

use super::algebra::{inverse, times};
use super::bulk::{RestVolumes, divided};
use super::cascade::RegionTransform;
use super::flow::shape;
use super::goals::{Means, Pair};
use crate::parallel::{Executor, Split};
use crate::simd::lanes::{Block, LANES, Lanes, load, store};
use crate::simd::level;
use crate::simd::vector::Product;

/// The deformation gradients of regions.
pub(crate) struct Gradients<'a> {
    /// F of each region, column by column. Zero where the vertices of a region lie in a plane. Empty if only
    /// `stretched` is wanted: memory that is not written saves a tenth of the step.
    pub values: &'a mut [Block<9>],
    /// For each block, the bit mask of the lanes whose regions are stretched by more than `least` in some direction.
    /// Some of them may be stretched less.
    pub stretched: &'a mut [u8],
    /// A stretch: the ratio of the length of a vector to that at rest.
    pub least: f32,
}

/// The region transform that measures F before `fit`. The second part of its memory is [`Gradients::stretched`], the
/// third part [`Gradients::values`], which may be empty.
pub(super) struct MeasureGradients<'a, T> {
    pub(super) fit: &'a T,
    /// 1/M and d of each region.
    pub(super) constants: &'a Lanes<4>,
    pub(super) volumes: RestVolumes<'a>,
    pub(super) least: f32,
}

/// The region transform that changes nothing.
pub(super) struct Unfitted;

impl RegionTransform<()> for Unfitted {
    #[inline(always)]
    fn apply<S: Simd>(&self, _: S, _: usize, _: &mut [Block<12>], (): ()) {}
}

impl<M: Split, T: RegionTransform<M>> RegionTransform<(M, (&mut [u8], &mut [Block<9>]))>
    for MeasureGradients<'_, T>
{
    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        sums: &mut [Block<12>],
        (memory, (stretched, values)): (M, (&mut [u8], &mut [Block<9>])),
    ) {
        self.measure(simd, first, sums, stretched, values);
        self.fit.apply(simd, first, sums, memory);
    }
}

impl<T> MeasureGradients<'_, T> {
    /// Computes F of consecutive blocks. `values` may be empty.
    #[inline(always)]
    fn measure<S: Simd>(
        &self,
        simd: S,
        first: usize,
        sums: &[Block<12>],
        stretched: &mut [u8],
        values: &mut [Block<9>],
    ) {
        for index in (0..sums.len()).step_by(2) {
            let pair = Pair::new(first, index, sums.len());
            let moments = pair.load(simd, sums);
            let means: Means<f32x16<S>> = Means::new(pair.load_regions(simd, self.constants), moments);
            let inverse_covariance = self.volumes.inverse_covariances.load_two(simd, pair.blocks);
            let f = times(&means.central, inverse_covariance);
            let f = divided(simd, f, self.volumes.sigma(simd, pair));
            let beyond = is_beyond(simd, &f, self.least).to_bitmask() as u16;
            for half in [0, 1] {
                stretched[pair.indices[half]] = (beyond >> (half * LANES)) as u8;
            }
            if !values.is_empty() {
                pair.store(simd, f, values);
            }
        }
    }
}

impl Gradients<'_> {
    /// Replaces F by F S⁻¹, the stretch of each region from its plastic shape. `strains` has S - 1 of each region, and
    /// `task_blocks` the first block of each task.
    pub(crate) fn take_elastic_parts(self, strains: &Lanes<6>, executor: &Executor, task_blocks: &[usize]) {
        let Self { values, stretched, least } = self;
        executor.tasks(
            task_blocks,
            (values, stretched, &mut []),
            |task, values: &mut [Block<9>], stretched: &mut [u8], _: &mut [()]| {
                let first = task_blocks[task];
                dispatch!(level(), simd => {
                    for ((block, value), stretched) in (first..).zip(values).zip(stretched) {
                        let inverse_shape = inverse(simd, shape(simd, load(simd, &strains.blocks()[block])));
                        let elastic = times(&load(simd, value), inverse_shape);
                        *stretched = is_beyond(simd, &elastic, least).to_bitmask() as u8;
                        store(elastic, value);
                    }
                });
            },
        );
    }
}

/// Returns the lanes in which the greatest stretch of F may exceed `least`: an upper bound of it does. With the mean
/// m of the eigenvalues of X = FᵀF and p² = |X - m|²/6, the greatest eigenvalue of X is at most m + 2 p, and is m + 2
/// p if the other two are equal.
#[inline(always)]
fn is_beyond<S: Simd, V: SimdFloat<S, Element = f32>>(simd: S, f: &[V; 9], least: f32) -> V::Mask {
    let dot = |a: usize, b: usize| {
        f[3 * a].times_plus(f[3 * b], f[3 * a + 1].times_plus(f[3 * b + 1], f[3 * a + 2] * f[3 * b + 2]))
    };
    let (xx, yy, zz, xy, xz, yz) = (dot(0, 0), dot(1, 1), dot(2, 2), dot(0, 1), dot(0, 2), dot(1, 2));
    let mean = (xx + yy + zz) * (1.0 / 3.0);
    let (dx, dy, dz) = (xx - mean, yy - mean, zz - mean);
    let diagonal = dx.times_plus(dx, dy.times_plus(dy, dz * dz));
    let beside = xy.times_plus(xy, xz.times_plus(xz, yz * yz));
    let variance = (beside + beside + diagonal) * (1.0 / 6.0);
    let greatest = variance.sqrt().times_plus(V::splat(simd, 2.0), mean);
    greatest.simd_gt(V::splat(simd, least * least))
}
