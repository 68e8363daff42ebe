//! Computes the sums of narrow windows vertex by vertex, with masks that are computed once. There is no early exit at
//! missing links, so that there is no branch to mispredict.

use fearless_simd::Simd;

use super::reach::{self, Reached};
use super::rows::{Input, Rows};
use super::terms::{PairTerms, Terms};
use crate::lattice::AxisLinks;

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
pub(super) fn windows(axis: &AxisLinks, half_width: usize) -> Vec<NarrowWindows> {
    let windows = |block: usize| NarrowWindows {
        next: axis.next(block) as u32,
        previous: axis.previous(block).0 as u32,
        after: lanes(reach::after(axis, block), half_width),
        before: lanes(reach::before(axis, block), half_width),
    };
    (0..axis.links.len()).map(windows).collect()
}

/// Returns the bit masks of the first `half_width` offsets.
fn lanes(reached: impl Iterator<Item = Reached>, half_width: usize) -> [u8; NARROW] {
    let mut lanes = [0; NARROW];
    lanes[..half_width].iter_mut().zip(reached).for_each(|(lanes, reached)| *lanes = reached.lanes);
    lanes
}

/// Computes the sums of windows of two vertices, for regions of one cell. The window of a forward pass has the vertex
/// in its place and the next one, the window of an adjoint pass the one before. `windows`: of the half-width 1.
#[inline(always)]
pub(super) fn pair_sums<S: Simd, T: PairTerms<S>, const AXIS: usize, const IN: usize>(
    input: Input<S, impl Rows<IN>, AXIS, IN>,
    windows: &[NarrowWindows],
    block: usize,
) -> T {
    let NarrowWindows { next, previous, after, before } = windows[block];
    let (linked, lower, upper, offset) = match T::IS_ADJOINT {
        true => (before[0], previous as usize, block, -0.5),
        false => (after[0], block, next as usize, 0.5),
    };
    let mut sums = T::single(input.simd, -offset, input.of(block));
    sums.add(input.simd, linked, offset, input.between(lower, upper));
    sums
}

/// Computes the window sums of a block.
///
/// The vertices at an odd offset are halfway between two blocks, and those at an even offset are a block.
#[inline(always)]
pub(super) fn sums<S: Simd, T: Terms<S>, const AXIS: usize, const IN: usize>(
    input: Input<S, impl Rows<IN>, AXIS, IN>,
    windows: &[NarrowWindows],
    half_width: usize,
    block: usize,
) -> T {
    let simd = input.simd;
    let mut sums = T::center(simd, input.of(block));
    let NarrowWindows { after, before, .. } = windows[block];
    let (mut current, mut index) = (block, 0);
    while index < half_width {
        let next = windows[current].next as usize;
        sums.add(simd, after[index], (index + 1) as f32, input.between(current, next));
        if index + 1 < half_width {
            sums.add(simd, after[index + 1], (index + 2) as f32, input.of(next));
        }
        (current, index) = (next, index + 2);
    }
    let (mut current, mut index) = (block, 0);
    while index < half_width {
        let previous = windows[current].previous as usize;
        sums.add(simd, before[index], -((index + 1) as f32), input.between(previous, current));
        if index + 1 < half_width {
            sums.add(simd, before[index + 1], -((index + 2) as f32), input.of(previous));
        }
        (current, index) = (previous, index + 2);
    }
    sums
}
