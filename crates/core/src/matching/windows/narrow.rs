//! Computes the sums of narrow windows vertex by vertex, with masks that are computed once. There is no early exit at
//! missing links, so that there is no branch to mispredict.

use fearless_simd::{Simd, f32x8};

use super::terms::{PairTerms, Terms};
use crate::lattice::AxisLinks;
use crate::simd::lanes::{between, bits_between};

/// Largest half-width of a narrow window.
pub(super) const NARROW: usize = 5;

/// The narrow windows around the vertices of a block.
#[derive(Clone, Copy, Debug)]
pub(in crate::matching) struct NarrowWindows {
    /// Next block along the axis, or the block itself.
    next: u32,
    /// Previous block along the axis, or the block itself.
    previous: u32,
    /// For the offsets 1, 2, ... the bit masks of the lanes whose windows contain a vertex at the offset.
    after: [u8; NARROW],
    /// The same for the offsets -1, -2, ...
    before: [u8; NARROW],
}

/// Computes the windows of each block along an axis.
pub(super) fn windows(number: usize, axis: &AxisLinks, half_width: usize) -> Vec<NarrowWindows> {
    let windows = |block: usize| NarrowWindows {
        next: axis.next(block) as u32,
        previous: axis.previous(block).0 as u32,
        after: lanes_after(number, axis, half_width, block),
        before: lanes_before(number, axis, half_width, block),
    };
    (0..axis.links.len()).map(windows).collect()
}

fn lanes_after(number: usize, axis: &AxisLinks, half_width: usize, block: usize) -> [u8; NARROW] {
    let (mut lanes, mut linked, mut current) = ([0; NARROW], 0xff, block);
    for (index, lanes) in lanes[..half_width].iter_mut().enumerate() {
        if index % 2 == 0 {
            linked &= axis.links[current];
        } else {
            let next = axis.next(current);
            linked &= bits_between(number, axis.links[current], axis.links[next]);
            current = next;
        }
        *lanes = linked;
    }
    lanes
}

fn lanes_before(number: usize, axis: &AxisLinks, half_width: usize, block: usize) -> [u8; NARROW] {
    let (mut lanes, mut linked, mut current) = ([0; NARROW], 0xff, block);
    for (index, lanes) in lanes[..half_width].iter_mut().enumerate() {
        let (previous, links) = axis.previous(current);
        if index % 2 == 0 {
            linked &= bits_between(number, links, axis.links[current]);
        } else {
            linked &= links;
            current = previous;
        }
        *lanes = linked;
    }
    lanes
}

/// Computes the sums of windows of two vertices, for regions of one cell. The window of a forward pass has the vertex
/// in its place and the next one, the window of an adjoint pass the one before. `windows`: of the half-width 1.
#[inline(always)]
pub(super) fn pair_sums<S: Simd, T: PairTerms<S>, const AXIS: usize>(
    simd: S,
    windows: &[NarrowWindows],
    block: usize,
    row: &impl Fn(usize, usize) -> f32x8<S>,
) -> T {
    let NarrowWindows { next, previous, after, before } = windows[block];
    let (linked, lower, upper, offset) = match T::IS_ADJOINT {
        true => (before[0], previous as usize, block, -0.5),
        false => (after[0], block, next as usize, 0.5),
    };
    let mut sums = T::single(
        simd,
        -offset,
        #[inline(always)]
        |c| row(block, c),
    );
    sums.add(
        simd,
        linked,
        offset,
        #[inline(always)]
        |c| between::<S, AXIS>(simd, row(lower, c), row(upper, c)),
    );
    sums
}

/// Computes the window sums of a block. `row(block, c)` is component `c` of the eight vertices of a block.
///
/// The vertices at an odd offset are halfway between two blocks ([`between`]), and those at an even offset are a block.
#[inline(always)]
pub(super) fn sums<S: Simd, T: Terms<S>, const AXIS: usize>(
    simd: S,
    windows: &[NarrowWindows],
    half_width: usize,
    block: usize,
    row: &impl Fn(usize, usize) -> f32x8<S>,
) -> T {
    let mut sums = T::center(
        simd,
        #[inline(always)]
        |c| row(block, c),
    );
    let NarrowWindows { after, before, .. } = windows[block];
    let (mut current, mut index) = (block, 0);
    while index < half_width {
        let next = windows[current].next as usize;
        sums.add(
            simd,
            after[index],
            (index + 1) as f32,
            #[inline(always)]
            |c| between::<S, AXIS>(simd, row(current, c), row(next, c)),
        );
        if index + 1 < half_width {
            sums.add(
                simd,
                after[index + 1],
                (index + 2) as f32,
                #[inline(always)]
                |c| row(next, c),
            );
        }
        (current, index) = (next, index + 2);
    }
    let (mut current, mut index) = (block, 0);
    while index < half_width {
        let previous = windows[current].previous as usize;
        sums.add(
            simd,
            before[index],
            -((index + 1) as f32),
            #[inline(always)]
            |c| between::<S, AXIS>(simd, row(previous, c), row(current, c)),
        );
        if index + 1 < half_width {
            sums.add(
                simd,
                before[index + 1],
                -((index + 2) as f32),
                #[inline(always)]
                |c| row(previous, c),
            );
        }
        (current, index) = (previous, index + 2);
    }
    sums
}
