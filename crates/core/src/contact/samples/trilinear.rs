//! Trilinear interpolation in a cell.

use fearless_simd::{Simd, SimdBase, f32x8, f64x4};

use crate::simd::lanes::LANES;

/// The sums of the corners' weights over places, from those of the monomials 1, x, y, xy, z, xz, yz, xyz.
#[inline(always)]
pub(in crate::contact) fn corner_sums(mut sums: [f64; 8]) -> [f64; 8] {
    for bit in [1, 2, 4] {
        for k in 0..8 {
            if k & bit != 0 {
                sums[k - bit] -= sums[k];
            }
        }
    }
    sums
}

/// The monomials 1, x, y, xy, z, xz, yz, xyz at eight places, four to a half.
#[inline(always)]
pub(in crate::contact) fn monomials<S: Simd>(simd: S, places: &[[f32; LANES]; 3]) -> [[f64x4<S>; 8]; 2] {
    let one = f64x4::splat(simd, 1.0);
    let mut halves = [[one; 8]; 2];
    for a in 0..3 {
        let (low, high) = simd.widen_f32x8(f32x8::load_array_ref(simd, &places[a]));
        let bit = 1 << a;
        for k in 0..bit {
            halves[0][k + bit] = halves[0][k] * low;
            halves[1][k + bit] = halves[1][k] * high;
        }
    }
    halves
}

/// The value of a [`polynomial`](crate::lattice::polynomial), from its monomials.
#[inline(always)]
pub(in crate::contact) fn value<S: Simd>(simd: S, terms: &[f64; 8], monomials: &[f64x4<S>; 8]) -> f64x4<S> {
    let mut sum = f64x4::splat(simd, terms[0]);
    for k in 1..8 {
        sum += f64x4::splat(simd, terms[k]) * monomials[k];
    }
    sum
}

#[cfg(test)]
mod tests {
    use crate::lattice::polynomial;
    use fearless_simd::dispatch;

    use super::*;
    use crate::simd::level;

    /// Trilinear weights of the corners of a cell; corner k lies at (k & 1, k >> 1 & 1, k >> 2 & 1).
    fn trilinear(local: [f32; 3]) -> [f64; 8] {
        let t = local.map(f64::from);
        std::array::from_fn(|k| (0..3).map(|a| if k >> a & 1 == 1 { t[a] } else { 1.0 - t[a] }).product())
    }

    #[test]
    fn values_and_sums_are_those_of_the_weights() {
        let corners = [5.0, -1.0, 2.0, 0.5, 8.0, 3.0, -4.0, 1.5];
        let places = [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.875], [1.0, 0.0, 0.375]];
        let mut block = [[f32::NAN; LANES]; 3];
        for (lane, place) in places.iter().enumerate() {
            (0..3).for_each(|a| block[a][2 * lane] = place[a]);
        }
        dispatch!(level(), simd => {
            let halves = monomials(simd, &block);
            let mut sums = [0.0; 8];
            for (lane, place) in places.iter().enumerate() {
                let weights = trilinear(*place);
                let (half, lane) = (&halves[2 * lane / 4], 2 * lane % 4);
                let expected: f64 = weights.iter().zip(corners).map(|(w, c)| w * c).sum();
                let values = value(simd, &polynomial(corners), half).to_array();
                assert!((values[lane] - expected).abs() < 1e-13 && values[lane + 1].is_nan());
                (0..8).for_each(|k| sums[k] += half[k].to_array()[lane]);
            }
            let sums = corner_sums(sums);
            for k in 0..8 {
                let expected: f64 = places.iter().map(|place| trilinear(*place)[k]).sum();
                assert!((sums[k] - expected).abs() < 1e-13);
            }
        });
    }
}
