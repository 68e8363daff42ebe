//! Assigns lattice vertices to blocks of eight along one axis, the lane axis. Blocks without a vertex are not
//! stored.
//!
//! The *slot* of a vertex is `8 * block + lane`, its index in the storage; see `simd::lanes`. The *inner
//! axis* is the axis other than x and the lane axis.
//!
//! ```text
//! plane  all lines with the same x          planes are stored in the order of x
//! line   blocks along the lane axis         lines of a plane are stored in the order of the inner axis
//! block  lanes 0..8 along the lane axis     blocks of a line are stored in the order of the lane axis
//! ```
//!
//! The moment cascade begins and ends with x, so that all of its other passes stay within a plane. Block
//! boundaries are shifted along the lane axis by an offset. Of the 16 pairs of lane axis (y or z) and offset
//! (0 to 7), the pair with the fewest blocks is used. The order of the axes in the window sums does not
//! depend on this choice.

use std::ops::Range;

use super::Lattice;
use crate::simd::lanes::LANES;

/// The blocks of a lattice, and the links between their vertices.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Slot of each lattice vertex.
    slots: Vec<u32>,
    /// Bit `l` of the entry of a block is set iff lane `l` of the block has a vertex.
    occupied: Vec<u8>,
    /// Links along x, y and z.
    axes: [AxisLinks; 3],
    /// The axis along the lanes: 1 or 2.
    lane_axis: usize,
    /// First block of each line, then the number of blocks.
    lines: Vec<u32>,
    /// First line of each plane, then the number of lines.
    planes: Vec<u32>,
}

/// A candidate for the layout.
#[derive(Clone, Copy)]
struct Candidate {
    lane_axis: usize,
    /// Number that is added to the coordinate along the lane axis before the division into blocks, 0 to 7.
    offset: i32,
}

/// Grid index of a block: coordinates along x and the inner axis, and number of the block along the lane
/// axis. Blocks are stored in the order of their keys.
type BlockKey = [i32; 3];

impl Candidate {
    /// Returns the block and the lane of the vertex at a grid index.
    fn block_and_lane(self, index: [i32; 3]) -> (BlockKey, usize) {
        let shifted = index[self.lane_axis] + self.offset;
        let lanes = LANES as i32;
        let block = [index[0], index[self.inner_axis()], shifted.div_euclid(lanes)];
        (block, shifted.rem_euclid(lanes) as usize)
    }

    /// Returns the inner axis: the axis other than x and the lane axis.
    fn inner_axis(self) -> usize {
        3 - self.lane_axis
    }

    /// Returns the component of a [`BlockKey`] that counts along an axis.
    fn component(self, axis: usize) -> usize {
        match axis {
            0 => 0,
            axis if axis == self.lane_axis => 2,
            _ => 1,
        }
    }
}

impl Layout {
    /// Builds the layout of a lattice, with the lane axis and the offset that give the fewest blocks.
    pub(crate) fn new(lattice: &Lattice) -> Self {
        let candidate = fewest_blocks(lattice.indices());
        let mut keys: Vec<BlockKey> =
            lattice.indices().iter().map(|&index| candidate.block_and_lane(index).0).collect();
        keys.sort_unstable();
        keys.dedup();

        let mut slots = Vec::with_capacity(lattice.len());
        let mut occupied = vec![0; keys.len()];
        let mut links = [0, 1, 2].map(|_| vec![0; keys.len()]);
        let mut last = ([i32::MIN; 3], 0);
        for (&index, &linked) in lattice.indices().iter().zip(lattice.links()) {
            let (key, lane) = candidate.block_and_lane(index);
            if key != last.0 {
                last = (key, keys.binary_search(&key).expect("each vertex has a block"));
            }
            let block = last.1;
            slots.push((block * LANES + lane) as u32);
            occupied[block] |= 1 << lane;
            for (axis, links) in links.iter_mut().enumerate() {
                links[block] |= (linked >> (2 * axis + 1) & 1) << lane;
            }
        }

        let mut axis = 0;
        let axes = links.map(|links| {
            let across =
                (axis != candidate.lane_axis).then(|| Neighbors::new(&keys, candidate.component(axis)));
            axis += 1;
            AxisLinks { links, across }
        });
        let lines = starts(&keys, |a, b| a[..2] != b[..2]);
        let line_keys: Vec<BlockKey> =
            lines[..lines.len() - 1].iter().map(|&block| keys[block as usize]).collect();
        let planes = starts(&line_keys, |a, b| a[0] != b[0]);
        Self { slots, occupied, axes, lane_axis: candidate.lane_axis, lines, planes }
    }

