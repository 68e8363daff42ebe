//! The blocks of 2 × 2 × 2 vertices to which grid indices belong: see `layout`.

use std::ops::Range;

use crate::simd::lanes::{LANES, lane_stride};
use crate::voxel::GridSet;

/// Grid index of a block: the index of its vertex in lane 0, plus the offset, divided by two. Blocks are stored in
/// the order of their keys.
pub(super) type BlockKey = [i32; 3];

/// Returns the block and the lane of the vertex at a grid index.
pub(super) fn key_and_lane(offset: [i32; 3], index: [i32; 3]) -> (BlockKey, usize) {
    let (mut key, mut lane) = ([0; 3], 0);
    for axis in 0..3 {
        let shifted = index[axis] + offset[axis];
        key[axis] = shifted.div_euclid(2);
        lane += lane_stride(axis) * shifted.rem_euclid(2) as usize;
    }
    (key, lane)
}

/// Returns the offset with the fewest blocks, the first one if several have equally many.
pub(super) fn fewest_blocks(vertices: &GridSet) -> [i32; 3] {
    let offsets = (0..LANES as i32).map(|number| [number >> 2, number >> 1 & 1, number & 1]);
    let count = |offset: &[i32; 3]| {
        let mut count = 0;
        visit_blocks(vertices, *offset, |x, _| count += x.len());
        count
    };
    offsets.min_by_key(count).unwrap_or_default()
}

/// Returns the keys of the blocks with an offset, sorted.
pub(super) fn block_keys(vertices: &GridSet, offset: [i32; 3]) -> Vec<BlockKey> {
    let mut keys = Vec::with_capacity(vertices.len() / 4);
    visit_blocks(vertices, offset, |x, [y, z]| keys.extend(x.map(|x| [x, y, z])));
    keys.sort_unstable();
    keys
}

/// Calls `visit` with ranges of blocks along x and their y and z in the grid of blocks. Each block is visited once.
fn visit_blocks(vertices: &GridSet, offset: [i32; 3], mut visit: impl FnMut(Range<i32>, [i32; 2])) {
    let half = |axis: usize, index: i32| (index + offset[axis]).div_euclid(2);
    let mut rows: Vec<([i32; 2], usize)> = (0..vertices.row_count())
        .map(|row| {
            let (z, y) = vertices.row_key(row);
            ([half(1, y), half(2, z)], row)
        })
        .collect();
    rows.sort_unstable();
    let mut spans = Vec::new();
    // At most four rows of vertices share a row of blocks.
    for rows in rows.chunk_by(|a, b| a.0 == b.0) {
        spans.clear();
        for span in rows.iter().flat_map(|(_, row)| vertices.row_runs(*row)).map(|run| vertices.span(run)) {
            spans.push((half(0, span.start), half(0, span.end - 1) + 1));
        }
        spans.sort_unstable();
        let mut end = i32::MIN;
        for &(start, next_end) in &spans {
            if next_end > end {
                visit(start.max(end)..next_end, rows[0].0);
                end = next_end;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::mesh::testing::Random;

    #[test]
    fn blocks_are_those_of_the_vertices_one_by_one() {
        let mut random = Random(3);
        let mut index = |n: usize| random.below(n) as i32 - n as i32 / 2;
        for count in [1, 10, 100, 400] {
            let indices: Vec<[i32; 3]> = (0..count).map(|_| [index(13), index(7), index(6)]).collect();
            let vertices = GridSet::new(indices.clone());
            let mut counts = Vec::new();
            for number in 0..8 {
                let offset = [number >> 2, number >> 1 & 1, number & 1];
                let blocks: BTreeSet<BlockKey> =
                    indices.iter().map(|&index| key_and_lane(offset, index).0).collect();
                assert_eq!(block_keys(&vertices, offset), blocks.into_iter().collect::<Vec<_>>());
                counts.push((block_keys(&vertices, offset).len(), offset));
            }
            let fewest = counts.iter().map(|(count, _)| *count).min();
            let first = counts.iter().find(|(count, _)| Some(*count) == fewest).map(|(_, offset)| *offset);
            assert_eq!(Some(fewest_blocks(&vertices)), first);
        }
    }
}
