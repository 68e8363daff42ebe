//! Contact patches: the touching samples nearest to one lattice vertex.

use fearless_simd::{Select, Simd, SimdBase, f32x8, f64x4};

use super::samples::SampleBlock;
use crate::lattice::corner_sums;
use crate::simd::lanes::LANES;

/// Size of the neighborhood of a vertex: 3 x 3 x 3 vertices, x fastest, the vertex itself at index 13.
const NEIGHBORHOOD: usize = 27;

/// Corner k of a cell has the index `13 + OFFSETS[k] - OFFSETS[l]` in the neighborhood of corner l.
const OFFSETS: [usize; 8] = [0, 1, 3, 4, 9, 10, 12, 13];

/// Touching samples that have the same lattice vertex as their nearest cell corner.
///
/// They act as one contact point: the mean of their positions, weighted by depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// Bit mask of the neighbors that have a weight.
    used: u32,
    /// Row of each neighbor.
    rows: [u32; NEIGHBORHOOD],
    /// Weight of each neighbor: the sum over the samples of sample weight times trilinear weight.
    weights: [f64; NEIGHBORHOOD],
    /// Sum of the weights of all samples.
    total: f64,
    /// Depth of the deepest sample, in cells; negative outside the collider.
    pub(super) deepest: f64,
}

/// Touching samples of one block of eight.
pub(super) struct Touching<S: Simd> {
    /// Number of touching samples: the sum of their shares.
    pub(super) count: f64,
    /// Depth of the deepest sample, in cells; negative outside the collider.
    pub(super) deepest: f64,
    /// Weight of each sample: its depth below the skin times its share; zero if it does not touch.
    weights: [f64x4<S>; 2],
}

impl<S: Simd> Touching<S> {
    /// Selects the samples within `skin` of the shape; `None` if there are none. NaN does not touch.
    #[inline(always)]
    pub(super) fn within(
        simd: S,
        distances: [f64x4<S>; 2],
        shares: &[f32; LANES],
        skin: f64,
    ) -> Option<Self> {
        let (zero, lowest) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, f64::NEG_INFINITY));
        let (low, high) = simd.widen_f32x8(f32x8::load_array_ref(simd, shares));
        let (mut weights, mut count, mut deepest) = ([zero; 2], zero, lowest);
        for (half, share) in [low, high].into_iter().enumerate() {
            let depth = f64x4::splat(simd, skin) - distances[half];
            let touches = depth.simd_ge(zero);
            weights[half] = touches.select(depth * share, zero);
            count += touches.select(share, zero);
            deepest = deepest.max(touches.select(depth, lowest));
        }
        let [a, b, c, d] = count.to_array();
        let count = (a + b) + (c + d);
        if count == 0.0 {
            return None;
        }
        let deepest = deepest.to_array().into_iter().fold(f64::NEG_INFINITY, f64::max) - skin;
        Some(Self { count, deepest, weights })
    }
}

impl Patch {
    /// Creates a patch without samples.
    pub(super) fn new() -> Self {
        let (rows, weights) = ([0; NEIGHBORHOOD], [0.0; NEIGHBORHOOD]);
        Self { used: 0, rows, weights, total: 0.0, deepest: f64::NEG_INFINITY }
    }

    /// Adds the touching samples of a block. `corners`: rows of the cell's corners; `monomials`: from the
    /// sample positions.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        touching: &Touching<S>,
        block: &SampleBlock,
        corners: &[u32; 8],
        monomials: &[[f64x4<S>; 8]; 2],
    ) {
        self.deepest = self.deepest.max(touching.deepest);
        let mut sums = [0.0; 8];
        for k in 0..8 {
            let mut sum = f64x4::splat(simd, 0.0);
            for half in 0..2 {
                sum += monomials[half][k] * touching.weights[half];
            }
            let [a, b, c, d] = sum.to_array();
            sums[k] = (a + b) + (c + d);
        }
        self.total += sums[0];
        let sums = corner_sums(sums);
        let from = OFFSETS[usize::from(block.corner)];
        for k in 0..8 {
            // Skips weights at rounding level.
            if sums[k] > 1e-9 * self.total {
                let neighbor = 13 + OFFSETS[k] - from;
                self.used |= 1 << neighbor;
                self.rows[neighbor] = corners[k];
                self.weights[neighbor] += sums[k];
            }
        }
    }

    /// Returns whether any sample has a weight; false if all lie exactly at the outer bound of the skin.
    pub(super) fn has_weight(&self) -> bool {
        self.total > 0.0
    }

    /// Returns the contact point as a weighted mean of lattice vertices: pairs of row and weight.
    pub(super) fn vertices(&self) -> impl Iterator<Item = (u32, f32)> + Clone {
        let (mut remaining, scale) = (self.used, 1.0 / self.total);
        std::iter::from_fn(move || {
            let k = remaining.trailing_zeros() as usize;
            remaining &= remaining.wrapping_sub(1);
            (k < NEIGHBORHOOD).then(|| (self.rows[k], (self.weights[k] * scale) as f32))
        })
    }
}