    /// Returns the number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.occupied.len()
    }

    /// Returns the memory of the layout, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.slots())
            + self.blocks()
            + self.axes.iter().map(AxisLinks::bytes).sum::<usize>()
            + size_of_val(self.lines.as_slice())
            + size_of_val(self.planes.as_slice())
    }

    /// Returns the slot of each lattice vertex.
    pub(crate) fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// Returns the mask of each block: bit `l` is set iff lane `l` has a vertex.
    pub(crate) fn occupied(&self) -> &[u8] {
        &self.occupied
    }

    /// Returns the links along an axis.
    pub(crate) fn axis(&self, axis: usize) -> &AxisLinks {
        &self.axes[axis]
    }

    /// Returns the axis along the lanes: 1 or 2.
    pub(crate) fn lane_axis(&self) -> usize {
        self.lane_axis
    }

    /// Returns the number of planes.
    pub(crate) fn planes(&self) -> usize {
        self.planes.len() - 1
    }

    /// Iterates over the lines of a plane. A line is returned as the range of its blocks.
    pub(crate) fn lines(&self, plane: usize) -> impl ExactSizeIterator<Item = Range<usize>> {
        let lines = &self.lines[self.planes[plane] as usize..=self.planes[plane + 1] as usize];
        lines.windows(2).map(|ends| ends[0] as usize..ends[1] as usize)
    }

    /// Returns the range of the blocks of a range of planes.
    pub(crate) fn blocks_of(&self, planes: Range<usize>) -> Range<usize> {
        let first = |plane: usize| self.lines[self.planes[plane] as usize] as usize;
        first(planes.start)..first(planes.end)
    }
}

/// Returns the index of the first item of each group, then the number of items.
///
/// A group ends at an item if `separates` returns true for the item and the next item.
fn starts<T>(items: &[T], separates: impl Fn(&T, &T) -> bool) -> Vec<u32> {
    let ends = items.windows(2).enumerate().filter(|(_, pair)| separates(&pair[0], &pair[1]));
    let inner_starts = ends.map(|(end, _)| end as u32 + 1);
    std::iter::once(0).chain(inner_starts).chain([items.len() as u32]).collect()
}

/// Returns the candidate with the fewest blocks; the first one if several have equally many.
fn fewest_blocks(indices: &[[i32; 3]]) -> Candidate {
    let mut best = (usize::MAX, Candidate { lane_axis: 1, offset: 0 });
    for lane_axis in [1, 2] {
        let mut reordered: Vec<[i32; 3]> =
            indices.iter().map(|i| [i[0], i[3 - lane_axis], i[lane_axis]]).collect();
        reordered.sort_unstable();
        for offset in 0..LANES as i32 {
            let block = |index: &[i32; 3]| [index[0], index[1], (index[2] + offset).div_euclid(LANES as i32)];
            let blocks = 1 + reordered.windows(2).filter(|pair| block(&pair[0]) != block(&pair[1])).count();
            if blocks < best.0 {
                best = (blocks, Candidate { lane_axis, offset });
            }
        }
    }
    best.1
}

/// The links along one axis.
#[derive(Clone, Debug)]
pub(crate) struct AxisLinks {
    /// Bit `l` of the entry of a block is set iff the vertex in lane `l` is linked to the next vertex along
    /// the axis.
    pub(crate) links: Vec<u8>,
    /// The neighbors of each block along the axis. `None` for the lane axis, along which linked vertices have
    /// consecutive slots.
    pub(crate) across: Option<Neighbors>,
}

/// The neighbors of each block along an axis.
#[derive(Clone, Debug)]
pub(crate) struct Neighbors {
    /// Next block along the axis, or the block itself if there is no next block.
    pub(crate) next: Vec<u32>,
    /// Previous block along the axis, or the block itself if there is no previous block.
    pub(crate) previous: Vec<u32>,
}

impl Neighbors {
    /// Finds the neighbors of blocks along an axis.
    ///
    /// `keys`: the sorted keys of the blocks. `component`: the component of a key that counts along the axis.
    fn new(keys: &[[i32; 3]], component: usize) -> Self {
        let mut next: Vec<u32> = (0..keys.len() as u32).collect();
        let mut previous = next.clone();
        // Index of the first key that is not less than `target`. It never decreases, because the keys are
        // sorted and `target` increases with `key`.
        let mut at = 0;
        for (block, key) in keys.iter().enumerate() {
            let mut target = *key;
            target[component] += 1;
            while at < keys.len() && keys[at] < target {
                at += 1;
            }
            if keys.get(at) == Some(&target) {
                next[block] = at as u32;
                previous[at] = block as u32;
            }
        }
        Self { next, previous }
    }
}

impl AxisLinks {
    /// Returns the slot of the next vertex along the axis, if the vertex is linked to it.
    pub(crate) fn next_slot(&self, slot: usize) -> Option<usize> {
        let (block, lane) = (slot / LANES, slot % LANES);
        if self.links[block] >> lane & 1 == 0 {
            return None;
        }
        Some(match &self.across {
            Some(neighbors) => neighbors.next[block] as usize * LANES + lane,
            None => slot + 1,
        })
    }

    /// Returns the memory of the links, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Neighbors { next, previous } = match &self.across {
            Some(neighbors) => neighbors,
            None => return self.links.len(),
        };
        self.links.len() + size_of_val(next.as_slice()) + size_of_val(previous.as_slice())
    }
}
