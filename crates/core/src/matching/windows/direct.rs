//! Computes the sums of wide windows directly, vertex by vertex: in thin shapes, and where running sums restart.

use fearless_simd::Simd;

use super::rows::{Input, Rows};
use super::terms::Terms;
use crate::lattice::AxisLinks;
use crate::simd::lanes::bits_between;

/// Computes the window sums of a block.
///
/// Two offsets at a time are added: for an odd one the vertices halfway between two blocks, for an even one a block.
#[inline(always)]
pub(super) fn sums<S: Simd, T: Terms<S>, const AXIS: usize, const IN: usize>(
    input: Input<S, impl Rows<IN>, AXIS, IN>,
    axis: &AxisLinks,
    half_width: usize,
    block: usize,
) -> T {
    let simd = input.simd;
    let mut sums = T::center(simd, input.of(block));
    // `linked` has the lanes whose windows contain the vertices at the offset.
    let (mut linked, mut current) = (axis.links[block], block);
    for offset in (1..=half_width).step_by(2) {
        if linked == 0 {
            break;
        }
        let next = axis.next(current);
        sums.add(simd, linked, offset as f32, input.between(current, next));
        linked &= bits_between(AXIS, axis.links[current], axis.links[next]);
        if offset == half_width {
            break;
        }
        sums.add(simd, linked, (offset + 1) as f32, input.of(next));
        linked &= axis.links[next];
        current = next;
    }
    let (mut linked, mut current) = (0xff, block);
    for offset in (1..=half_width).step_by(2) {
        let (previous, links) = axis.previous(current);
        linked &= bits_between(AXIS, links, axis.links[current]);
        if linked == 0 {
            break;
        }
        sums.add(simd, linked, -(offset as f32), input.between(previous, current));
        if offset == half_width {
            break;
        }
        linked &= links;
        sums.add(simd, linked, -((offset + 1) as f32), input.of(previous));
        current = previous;
    }
    sums
}
