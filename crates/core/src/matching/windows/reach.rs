//! The vertices at increasing offsets from those of a block, and the lanes in which links lead to them.

use crate::lattice::AxisLinks;
use crate::simd::lanes::bits_between;

/// The vertices at an offset from the vertices of a block: for an even offset those of a block, for an odd one those
/// halfway between two consecutive blocks.
pub(super) struct Reached {
    /// The bit mask of the lanes whose vertices are linked to those of the block.
    pub(super) lanes: u8,
    /// The two blocks of an odd offset; of an even one those of the odd offset before it.
    pub(super) blocks: [usize; 2],
}

/// Iterates over the offsets 1, 2, ... from the vertices of a block.
pub(super) fn after(axis: &AxisLinks, block: usize) -> impl Iterator<Item = Reached> {
    let (mut lanes, mut current) = (0xff, block);
    (1_usize..).map(move |offset| {
        let blocks @ [_, next] = [current, axis.next(current)];
        if offset % 2 == 1 {
            lanes &= axis.links[current];
        } else {
            lanes &= bits_between(axis.number, axis.links[current], axis.links[next]);
            current = next;
        }
        Reached { lanes, blocks }
    })
}

/// Iterates over the offsets -1, -2, ... from the vertices of a block.
pub(super) fn before(axis: &AxisLinks, block: usize) -> impl Iterator<Item = Reached> {
    let (mut lanes, mut current) = (0xff, block);
    (1_usize..).map(move |offset| {
        let (previous, links) = axis.previous(current);
        let blocks = [previous, current];
        if offset % 2 == 1 {
            lanes &= bits_between(axis.number, links, axis.links[current]);
        } else {
            lanes &= links;
            current = previous;
        }
        Reached { lanes, blocks }
    })
}
