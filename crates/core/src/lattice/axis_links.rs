//! The links between the vertices of blocks, along one axis.

use super::Lattice;
use super::blocks::BlockKey;
use crate::simd::lanes::{LOWER, block_and_lane, lane_stride, slot_of};
use crate::voxel::step;

/// The links along one axis.
#[derive(Clone, Debug)]
pub(crate) struct AxisLinks {
    /// Number of the axis: 0, 1 or 2.
    pub number: usize,
    /// Bit `l` of the entry of a block is set iff the vertex in lane `l` is linked to the next vertex along
    /// the axis.
    pub links: Vec<u8>,
    /// Next block along the axis, or the block itself if there is no next block.
    next: Vec<u32>,
    /// Previous block along the axis, or the block itself if there is no previous block.
    previous: Vec<u32>,
}

impl AxisLinks {
    /// Finds the neighbors of blocks along an axis. `keys`: the sorted keys of the blocks.
    pub(super) fn new(axis: usize, links: Vec<u8>, keys: &[BlockKey]) -> Self {
        let mut next: Vec<u32> = (0..keys.len() as u32).collect();
        let mut previous = next.clone();
        // Index of the first key that is not less than `target`. It never decreases, because the keys are
        // sorted and `target` increases with `key`.
        let mut at = 0;
        for (block, key) in keys.iter().enumerate() {
            let target = step(*key, axis, 1);
            while at < keys.len() && keys[at] < target {
                at += 1;
            }
            if keys.get(at) == Some(&target) {
                next[block] = at as u32;
                previous[at] = block as u32;
            }
        }
        Self { number: axis, links, next, previous }
    }

    /// Finds the links and the neighbors of blocks along an axis from the links of a lattice whose links join each
    /// block to one next block at most. `slots`: the slot of each vertex; `blocks`: the number of blocks.
    pub(super) fn of_slots(axis: usize, lattice: &Lattice, (slots, blocks): (&[u32], usize)) -> Self {
        let mut next: Vec<u32> = (0..blocks as u32).collect();
        let mut previous = next.clone();
        let mut links = vec![0; blocks];
        for (vertex, &slot) in (0..).zip(slots) {
            let Some(other) = lattice.neighbors(vertex)[2 * axis + 1] else { continue };
            let ((block, lane), (other, _)) = (block_and_lane(slot), block_and_lane(slots[other as usize]));
            links[block] |= 1 << lane;
            if other != block {
                next[block] = other as u32;
                previous[other] = block as u32;
            }
        }
        Self { number: axis, links, next, previous }
    }

    /// Returns the next block along the axis, or the block itself if there is no next block.
    #[inline(always)]
    pub(crate) fn next(&self, block: usize) -> usize {
        self.next[block] as usize
    }

    /// Returns the previous block along the axis and the bit mask of its lanes that are linked to their next vertices.
    /// If there is no previous block, it is the block itself, and no lane is linked.
    #[inline(always)]
    pub(crate) fn previous(&self, block: usize) -> (usize, u8) {
        let previous = self.previous[block] as usize;
        (previous, if previous == block { 0 } else { self.links[previous] })
    }

    /// Returns the slot of the next vertex along the axis, if the vertex is linked to it.
    pub(crate) fn next_slot(&self, slot: u32) -> Option<u32> {
        let ((block, lane), stride) = (block_and_lane(slot), lane_stride(self.number));
        let is_lower = LOWER[self.number] >> lane & 1 != 0;
        (self.links[block] >> lane & 1 != 0)
            .then(|| if is_lower { (block, lane + stride) } else { (self.next(block), lane - stride) })
            .map(slot_of)
    }

    /// Returns the slot of the previous vertex along the axis, if it is linked to the vertex.
    pub(crate) fn previous_slot(&self, slot: u32) -> Option<u32> {
        let ((block, lane), stride) = (block_and_lane(slot), lane_stride(self.number));
        let (block, links, lane) = if LOWER[self.number] >> lane & 1 == 0 {
            (block, self.links[block], lane - stride)
        } else {
            let (previous, links) = self.previous(block);
            (previous, links, lane + stride)
        };
        (links >> lane & 1 != 0).then_some(slot_of((block, lane)))
    }

    /// Returns the memory of the links, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.links.len() + size_of_val(self.next.as_slice()) + size_of_val(self.previous.as_slice())
    }
}
