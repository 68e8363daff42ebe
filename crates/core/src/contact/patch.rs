//! Contact patches: the touching samples about one lattice vertex.

use fearless_simd::{Select, Simd, SimdBase, f32x8, f64x4};

use super::samples::SampleBlock;
use crate::lattice::corner_sums;
use crate::simd::lanes::LANES;

/// A vertex and its neighbours: 3 x 3 x 3, x fastest, the vertex itself at 13.
const NEIGHBORHOOD: usize = 27;

/// Index of corner k of a cell among the neighbours of its corner l: `13 + OFFSETS[k] - OFFSETS[l]`.
const OFFSETS: [usize; 8] = [0, 1, 3, 4, 9, 10, 12, 13];

/// The touching samples that are nearest, within their cells, to the same lattice vertex. They act as one point, the
/// mean of their places weighted by depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// The neighbours that move any of the samples: bits.
    used: u32,
    /// Their rows, and the sums of their weights over the samples.
    rows: [u32; NEIGHBORHOOD],
    weights: [f64; NEIGHBORHOOD],
    /// Sum of the weights of the samples.
    total: f64,
    /// Depth of the deepest sample, in cells; negative outside the collider.
    pub(super) deepest: f64,
}

/// The touching samples of one block.
pub(super) struct Touching<S: Simd> {
    /// Sum of their shares.
    pub(super) count: f64,
    /// Depth of the deepest, in cells; negative outside the collider.
    pub(super) deepest: f64,
    /// Weight of each: its depth below the skin times its share; zero where it does not touch.
    weights: [f64x4<S>; 2],
}

impl<S: Simd> Touching<S> {
    /// The samples nearer than `skin`, if there is one; NaN does not touch.
    #[inline(always)]
    pub(super) fn within(
        simd: S,
        distances: [f64x4<S>; 2],
        shares: &[f32; LANES],
        skin: f64,
    ) -> Option<Self> {
        let (zero, nothing) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, f64::NEG_INFINITY));
        let (low, high) = simd.widen_f32x8(f32x8::load_array_ref(simd, shares));
        let (mut weights, mut count, mut deepest) = ([zero; 2], zero, nothing);
        for (half, share) in [low, high].into_iter().enumerate() {
            let depth = f64x4::splat(simd, skin) - distances[half];
            let touches = depth.simd_ge(zero);
            weights[half] = touches.select(depth * share, zero);
            count += touches.select(share, zero);
            deepest = deepest.max(touches.select(depth, nothing));
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
    /// A patch without samples.
    pub(super) fn new() -> Self {
        let (rows, weights) = ([0; NEIGHBORHOOD], [0.0; NEIGHBORHOOD]);
        Self { used: 0, rows, weights, total: 0.0, deepest: f64::NEG_INFINITY }
    }

    /// Adds samples of a block of a cell with these corners; `monomials` are those of their places.
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

    /// Whether any sample has a weight: not if all lie exactly at the end of the skin.
    pub(super) fn has_weight(&self) -> bool {
        self.total > 0.0
    }

    /// The point of the patch as a mean of lattice vertices: rows and weights.
    pub(super) fn vertices(&self) -> impl Iterator<Item = (u32, f32)> + Clone {
        let (mut left, share) = (self.used, 1.0 / self.total);
        std::iter::from_fn(move || {
            let k = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (k < NEIGHBORHOOD).then(|| (self.rows[k], (self.weights[k] * share) as f32))
        })
    }
}
