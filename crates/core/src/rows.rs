//! Points as rows of four numbers, `(x, y, z, x)`, for kernels that take points one by one.
//!
//! A row is one load. Turned by one lane its first three lanes are `(y, z, x)`, which a cross product takes.

use fearless_simd::{Select, Simd, SimdBase, f32x8, u8x32};

/// A point, or what is linear in points: `(x, y, z, x)`.
pub(crate) type Row = [f32; 4];

/// Two rows in a register.
pub(crate) type Pair = [f32; 8];

/// Eight rows, two in each register.
pub(crate) type EightRows = [Pair; 4];

/// The row of a point.
#[inline(always)]
pub(crate) fn row([x, y, z]: [f32; 3]) -> Row {
    [x, y, z, x]
}

/// Each of two rows turned by one lane: `(y, z, x, x)`.
#[inline(always)]
pub(crate) fn turned<S: Simd>(simd: S, rows: f32x8<S>) -> f32x8<S> {
    simd.slide_within_blocks_f32x8::<1>(rows, rows)
}

/// Each number of two rows to all four lanes of its row: first those of lane 0, then those of lane 1, and so on.
#[inline(always)]
pub(crate) fn spread<S: Simd>(simd: S, rows: f32x8<S>) -> [f32x8<S>; 4] {
    let mut spread = [rows; 4];
    for lane in 0..4 {
        let mut bytes = [0; 32];
        for i in 0..32 {
            bytes[i] = (4 * lane + i % 4) as u8;
        }
        spread[lane] = simd.swizzle_dyn_within_blocks_f32x8(rows, u8x32::load_array(simd, bytes));
    }
    spread
}

/// The square of the length of the first three numbers of each row: of the rows of register `k` in lane `k` of each
/// half.
#[inline(always)]
pub(crate) fn squares<S: Simd>(simd: S, rows: [f32x8<S>; 4]) -> f32x8<S> {
    let lanes = f32x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0]);
    let mut squares = f32x8::splat(simd, 0.0);
    for k in 0..4 {
        let t = rows[k] * rows[k];
        let once = simd.slide_within_blocks_f32x8::<1>(t, t);
        let twice = simd.slide_within_blocks_f32x8::<2>(t, t);
        let thrice = simd.slide_within_blocks_f32x8::<3>(t, t);
        // Each puts the three numbers that count into lane k.
        let sum = match k {
            0 => t + once + twice,
            1 => thrice + t + once,
            2 => twice + thrice + t,
            _ => once + twice + thrice,
        };
        squares = lanes.simd_eq(k as f32).select(sum, squares);
    }
    squares
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::lanes::{load, store};
    use crate::parallel::level;

    #[test]
    fn squares_of_lengths_and_back() {
        let rows: [Row; 8] = std::array::from_fn(|k| row([1.0, 2.0, 3.0].map(|x| x + 10.0 * k as f32)));
        let pairs: &EightRows = rows.as_flattened().as_chunks().0.as_array().unwrap();
        let (mut squared, mut back) = ([[0.0; 8]; 1], [[0.0; 8]; 4]);
        dispatch!(level(), simd => {
            let squares = squares(simd, load(simd, pairs));
            store([squares], &mut squared);
            store(spread(simd, squares), &mut back);
        });
        for (k, row) in rows.iter().enumerate() {
            let expected = row[..3].iter().map(|x| x * x).sum();
            assert_eq!(squared[0][4 * (k % 2) + k / 2], expected);
            assert_eq!(back.as_flattened()[4 * k..][..4], [expected; 4]);
        }
    }
}
