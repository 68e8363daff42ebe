//! Stores points as the four numbers `(x, y, z, x)`, for kernels that load points one at a time.
//!
//! One load reads a point. If its lanes are rotated by one, the first three lanes are `(y, z, x)`, the order
//! that a cross product needs. A register `f32x8` contains two points, one in each half.

use fearless_simd::{Select, Simd, SimdBase, f32x8, u8x32};

/// A point or a vector `(x, y, z, x)`.
pub(crate) type Xyzx = [f32; 4];

/// Two points, which fill one register.
pub(crate) type Pair = [f32; 8];

/// Eight points, which fill four registers.
pub(crate) type Eight = [Pair; 4];

/// Converts a point to `(x, y, z, x)`.
#[inline(always)]
pub(crate) fn xyzx([x, y, z]: [f32; 3]) -> Xyzx {
    [x, y, z, x]
}

/// Rotates the lanes of each of two points by one, to `(y, z, x, x)`.
#[inline(always)]
pub(crate) fn rotate_lanes<S: Simd>(simd: S, pair: f32x8<S>) -> f32x8<S> {
    simd.slide_within_blocks_f32x8::<1>(pair, pair)
}

/// Stores eight points.
#[inline(always)]
pub(crate) fn store<S: Simd>(eight: [f32x8<S>; 4], out: &mut Eight) {
    for k in 0..4 {
        eight[k].store_array(&mut out[k]);
    }
}

/// Broadcasts each number of two points. In register `k` of the result, all four lanes of a half contain
/// number `k` of the point in that half.
#[inline(always)]
pub(crate) fn broadcast_lanes<S: Simd>(simd: S, pair: f32x8<S>) -> [f32x8<S>; 4] {
    let mut broadcast = [pair; 4];
    for lane in 0..4 {
        let mut bytes = [0; 32];
        for i in 0..32 {
            bytes[i] = (4 * lane + i % 4) as u8;
        }
        broadcast[lane] = simd.swizzle_dyn_within_blocks_f32x8(pair, u8x32::load_array(simd, bytes));
    }
    broadcast
}

/// Computes the squared lengths of the eight vectors in four registers. Lane `k` of each half of the result
/// belongs to the vector in the same half of register `k`.
#[inline(always)]
pub(crate) fn squared_lengths<S: Simd>(simd: S, eight: [f32x8<S>; 4]) -> f32x8<S> {
    let lanes = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0]);
    let mut squared_lengths = f32x8::splat(simd, 0.0);
    for k in 0..4 {
        let squares = eight[k] * eight[k];
        // The squares with the lanes of each half rotated by one, two and three.
        let by_one = simd.slide_within_blocks_f32x8::<1>(squares, squares);
        let by_two = simd.slide_within_blocks_f32x8::<2>(squares, squares);
        let by_three = simd.slide_within_blocks_f32x8::<3>(squares, squares);
        // In each case, lane k of the sum is x² + y² + z².
        let sum = match k {
            0 => squares + by_one + by_two,
            1 => by_three + squares + by_one,
            2 => by_two + by_three + squares,
            _ => by_one + by_two + by_three,
        };
        squared_lengths = lanes.simd_eq(k as f32).select(sum, squared_lengths);
    }
    squared_lengths
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::simd::level;

    #[test]
    fn broadcast_squared_lengths_agree_with_scalar_code() {
        let points: [Xyzx; 8] = std::array::from_fn(|k| xyzx([1.0, 2.0, 3.0].map(|x| x + 10.0 * k as f32)));
        let pairs: &[Pair] = points.as_flattened().as_chunks().0;
        let (mut squared, mut broadcast) = ([0.0; 8], [[0.0; 8]; 4]);
        dispatch!(level(), simd => {
            let pair = |k: usize| f32x8::load_array_ref(simd, &pairs[k]);
            let squared_lengths = squared_lengths(simd, [pair(0), pair(1), pair(2), pair(3)]);
            squared_lengths.store_array(&mut squared);
            store(broadcast_lanes(simd, squared_lengths), &mut broadcast);
        });
        for (k, point) in points.iter().enumerate() {
            let expected = point[..3].iter().map(|x| x * x).sum();
            assert_eq!(squared[4 * (k % 2) + k / 2], expected);
            assert_eq!(broadcast.as_flattened()[4 * k..][..4], [expected; 4]);
        }
    }
}
