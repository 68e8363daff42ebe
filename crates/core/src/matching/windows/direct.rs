//! Direct window sums: narrow windows, summed vertex by vertex.

use fearless_simd::{Simd, f32x8};

use super::NARROW_ACROSS;
use super::terms::Terms;
use crate::lattice::Neighbors;
use crate::simd::lanes::LANES;

/// Sums the windows of a block along an axis across the lanes.
#[inline(always)]
pub(super) fn across<S: Simd, T: Terms<S>>(
    simd: S,
    links: &[u8],
    neighbors: &Neighbors,
    half_width: usize,
    block: usize,
    row: &impl Fn(usize, usize) -> f32x8<S>,
) -> T {
    let mut sums = T::center(
        simd,
        #[inline(always)]
        |c| row(block, c),
    );
    // Narrow windows have no early exit, so that there is no branch to mispredict.
    let has_early_exit = half_width > NARROW_ACROSS;
    let (mut linked, mut at) = (0xff, block);
    for offset in 1..=half_width {
        linked &= links[at];
        if has_early_exit && linked == 0 {
            break;
        }
        at = neighbors.next[at] as usize;
        sums.add(
            simd,
            linked,
            offset as f32,
            #[inline(always)]
            |c| row(at, c),
        );
    }
    let (mut linked, mut at) = (0xff, block);
    for offset in 1..=half_width {
        let before = neighbors.previous[at] as usize;
        let has_previous = u8::from(before != at).wrapping_neg();
        linked &= links[before] & has_previous;
        if has_early_exit && linked == 0 {
            break;
        }
        at = before;
        sums.add(
            simd,
            linked,
            -(offset as f32),
            #[inline(always)]
            |c| row(at, c),
        );
    }
    sums
}

/// Sums the windows of half-width 1 to 5 of a block along the lanes.
#[inline(always)]
pub(super) fn along<S: Simd, T: Terms<S>>(
    simd: S,
    links: &[u8],
    half_width: usize,
    block: usize,
    row: &impl Fn(usize, usize) -> f32x8<S>,
) -> T {
    let mut sums = T::center(
        simd,
        #[inline(always)]
        |c| row(block, c),
    );
    let here = links[block];
    // A link from the last lane leads to the next block in storage. Without such a link, `after` is the block
    // itself and its values are masked.
    let after = if here >> (LANES - 1) == 0 { block } else { block + 1 };
    let line = u32::from(here) | u32::from(links[after]) << LANES;
    let line = if after == block { u32::from(here) } else { line };
    let mut linked = 0xff;
    macro_rules! add_after {
        ($($shift:literal)*) => {$(
            if half_width >= $shift {
                linked &= line >> ($shift - 1);
                sums.add(
                    simd,
                    linked as u8,
                    $shift as f32,
                    #[inline(always)]
                    |c| simd.slide_f32x8::<$shift>(row(block, c), row(after, c)),
                );
            }
        )*};
    }
    add_after!(1 2 3 4 5);

    let has_previous = block > 0 && links[block - 1] >> (LANES - 1) != 0;
    let (before, earlier) = if has_previous { (block - 1, links[block - 1]) } else { (block, 0) };
    let line = u32::from(earlier) | u32::from(here) << LANES;
    let mut linked = 0xff;
    macro_rules! add_before {
        ($($shift:literal $slide:literal)*) => {$(
            if half_width >= $shift {
                linked &= line >> (LANES - $shift);
                sums.add(
                    simd,
                    linked as u8,
                    -($shift as f32),
                    #[inline(always)]
                    |c| simd.slide_f32x8::<$slide>(row(before, c), row(block, c)),
                );
            }
        )*};
    }
    add_before!(1 7 2 6 3 5 4 4 5 3);
    sums
}
