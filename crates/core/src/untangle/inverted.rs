//! Finds out whether cells of a deformed lattice may be inside out, from the links alone.

use fearless_simd::{Simd, SimdBase, SimdMask, dispatch, f32x8};

use crate::lattice::Layout;
use crate::simd::lanes::{Block, LANES, Lanes, load};
use crate::simd::level;
use crate::simd::vector::{cross, dot_fused};

/// Determinant up to which a cell may be inside out. It is above the rounding errors of the determinants of edges with lengths
/// of up to 3 cells.
const DOUBTFUL: f32 = 1e-5;

/// Returns whether three links at a vertex, one along each axis, have a determinant of at most [`DOUBTFUL`]. `positions`: the
/// positions of the vertices in cells, in the first three rows of each block.
///
/// The result is true if a determinant at a corner of a cell with edges of up to 3 cells is not positive. It can also be true for three links that are not
/// edges of one cell.
pub(crate) fn may_be_inverted<const N: usize>(layout: &Layout, positions: &Lanes<N>) -> bool {
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
    let center: [f32x8<S>; 3] = load(simd, &blocks[block]);
    // The differences along each axis, both in its positive direction: to the next and from the previous vertex.
    let mut edges = [[center; 2]; 3];
    // Bit masks of the lanes that have these links.
    let mut linked = [[0_u8; 2]; 3];
    for axis in 0..3 {
        let links = &layout.axis(axis).links;
        let (next, previous);
        if let Some(neighbors) = &layout.axis(axis).across {
            let [after, before] = [neighbors.next[block] as usize, neighbors.previous[block] as usize];
            (next, previous) = (load(simd, &blocks[after]), load(simd, &blocks[before]));
            linked[axis] = [links[block], if before == block { 0 } else { links[before] }];
        } else {
            let last = LANES - 1;
            let has_previous = block > 0 && links[block - 1] >> last != 0;
            let after = block + usize::from(links[block] >> last);
            let before = block - usize::from(has_previous);
            let rows: [[f32x8<S>; 3]; 2] = [load(simd, &blocks[after]), load(simd, &blocks[before])];
            let mut moved = [center; 2];
            for c in 0..3 {
                moved[0][c] = simd.slide_f32x8::<1>(center[c], rows[0][c]);
                moved[1][c] = simd.slide_f32x8::<7>(rows[1][c], center[c]);
            }
            [next, previous] = moved;
            linked[axis] = [links[block], links[block] << 1 | u8::from(has_previous)];
        }
        for c in 0..3 {
            edges[axis][0][c] = next[c] - center[c];
            edges[axis][1][c] = center[c] - previous[c];
        }
    }
    let doubtful = f32x8::splat(simd, DOUBTFUL);
    let mut inverted = 0;
    for y in 0..2 {
        for z in 0..2 {
            let area = cross(edges[1][y], edges[2][z]);
            for x in 0..2 {
                let positive = dot_fused(edges[0][x], area).simd_gt(doubtful).to_bitmask() as u8;
                inverted |= !positive & linked[0][x] & linked[1][y] & linked[2][z];
            }
        }
    }
    inverted != 0
}
