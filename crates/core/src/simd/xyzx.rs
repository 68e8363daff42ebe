//! Points as four numbers `(x, y, z, x)`, for kernels that load points one by one.
//!
//! Such a point takes one load. Rotated by one lane, its first three lanes are `(y, z, x)`, as a cross
//! product needs.

use fearless_simd::{Select, Simd, SimdBase, f32x8, u8x32};

/// A point or vector `(x, y, z, x)`.
pub(crate) type Xyzx = [f32; 4];

/// Two points, for one register.
pub(crate) type Pair = [f32; 8];

/// Eight points, two for each register.
pub(crate) type Eight = [Pair; 4];

/// Converts a point to `(x, y, z, x)`.
#[inline(always)]
pub(crate) fn xyzx([x, y, z]: [f32; 3]) -> Xyzx {
    [x, y, z, x]
}

/// Rotates each of two points by one lane, to `(y, z, x, x)`.
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

/// Broadcasts each number of two points: in register `k` of the result, lane `k` of each point is in all four
/// lanes of its half.
#[inline(always)]
pub(crate) fn broadcast_lanes<S: Simd>(simd: S, pair: f32x8<S>) -> [f32x8<S>; 4] {
    let mut broadcast_lanes = [pair; 4];
    for lane in 0..4 {
        let mut bytes = [0; 32];
        for i in 0..32 {
            bytes[i] = (4 * lane + i % 4) as u8;
        }
        broadcast_lanes[lane] = simd.swizzle_dyn_within_blocks_f32x8(pair, u8x32::load_array(simd, bytes));
    }
    broadcast_lanes
}

/// Computes the squared lengths of eight points. The results of the two points of register `k` are in lane
/// `k` of each half.
#[inline(always)]
pub(crate) fn squared_lengths<S: Simd>(simd: S, eight: [f32x8<S>; 4]) -> f32x8<S> {
    let lanes = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0]);
    let mut squared_lengths = f32x8::splat(simd, 0.0);
    for k in 0..4 {
        let t = eight[k] * eight[k];
        let once = simd.slide_within_blocks_f32x8::<1>(t, t);
        let twice = simd.slide_within_blocks_f32x8::<2>(t, t);
        let thrice = simd.slide_within_blocks_f32x8::<3>(t, t);
        // In each case lane k receives the squares of x, y and z.
        let sum = match k {
            0 => t + once + twice,
            1 => thrice + t + once,
            2 => twice + thrice + t,
            _ => once + twice + thrice,
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
    fn squares_and_spread_agree_with_scalar_squared_lengths() {
        let points: [Xyzx; 8] = std::array::from_fn(|k| xyzx([1.0, 2.0, 3.0].map(|x| x + 10.0 * k as f32)));
        let pairs: &[Pair] = points.as_flattened().as_chunks().0;
        let (mut squared, mut back) = ([0.0; 8], [[0.0; 8]; 4]);
        dispatch!(level(), simd => {
            let pair = |k: usize| f32x8::load_array_ref(simd, &pairs[k]);
            let squared_lengths = squared_lengths(simd, [pair(0), pair(1), pair(2), pair(3)]);
            squared_lengths.store_array(&mut squared);
            store(broadcast_lanes(simd, squared_lengths), &mut back);
        });
        for (k, point) in points.iter().enumerate() {
            let expected = point[..3].iter().map(|x| x * x).sum();
            assert_eq!(squared[4 * (k % 2) + k / 2], expected);
            assert_eq!(back.as_flattened()[4 * k..][..4], [expected; 4]);
        }
    }
}
