//! The blocks of 2 × 2 × 2 vertices to which grid indices belong: see `layout`.

use crate::simd::lanes::{LANES, lane_stride};

/// Grid index of a block: that of its vertex in lane 0, plus the offset, divided by two. Blocks are stored in the order
/// of their keys.
pub(super) type BlockKey = [i32; 3];

/// Returns the block and the lane of the vertex at a grid index.
pub(super) fn block_and_lane(offset: [i32; 3], index: [i32; 3]) -> (BlockKey, usize) {
    let (mut key, mut lane) = ([0; 3], 0);
    for axis in 0..3 {
        let shifted = index[axis] + offset[axis];
        key[axis] = shifted.div_euclid(2);
        lane += lane_stride(axis) * shifted.rem_euclid(2) as usize;
    }
    (key, lane)
}

/// Returns the offset with the fewest blocks, the first one if several have equally many, and the keys of the blocks.
pub(super) fn fewest_blocks(indices: &[[i32; 3]]) -> ([i32; 3], Vec<BlockKey>) {
    // The occupied lanes of each block without an offset. The blocks of the other offsets follow from them.
    let mut unshifted: Vec<_> = indices
        .iter()
        .map(|&index| block_and_lane([0; 3], index))
        .map(|(key, lane)| (key, lane as u8))
        .collect();
    unshifted.sort_unstable();
    let mut best = ([0; 3], blocks_with_offset([0; 3], &unshifted));
    for number in 1..LANES as i32 {
        let offset = [number >> 2, number >> 1 & 1, number & 1];
        let keys = blocks_with_offset(offset, &unshifted);
        if keys.len() < best.1.len() {
            best = (offset, keys);
        }
    }
    best
}

/// Returns the keys of the blocks with an offset, sorted. `unshifted`: the block and the lane of each vertex without an
/// offset, sorted.
fn blocks_with_offset(offset: [i32; 3], unshifted: &[(BlockKey, u8)]) -> Vec<BlockKey> {
    let mut keys: Vec<BlockKey> = Vec::with_capacity(unshifted.len() / 4);
    for block in unshifted.chunk_by(|a, b| a.0 == b.0) {
        let first = keys.len();
        for &(key, lane) in block {
            // An offset moves the vertices with an odd coordinate to the next block.
            let moved = std::array::from_fn(|axis| {
                key[axis] + (offset[axis] & (i32::from(lane) / lane_stride(axis) as i32))
            });
            if !keys[first..].contains(&moved) {
                keys.push(moved);
            }
        }
    }
    keys.sort_unstable();
    keys.dedup();
    keys
}
