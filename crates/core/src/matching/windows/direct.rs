//! Computes the sums of wide windows directly, vertex by vertex: in thin shapes, and where running sums restart.

use fearless_simd::{Simd, f32x8};

use super::terms::Terms;
use crate::lattice::AxisLinks;
use crate::simd::lanes::{between, bits_between};

/// Computes the window sums of a block. `row(block, c)` is component `c` of the eight vertices of a block.
///
/// Two offsets at a time are added: for an odd one the vertices halfway between two blocks ([`between`]), for an even
/// one a block.
#[inline(always)]
pub(super) fn sums<S: Simd, T: Terms<S>, const AXIS: usize>(
    simd: S,
    axis: &AxisLinks,
    half_width: usize,
    block: usize,
    row: &impl Fn(usize, usize) -> f32x8<S>,
) -> T {
    let mut sums = T::center(
        simd,
        #[inline(always)]
        |c| row(block, c),
    );
    // `linked` has the lanes whose windows contain the vertices at the offset.
    let (mut linked, mut current) = (axis.links[block], block);
    for offset in (1..=half_width).step_by(2) {
        if linked == 0 {
            break;
        }
        let next = axis.next(current);
        sums.add(
            simd,
            linked,
            offset as f32,
            #[inline(always)]
            |c| between::<S, AXIS>(simd, row(current, c), row(next, c)),
        );
        linked &= bits_between(AXIS, axis.links[current], axis.links[next]);
        if offset == half_width {
            break;
        }
        sums.add(
            simd,
            linked,
            (offset + 1) as f32,
            #[inline(always)]
            |c| row(next, c),
        );
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
        sums.add(
            simd,
            linked,
            -(offset as f32),
            #[inline(always)]
            |c| between::<S, AXIS>(simd, row(previous, c), row(current, c)),
        );
        if offset == half_width {
            break;
        }
        linked &= links;
        sums.add(
            simd,
            linked,
            -((offset + 1) as f32),
            #[inline(always)]
            |c| row(previous, c),
        );
        current = previous;
    }
    sums
}
