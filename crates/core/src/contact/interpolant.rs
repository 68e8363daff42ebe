//! Interpolants of numbers in a cell, evaluated at four positions at once.

use fearless_simd::{Simd, SimdBase, f32x8, f64x4};

use crate::lattice::{self, SmoothCoordinate, SmoothTerms, polynomial};
use crate::simd::lanes::LANES;

/// Computes the monomials 1, x, y, xy, z, xz, yz, xyz at the first four of eight positions in a cell, or at all.
///
/// The first element of the result belongs to the first four positions, the second element to the last four.
/// `positions`: x, y and z of the positions, as in `SampleBlock::positions`.
#[inline(always)]
pub(super) fn monomials<S: Simd, const HALVES: usize>(
    simd: S,
    positions: &[[f32; LANES]; 3],
) -> [[f64x4<S>; 8]; HALVES] {
    let one = f64x4::splat(simd, 1.0);
    let mut places = [[one; 3]; 2];
    for a in 0..3 {
        (places[0][a], places[1][a]) = simd.widen_f32x8(f32x8::load_array_ref(simd, &positions[a]));
    }
    let mut halves = [[one; 8]; HALVES];
    for half in 0..HALVES {
        halves[half] = lattice::monomials(one, places[half]);
    }
    halves
}

/// Evaluates a polynomial at four positions. `terms`: its coefficients, as returned by
/// [`polynomial`](crate::lattice::polynomial). `monomials`: the monomials of the positions.
#[inline(always)]
pub(super) fn value<S: Simd>(simd: S, terms: &[f64; 8], monomials: &[f64x4<S>; 8]) -> f64x4<S> {
    let mut sum = f64x4::splat(simd, terms[0]);
    for k in 1..8 {
        sum += f64x4::splat(simd, terms[k]) * monomials[k];
    }
    sum
}

/// A smooth interpolant of a number in a cell; see `lattice::smooth`.
pub(super) struct SmoothInterpolant {
    terms: SmoothTerms<f64>,
    /// Coefficients of the slope weight; `None` if it is 1 at all corners.
    slope_weights: Option<[f64; 8]>,
}

impl SmoothInterpolant {
    /// Creates the interpolant from the values at the corners, their slopes and slope weights. `None` if all
    /// weights are 0, so that the interpolant is trilinear.
    #[inline(always)]
    pub(super) fn new(values: [f64; 8], slopes: [[f64; 3]; 8], slope_weights: [f64; 8]) -> Option<Self> {
        if slope_weights == [0.0; 8] {
            return None;
        }
        let mut terms = SmoothTerms::new(values, slopes);
        terms.0[0][0] = values[0];
        Some(Self { terms, slope_weights: (slope_weights != [1.0; 8]).then(|| polynomial(slope_weights)) })
    }

    /// Evaluates the interpolant at four positions. `linear`: coefficients of the trilinear interpolant.
    #[inline(always)]
    pub(super) fn value<S: Simd>(&self, simd: S, linear: &[f64; 8], monomials: &[f64x4<S>; 8]) -> f64x4<S> {
        let mut coordinates = [SmoothCoordinate::new(monomials[1]); 3];
        coordinates[1] = SmoothCoordinate::new(monomials[2]);
        coordinates[2] = SmoothCoordinate::new(monomials[4]);
        let [x, y, z] = coordinates;
        let steps = lattice::monomials(monomials[0], [x.s, y.s, z.s]);
        let mut smooth = value(simd, &self.terms.0[0], &steps);
        for axis in 0..3 {
            let [u, v] = [[y.s, z.s], [x.s, z.s], [x.s, y.s]][axis];
            let [along, across] = self.terms.along(axis);
            let SmoothCoordinate { e, k, .. } = coordinates[axis];
            smooth += bilinear(simd, along, u, v) * e + bilinear(simd, across, u, v) * k;
        }
        let Some(slope_weights) = &self.slope_weights else { return smooth };
        let linear = value(simd, linear, monomials);
        linear + value(simd, slope_weights, &steps) * (smooth - linear)
    }
}

/// Evaluates a bilinear polynomial at four positions.
#[inline(always)]
fn bilinear<S: Simd>(simd: S, [one, x, y, xy]: [f64; 4], u: f64x4<S>, v: f64x4<S>) -> f64x4<S> {
    let splat = |term| f64x4::splat(simd, term);
    (splat(one) + u * splat(x)) + (splat(y) + u * splat(xy)) * v
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::lattice::corner_sums;
    use crate::simd::level;

    /// Returns the trilinear weights of a cell's corners. Bit a of the number of a corner is the coordinate
    /// of the corner along axis a.
    fn trilinear(local: [f32; 3]) -> [f64; 8] {
        let t = local.map(f64::from);
        std::array::from_fn(|k| (0..3).map(|a| if k >> a & 1 == 1 { t[a] } else { 1.0 - t[a] }).product())
    }

    #[test]
    fn polynomial_values_and_corner_sums_match_trilinear_weights() {
        let corners = [5.0, -1.0, 2.0, 0.5, 8.0, 3.0, -4.0, 1.5];
        let positions = [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.875], [1.0, 0.0, 0.375]];
        let mut block = [[f32::NAN; LANES]; 3];
        for (lane, position) in positions.iter().enumerate() {
            (0..3).for_each(|a| block[a][2 * lane] = position[a]);
        }
        dispatch!(level(), simd => {
            let halves: [_; 2] = monomials(simd, &block);
            let mut sums = [0.0; 8];
            for (lane, position) in positions.iter().enumerate() {
                let weights = trilinear(*position);
                let (half, lane) = (&halves[2 * lane / 4], 2 * lane % 4);
                let expected: f64 = weights.iter().zip(corners).map(|(w, c)| w * c).sum();
                let values = value(simd, &polynomial(corners), half).to_array();
                assert!((values[lane] - expected).abs() < 1e-13 && values[lane + 1].is_nan());
                (0..8).for_each(|k| sums[k] += half[k].to_array()[lane]);
            }
            let sums = corner_sums(sums);
            for k in 0..8 {
                let expected: f64 = positions.iter().map(|position| trilinear(*position)[k]).sum();
                assert!((sums[k] - expected).abs() < 1e-13);
            }
        });
    }
}
