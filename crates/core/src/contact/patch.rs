//! The samples that touch about one lattice vertex.

use fearless_simd::{Select, Simd, SimdBase, f32x8, f64x4};

use crate::contact::samples::{SampleBlock, corner_sums};
use crate::simd::lanes::LANES;

/// Lattice vertices at and around a vertex.
const AROUND: usize = 27;

/// Where corner k of a cell stands among the vertices around its corner l, by l and k.
const PLACES: [[u8; 8]; 8] = places();

/// The samples that touch and are nearest, within their cells, to the same lattice vertex. They act as one, at the
/// mean of their places, in which each counts by its depth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    /// The vertices around it, x fastest, of which a sample is a mean: bits.
    seen: u32,
    /// Their rows, and the sums of their weights over the samples.
    rows: [u32; AROUND],
    weights: [f64; AROUND],
    /// Sum of what the samples count.
    total: f64,
    /// Depth of the deepest sample, in cells; negative outside the collider.
    pub(super) deepest: f64,
}

/// Samples of one block that touch.
pub(super) struct Touching<S: Simd> {
    /// How many there are, each as its share.
    pub(super) count: f64,
    /// Depth of the deepest, in cells; negative outside the collider.
    pub(super) deepest: f64,
    /// Depth of each below the skin, times its share; zero for those that do not touch.
    importance: [f64x4<S>; 2],
}

impl<S: Simd> Touching<S> {
    /// Those that are nearer than `skin`, if any; a distance that is not a number is not.
    #[inline(always)]
    pub(super) fn within(
        simd: S,
        distances: [f64x4<S>; 2],
        shares: &[f32; LANES],
        skin: f64,
    ) -> Option<Self> {
        let (zero, nothing) = (f64x4::splat(simd, 0.0), f64x4::splat(simd, f64::NEG_INFINITY));
        let (low, high) = simd.widen_f32x8(f32x8::load_array_ref(simd, shares));
        let (mut importance, mut count, mut deepest) = ([zero; 2], zero, nothing);
        for (half, share) in [low, high].into_iter().enumerate() {
            let depth = f64x4::splat(simd, skin) - distances[half];
            let touches = depth.simd_ge(zero);
            importance[half] = touches.select(depth * share, zero);
            count += touches.select(share, zero);
            deepest = deepest.max(touches.select(depth, nothing));
        }
        let [a, b, c, d] = count.to_array();
        let count = (a + b) + (c + d);
        if count == 0.0 {
            return None;
        }
        let deepest = deepest.to_array().into_iter().fold(f64::NEG_INFINITY, f64::max) - skin;
        Some(Self { count, deepest, importance })
    }
}

impl Patch {
    /// No sample yet.
    pub(super) fn new() -> Self {
        let (rows, weights) = ([0; AROUND], [0.0; AROUND]);
        Self { seen: 0, rows, weights, total: 0.0, deepest: f64::NEG_INFINITY }
    }

    /// Takes the samples of a block of a cell with these corners; `monomials` are those of their places.
    #[inline(always)]
    pub(super) fn take<S: Simd>(
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
                sum += monomials[half][k] * touching.importance[half];
            }
            let [a, b, c, d] = sum.to_array();
            sums[k] = (a + b) + (c + d);
        }
        self.total += sums[0];
        let sums = corner_sums(sums);
        let places = &PLACES[usize::from(block.corner)];
        for k in 0..8 {
            // Of weights that are nothing but rounding the vertex need not hear.
            if sums[k] > 1e-9 * self.total {
                let place = usize::from(places[k]);
                self.seen |= 1 << place;
                self.rows[place] = corners[k];
                self.weights[place] += sums[k];
            }
        }
    }

    /// Whether it is more than samples that lie just where the skin ends.
    pub(super) fn counts(&self) -> bool {
        self.total > 0.0
    }

    /// The vertices of which the mean place of the samples is the weighted mean: rows and weights.
    pub(super) fn vertices(&self) -> impl Iterator<Item = (u32, f32)> {
        let (mut left, share) = (self.seen, 1.0 / self.total);
        std::iter::from_fn(move || {
            let place = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
            (place < AROUND).then(|| (self.rows[place], (self.weights[place] * share) as f32))
        })
    }
}

const fn places() -> [[u8; 8]; 8] {
    let mut places = [[0; 8]; 8];
    let mut pair = 0;
    while pair < 64 {
        let (from, to, mut place, mut a) = (pair / 8, pair % 8, 0, 3);
        while a > 0 {
            a -= 1;
            place = 3 * place + 1 + (to >> a & 1) as u8 - (from >> a & 1) as u8;
        }
        places[from][to] = place;
        pair += 1;
    }
    places
}
