//! Scales that minimize a sum over links and regions, by Chebyshev iterations.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, dispatch, f32x8};

use crate::parallel::Executor;
use crate::simd::lanes::{Block, load, store};
use crate::simd::level;
use crate::simd::vector::Product;
use crate::volume::blocks::Blocks;

/// Buffers of the iterations, in [`Blocks`].
#[derive(Clone, Debug, Default)]
pub(super) struct Scales {
    /// For each block: sum of the weights, and sum of the weighted wanted scales.
    pub(super) block_sums: Vec<[f32; 2]>,
    /// For each component: sums of `block_sums`.
    sums: Vec<[f64; 2]>,
    /// Change of each scale in the last iteration.
    changes: Vec<Block<1>>,
    /// Scales before the iteration.
    previous: Vec<Block<1>>,
    /// Scale of each vertex.
    pub(super) values: Vec<Block<1>>,
}

impl Scales {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { block_sums, sums, changes, previous, values } = self;
        let sums = size_of_val(&**block_sums) + size_of_val(&**sums);
        sums + size_of_val(&**changes) + size_of_val(&**previous) + size_of_val(&**values)
    }

    /// Sets the sizes of the buffers.
    pub(super) fn resize(&mut self, blocks: &Blocks) {
        blocks.resize(&mut self.changes);
        blocks.resize(&mut self.previous);
        blocks.resize(&mut self.values);
        self.block_sums.resize(blocks.len(), [0.0; 2]);
    }

    /// Runs `iterations` Chebyshev iterations for the minimum, from the mean wanted scale of each component.
    ///
    /// * `components`: number of components.
    /// * `equations`: see [`equation`].
    /// * `eigenvalues`: range of the eigenvalues that the iterations reduce.
    pub(super) fn iterate(
        &mut self,
        executor: &Executor,
        (blocks, components): (&Blocks, usize),
        equations: &[Block<2>],
        iterations: usize,
        [low, high]: [f32; 2],
    ) {
        self.sum_components(blocks, components);
        let (center, radius) = ((high + low) / 2.0, (high - low) / 2.0);
        let mut rho = radius / center;
        // Factors of the last change and of the preconditioned residual.
        let mut factors = [0.0, 1.0 / center];
        for iteration in 0..iterations {
            let Self { sums, changes, previous, values, .. } = &mut *self;
            std::mem::swap(values, previous);
            let (sums, before) = (&*sums, &*previous);
            let out = blocks.split(changes).zip(blocks.split(values));
            executor.for_each(blocks.chunks.iter().zip(out), |(chunk, (changes, values))| {
                dispatch!(level(), simd => {
                    for (block, (change, value)) in chunk.blocks.clone().zip(changes.iter_mut().zip(values)) {
                        let [weighted, inverse] = load(simd, &equations[block]);
                        let [mut s] = load(simd, &before[block]);
                        let [mut last] = load(simd, change);
                        let neighbors;
                        if iteration == 0 {
                            let mean = mean(sums[blocks.components[block] as usize]);
                            s = blocks.filled(simd, block, f32x8::splat(simd, mean));
                            last = f32x8::splat(simd, 0.0);
                            neighbors = blocks.links(simd, block) * s;
                        } else {
                            neighbors = blocks.sum(simd, block, (before, 0));
                        }
                        let residual = (neighbors + weighted).times_minus(inverse, s);
                        let next = last.times_plus(factors[0], residual * factors[1]);
                        store([next], change);
                        store([s + next], value);
                    }
                });
            });
            let next = 1.0 / (2.0 * center / radius - rho);
            factors = [next * rho, 2.0 * next / radius];
            rho = next;
        }
    }

    /// Adds the sums of the blocks of each component.
    fn sum_components(&mut self, blocks: &Blocks, components: usize) {
        self.sums.clear();
        self.sums.resize(components, [0.0; 2]);
        for (block_sums, &component) in self.block_sums.iter().zip(&blocks.components) {
            for (sum, value) in self.sums[component as usize].iter_mut().zip(block_sums) {
                *sum += f64::from(*value);
            }
        }
    }
}

/// Returns the mean wanted scale for the sums of the weights and of the weighted wanted scales.
fn mean([weight, weighted]: [f64; 2]) -> f32 {
    if weight > 0.0 { (weighted / weight) as f32 } else { 0.0 }
}

/// Returns the rows of the equations of eight scales, and the sums over the block.
///
/// The scale `s` of a vertex with `links` links is the minimum if
/// `(links + w) s = sum of the scales over the links + w u`, with the weight `w` and the wanted scale `u`. `weights`:
/// `w` and `w u`. The rows are `w u` and `1 / (links + w)`, both 0 in lanes without a vertex; the sums are of `w`
/// and `w u`.
#[inline(always)]
pub(super) fn equation<S: Simd>(
    simd: S,
    weights: [f32x8<S>; 2],
    links: f32x8<S>,
) -> ([f32x8<S>; 2], [f32; 2]) {
    let zero = f32x8::splat(simd, 0.0);
    let is_valid = links.simd_gt(zero) & weights[0].is_finite() & weights[1].is_finite();
    let [weight, weighted] = [is_valid.select(weights[0], zero), is_valid.select(weights[1], zero)];
    let inverse = links.simd_gt(zero).select(f32x8::splat(simd, 1.0) / (links + weight), zero);
    ([weighted, inverse], [weight.reduce_sum(), weighted.reduce_sum()])
}
