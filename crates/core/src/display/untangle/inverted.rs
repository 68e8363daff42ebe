//! Finds out whether cells of a deformed lattice may be inside out, from the links alone.

use fearless_simd::{Simd, SimdBase, SimdMask, dispatch, f32x8};

use crate::lattice::Layout;
use crate::simd::lanes::{Block, Lanes, between, bits_between, load};
use crate::simd::level;
use crate::simd::vector::{cross, dot};

/// Determinant up to which a cell may be inside out. It is above the rounding errors of the determinants of edges with
/// lengths of up to 3 cells.
const DOUBTFUL: f32 = 1e-5;

/// Returns whether three links at a vertex, one along each axis, have a determinant of at most [`DOUBTFUL`].
/// `positions`: the positions of the vertices in cells, in the first three rows of each block.
///
/// The result is true if a determinant at a corner of a cell with edges of up to 3 cells is not positive. It can also
/// be true for three links that are not edges of one cell.
pub(in crate::display) fn may_be_inverted<const N: usize>(layout: &Layout, positions: &Lanes<N>) -> bool {
    dispatch!(level(), simd => any_inverted(simd, layout, positions.blocks()))
}

#[inline(always)]
fn any_inverted<S: Simd, const N: usize>(simd: S, layout: &Layout, blocks: &[Block<N>]) -> bool {
    (0..blocks.len()).any(
        #[inline(always)]
        |block| is_inverted(simd, layout, blocks, block),
    )
}

/// Returns whether the determinant of any three links of a vertex of a block is at most [`DOUBTFUL`].
#[inline(always)]
fn is_inverted<S: Simd, const N: usize>(simd: S, layout: &Layout, blocks: &[Block<N>], block: usize) -> bool {
    let links = [
        links_along::<S, N, 0>(simd, layout, blocks, block),
        links_along::<S, N, 1>(simd, layout, blocks, block),
        links_along::<S, N, 2>(simd, layout, blocks, block),
    ];
    let doubtful = f32x8::splat(simd, DOUBTFUL);
    let mut inverted = 0;
    for y in 0..2 {
        for z in 0..2 {
            let area = cross(links[1].edges[y], links[2].edges[z]);
            for x in 0..2 {
                let positive = dot(links[0].edges[x], area).simd_gt(doubtful).to_bitmask() as u8;
                inverted |= !positive & links[0].lanes[x] & links[1].lanes[y] & links[2].lanes[z];
            }
        }
    }
    inverted != 0
}

/// The links of the vertices of a block along an axis: those to the next, then those from the previous vertices.
struct Links<S: Simd> {
    /// The vectors along the links, in the positive direction of the axis.
    edges: [[f32x8<S>; 3]; 2],
    /// Bit masks of the lanes that have these links.
    lanes: [u8; 2],
}

#[inline(always)]
fn links_along<S: Simd, const N: usize, const AXIS: usize>(
    simd: S,
    layout: &Layout,
    blocks: &[Block<N>],
    block: usize,
) -> Links<S> {
    let axis = layout.axis(AXIS);
    let (before, links_before) = axis.previous(block);
    let center: [f32x8<S>; 3] = load(simd, &blocks[block]);
    let (previous, next): ([f32x8<S>; 3], [f32x8<S>; 3]) =
        (load(simd, &blocks[before]), load(simd, &blocks[axis.next(block)]));
    let mut edges = [center; 2];
    for c in 0..3 {
        edges[0][c] = between::<S, AXIS>(simd, center[c], next[c]) - center[c];
        edges[1][c] = center[c] - between::<S, AXIS>(simd, previous[c], center[c]);
    }
    let links = axis.links[block];
    Links { edges, lanes: [links, bits_between(AXIS, links_before, links)] }
}
