//! Computes window sums directly, vertex by vertex: for narrow windows, for wide windows of thin shapes
//! across the lanes, and where running sums restart.

use fearless_simd::{Simd, f32x8};

use super::NARROW_ACROSS;
use super::terms::Terms;
use crate::lattice::Neighbors;
use crate::simd::lanes::LANES;

/// Computes the window sums of a block for an axis across the lanes. `links` has, for each block, the bit
/// mask of the lanes that are linked to the next vertex on the axis. `row(block, c)` is component `c` of the
/// eight vertices of a block.
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
    // Sums of narrow windows have no early exit, so that there is no branch to mispredict.
    let has_early_exit = half_width > NARROW_ACROSS;
    let (mut linked, mut current) = (0xff, block);
    for offset in 1..=half_width {
        linked &= links[current];
        if has_early_exit && linked == 0 {
            break;
        }
        current = neighbors.next[current] as usize;
        sums.add(
            simd,
            linked,
            offset as f32,
            #[inline(always)]
            |c| row(current, c),
        );
    }
    let (mut linked, mut current) = (0xff, block);
    for offset in 1..=half_width {
        let before = neighbors.previous[current] as usize;
        // All lanes if there is a previous block, else no lane.
        let has_previous = u8::from(before != current).wrapping_neg();
        linked &= links[before] & has_previous;
        if has_early_exit && linked == 0 {
            break;
        }
        current = before;
        sums.add(
            simd,
            linked,
            -(offset as f32),
            #[inline(always)]
            |c| row(current, c),
        );
    }
    sums
}

/// Computes the window sums of a block for the axis along the lanes, with a half-width from 1 to 5. `links`
/// has, for each block, the bit mask of the lanes that are linked to the next vertex in storage.
/// `row(block, c)` is component `c` of the eight vertices of a block.
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
    let links_here = links[block];
    // A link of the last lane leads to the next block in storage. Without such a link, `after` is this block,
    // and the mask `linked` excludes its values.
    let after = if links_here >> (LANES - 1) == 0 { block } else { block + 1 };
    // Links of the 16 vertices of this block and the next block.
    let line_links = u32::from(links_here) | u32::from(links[after]) << LANES;
    let line_links = if after == block { u32::from(links_here) } else { line_links };
    let mut linked = 0xff;
    macro_rules! add_after {
        ($($shift:literal)*) => {$(
            if half_width >= $shift {
                linked &= line_links >> ($shift - 1);
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
    let (before, links_before) = if has_previous { (block - 1, links[block - 1]) } else { (block, 0) };
    // Links of the 16 vertices of the previous block and this block.
    let line_links = u32::from(links_before) | u32::from(links_here) << LANES;
    let mut linked = 0xff;
    macro_rules! add_before {
        ($($shift:literal $slide:literal)*) => {$(
            if half_width >= $shift {
                linked &= line_links >> (LANES - $shift);
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
    // Pairs of an offset and 8 minus this offset.
    add_before!(1 7 2 6 3 5 4 4 5 3);
    sums
}
