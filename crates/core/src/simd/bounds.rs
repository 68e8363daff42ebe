//! Bounds of the numbers of all lattice vertices.

use fearless_simd::{Select, Simd, SimdBase, SimdMask, dispatch, f32x8, mask32x8};

use super::lanes::{Lanes, load};
use super::level;

/// Returns the least and the greatest value of each number over all lattice vertices; infinity and minus infinity if
/// there is none. `occupied` has, for each block, the bit mask of the lanes with a vertex.
pub(crate) fn bounds<const N: usize>(lanes: &Lanes<N>, occupied: &[u8]) -> ([f32; N], [f32; N]) {
    dispatch!(level(), simd => bounds_of::<_, N, false>(simd, lanes, lanes, occupied))
}

/// Returns the least and the greatest difference of each number from that of `other`, which has as many blocks.
pub(crate) fn difference_bounds<const N: usize>(
    lanes: &Lanes<N>,
    other: &Lanes<N>,
    occupied: &[u8],
) -> ([f32; N], [f32; N]) {
    dispatch!(level(), simd => bounds_of::<_, N, true>(simd, lanes, other, occupied))
}

#[inline(always)]
fn bounds_of<S: Simd, const N: usize, const IS_DIFFERENCE: bool>(
    simd: S,
    lanes: &Lanes<N>,
    other: &Lanes<N>,
    occupied: &[u8],
) -> ([f32; N], [f32; N]) {
    let (far, near) = (f32x8::splat(simd, f32::INFINITY), f32x8::splat(simd, f32::NEG_INFINITY));
    let (mut low, mut high) = ([far; N], [near; N]);
    for ((block, other), &mask) in lanes.blocks().iter().zip(other.blocks()).zip(occupied) {
        let mut values: [f32x8<S>; N] = load(simd, block);
        if IS_DIFFERENCE {
            let others: [f32x8<S>; N] = load(simd, other);
            for c in 0..N {
                values[c] -= others[c];
            }
        }
        if mask == u8::MAX {
            for c in 0..N {
                low[c] = low[c].min(values[c]);
                high[c] = high[c].max(values[c]);
            }
        } else {
            let mask = mask32x8::from_bitmask(simd, u64::from(mask));
            for c in 0..N {
                low[c] = low[c].min(mask.select(values[c], far));
                high[c] = high[c].max(mask.select(values[c], near));
            }
        }
    }
    let (mut least, mut greatest) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N]);
    for c in 0..N {
        for value in low[c].to_array() {
            least[c] = least[c].min(value);
        }
        for value in high[c].to_array() {
            greatest[c] = greatest[c].max(value);
        }
    }
    (least, greatest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_leave_out_lanes_without_a_vertex() {
        let (mut lanes, mut other) = (Lanes::<2>::zeros(2), Lanes::<2>::zeros(2));
        for slot in 0..16 {
            lanes.set(slot, [slot as f32, 3.0]);
            other.set(slot, [2.0 * slot as f32, 3.5]);
        }
        assert_eq!(difference_bounds(&lanes, &other, &[0xff; 2]), ([-15.0, -0.5], [0.0, -0.5]));
        assert_eq!(difference_bounds(&lanes, &other, &[0xfc, 0x7f]), ([-14.0, -0.5], [-2.0, -0.5]));
    }

    #[test]
    fn bounds_leave_out_lanes_without_a_vertex() {
        let mut lanes = Lanes::<2>::zeros(3);
        for slot in 0..24 {
            lanes.set(slot, [5.0 + slot as f32, -(slot as f32)]);
        }
        assert_eq!(bounds(&lanes, &[0xff; 3]), ([5.0, -23.0], [28.0, 0.0]));
        assert_eq!(bounds(&lanes, &[0xfe, 0xff, 0x7f]), ([6.0, -22.0], [27.0, -1.0]));
        let (low, high) = bounds(&lanes, &[0, 0, 0]);
        assert!(low[0] == f32::INFINITY && high[0] == f32::NEG_INFINITY);
    }
}
