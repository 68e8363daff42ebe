//! Narrow windows, summed vertex by vertex.

use fearless_simd::{Simd, f32x8};

use super::NARROW_ACROSS;
use super::terms::Terms;
use crate::lattice::Neighbours;
use crate::simd::lanes::LANES;

/// The windows of a block along an axis across the lanes.
#[inline(always)]
pub(super) fn across<S: Simd, T: Terms<S>>(
    simd: S,
    links: &[u8],
    neighbours: &Neighbours,
    half_width: usize,
    block: usize,
    row: &impl Fn(usize, usize) -> f32x8<S>,
) -> T {
    let mut sums = T::center(
        simd,
        #[inline(always)]
        |c| row(block, c),
    );
    // Narrow windows go to their ends whatever is linked, so that no branch is there to be guessed.
    let stops = half_width > NARROW_ACROSS;
    let (mut reach, mut at) = (0xff, block);
    for offset in 1..=half_width {
        reach &= links[at];
        if stops && reach == 0 {
            break;
        }
        at = neighbours.next[at] as usize;
        sums.add(
            simd,
            reach,
            offset as f32,
            #[inline(always)]
            |c| row(at, c),
        );
    }
    let (mut reach, mut at) = (0xff, block);
    for offset in 1..=half_width {
        let before = neighbours.previous[at] as usize;
        let any = u8::from(before != at).wrapping_neg();
        reach &= links[before] & any;
        if stops && reach == 0 {
            break;
        }
        at = before;
        sums.add(
            simd,
            reach,
            -(offset as f32),
            #[inline(always)]
            |c| row(at, c),
        );
    }
    sums
}

/// The windows of half-width 1 to 5 of a block along the lanes.
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
    // A link from the last lane leads to the next block in storage; without one the block stands in for it.
    let after = if here >> (LANES - 1) == 0 { block } else { block + 1 };
    let line = u32::from(here) | u32::from(links[after]) << LANES;
    let line = if after == block { u32::from(here) } else { line };
    let mut reach = 0xff;
    macro_rules! add_after {
        ($($shift:literal)*) => {$(
            if half_width >= $shift {
                reach &= line >> ($shift - 1);
                sums.add(
                    simd,
                    reach as u8,
                    $shift as f32,
                    #[inline(always)]
                    |c| simd.slide_f32x8::<$shift>(row(block, c), row(after, c)),
                );
            }
        )*};
    }
    add_after!(1 2 3 4 5);

    let linked = block > 0 && links[block - 1] >> (LANES - 1) != 0;
    let (before, earlier) = if linked { (block - 1, links[block - 1]) } else { (block, 0) };
    let line = u32::from(earlier) | u32::from(here) << LANES;
    let mut reach = 0xff;
    macro_rules! add_before {
        ($($shift:literal $slide:literal)*) => {$(
            if half_width >= $shift {
                reach &= line >> (LANES - $shift);
                sums.add(
                    simd,
                    reach as u8,
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
