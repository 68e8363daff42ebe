//! Assigns lattice vertices to blocks: cubes of 2 × 2 × 2 vertices, one vertex in each lane. Blocks without a vertex
//! are not stored.
//!
//! The *slot* of a vertex is `8 * block + lane`, its index in the storage; see `simd::lanes`, which also numbers the
//! lanes.
//!
//! ```text
//! plane  all blocks with the same x         planes are stored in the order of x
//! line   the blocks of a plane with one y   lines of a plane are stored in the order of y
//! block  2 × 2 × 2 vertices                 blocks of a line are stored in the order of z
//! ```
//!
//! The moment cascade begins and ends with x, so that all of its other passes stay within a plane. The boundaries of
//! the blocks are shifted along each axis by an offset of 0 or 1. Of the eight offsets, the one with the fewest blocks
//! is used.

use std::ops::Range;

use super::Lattice;
use super::blocks::{BlockKey, block_and_lane, block_keys, fewest_blocks};
use super::charts::Chart;
use crate::simd::lanes::{LANES, LOWER, lane_stride};

/// The blocks of a lattice, and the links between their vertices.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Slot of each lattice vertex.
    slots: Vec<u32>,
    /// Bit `l` of the entry of a block is set iff lane `l` of the block has a vertex.
    occupied: Vec<u8>,
    /// Links along x, y and z.
    axes: [AxisLinks; 3],
    /// First block of each line, then the number of blocks.
    lines: Vec<u32>,
    /// First line of each plane, then the number of lines.
    planes: Vec<u32>,
    /// The cells whose corners links do not all join; none in a lattice without broken joints.
    loose: LooseCells,
}

/// A cell of which links do not join all corners to the first one: see `charts`.
#[derive(Clone, Debug)]
pub(crate) struct LooseCell {
    /// Slot of the first corner.
    pub(crate) slot: u32,
    /// Slots of the corners.
    pub(crate) corners: [u32; 8],
    /// Index among the loose cells.
    pub(crate) number: u32,
}

/// The loose cells of a layout.
#[derive(Clone, Debug, Default)]
pub(crate) struct LooseCells {
    /// Sorted by slot.
    cells: Vec<LooseCell>,
    /// The slot of each corner, the index of its cell and its number in the cell. Sorted.
    corners: Vec<(u32, u32, u8)>,
}

impl LooseCells {
    /// Finds the loose cells of a lattice.
    fn new(lattice: &Lattice, slots: &[u32], axes: &[AxisLinks; 3]) -> Self {
        let mut cells: Vec<LooseCell> = (0..lattice.cells().len() as u32)
            .map(|cell| {
                let corners = lattice.cell_corners(cell).map(|corner| slots[corner as usize]);
                LooseCell { slot: corners[0], corners, number: 0 }
            })
            .filter(|cell| !cell.is_linked(axes))
            .collect();
        cells.sort_unstable_by_key(|cell| cell.slot);
        (0..).zip(&mut cells).for_each(|(number, cell)| cell.number = number);
        let mut corners: Vec<(u32, u32, u8)> = cells
            .iter()
            .flat_map(|cell| (0..).zip(cell.corners).map(|(k, corner)| (corner, cell.number, k)))
            .collect();
        corners.sort_unstable();
        Self { cells, corners }
    }

    /// Returns the cells whose sums are stored in a range of blocks.
    pub(crate) fn of_blocks(&self, blocks: Range<usize>) -> &[LooseCell] {
        let at = |block: usize| self.cells.partition_point(|cell| (cell.slot as usize) < block * LANES);
        if self.cells.is_empty() { &[] } else { &self.cells[at(blocks.start)..at(blocks.end)] }
    }

    /// Returns the corners whose vertices are in a range of blocks.
    pub(crate) fn corners_of_blocks(&self, blocks: Range<usize>) -> &[(u32, u32, u8)] {
        let at = |block: usize| self.corners.partition_point(|(slot, ..)| (*slot as usize) < block * LANES);
        &self.corners[at(blocks.start)..at(blocks.end)]
    }

    /// Returns the slots of the cells that have the vertex in a slot as a corner.
    pub(crate) fn around(&self, slot: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.corners.partition_point(|(corner, ..)| *corner < slot);
        let own = self.corners[first..].iter().take_while(move |(corner, ..)| *corner == slot);
        own.map(|&(_, number, _)| self.cells[number as usize].slot)
    }

    /// Returns whether the cell whose first corner is in a slot is loose.
    pub(crate) fn contains(&self, slot: u32) -> bool {
        self.cells.binary_search_by_key(&slot, |cell| cell.slot).is_ok()
    }

    /// Returns all cells.
    pub(crate) fn all(&self) -> &[LooseCell] {
        &self.cells
    }

    fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice()) + size_of_val(self.corners.as_slice())
    }
}

impl LooseCell {
    /// Returns whether links along z, then y, then x lead from the first corner to all others, as in window sums.
    fn is_linked(&self, axes: &[AxisLinks; 3]) -> bool {
        let next = |slot: u32, axis: usize| axes[axis].next_slot(slot as usize).map(|slot| slot as u32);
        self.corners.iter().enumerate().all(|(k, &corner)| {
            let along = |slot, &axis: &usize| if k >> axis & 1 == 0 { Some(slot) } else { next(slot, axis) };
            [2, 1, 0].iter().try_fold(self.slot, along) == Some(corner)
        })
    }
}

impl Layout {
    /// Builds the layout of a lattice, with the offset that gives the fewest blocks.
    pub(crate) fn new(lattice: &Lattice) -> Self {
        if let Some(chart) = lattice.chart() {
            return Self::of_chart(lattice, chart);
        }
        let offset = fewest_blocks(&lattice.vertex_set);
        let keys = block_keys(&lattice.vertex_set, offset);
        let mut slots = Vec::with_capacity(lattice.len());
        let mut occupied = vec![0; keys.len()];
        let mut links = [0, 1, 2].map(|_| vec![0; keys.len()]);
        let mut last = ([i32::MIN; 3], 0);
        for (&index, &linked) in lattice.indices().iter().zip(lattice.links()) {
            let (key, lane) = block_and_lane(offset, index);
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
            let axis_links = AxisLinks::new(axis, links, &keys);
            axis += 1;
            axis_links
        });
        let (lines, planes) = lines_and_planes(&keys);
        Self { slots, occupied, axes, lines, planes, loose: LooseCells::default() }
    }

    /// Builds the layout of a lattice with broken joints.
    fn of_chart(lattice: &Lattice, chart: &Chart) -> Self {
        let places: Vec<_> =
            lattice.indices().iter().map(|&index| block_and_lane(chart.offset, index)).collect();
        let mut blocks: Vec<(BlockKey, u32)> =
            places.iter().zip(&chart.sheets).map(|((key, _), &sheet)| (*key, sheet)).collect();
        blocks.sort_unstable();
        blocks.dedup();
        let mut occupied = vec![0; blocks.len()];
        let slots: Vec<u32> = places
            .iter()
            .zip(&chart.sheets)
            .map(|(&(key, lane), &sheet)| {
                let block = blocks.binary_search(&(key, sheet)).expect("each vertex has a block");
                occupied[block] |= 1 << lane;
                (block * LANES + lane) as u32
            })
            .collect();
        let axes = [0, 1, 2].map(|axis| AxisLinks::of_slots(axis, lattice, (&slots, blocks.len())));
        let keys: Vec<BlockKey> = blocks.into_iter().map(|(key, _)| key).collect();
        let (lines, planes) = lines_and_planes(&keys);
        let loose = LooseCells::new(lattice, &slots, &axes);
        Self { slots, occupied, axes, lines, planes, loose }
    }

    /// Returns the cells whose corners links do not all join.
    pub(crate) fn loose_cells(&self) -> &LooseCells {
        &self.loose
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
            + self.loose.bytes()
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

/// Returns the first block of each line, then the number of blocks, and the first line of each plane, then the number
/// of lines. `keys`: the sorted keys of the blocks.
fn lines_and_planes(keys: &[BlockKey]) -> (Vec<u32>, Vec<u32>) {
    let lines = starts(keys, |a, b| a[..2] != b[..2]);
    let line_keys: Vec<BlockKey> =
        lines[..lines.len() - 1].iter().map(|&block| keys[block as usize]).collect();
    let planes = starts(&line_keys, |a, b| a[0] != b[0]);
    (lines, planes)
}

/// Returns the index of the first item of each group, then the number of items.
///
/// A group ends at an item if `separates` returns true for the item and the next item.
fn starts<T>(items: &[T], separates: impl Fn(&T, &T) -> bool) -> Vec<u32> {
    let ends = items.windows(2).enumerate().filter(|(_, pair)| separates(&pair[0], &pair[1]));
    let inner_starts = ends.map(|(end, _)| end as u32 + 1);
    std::iter::once(0).chain(inner_starts).chain([items.len() as u32]).collect()
}

/// The links along one axis.
#[derive(Clone, Debug)]
pub(crate) struct AxisLinks {
    axis: usize,
    /// Bit `l` of the entry of a block is set iff the vertex in lane `l` is linked to the next vertex along
    /// the axis.
    pub(crate) links: Vec<u8>,
    /// Next block along the axis, or the block itself if there is no next block.
    next: Vec<u32>,
    /// Previous block along the axis, or the block itself if there is no previous block.
    previous: Vec<u32>,
}

impl AxisLinks {
    /// Finds the neighbors of blocks along an axis. `keys`: the sorted keys of the blocks.
    fn new(axis: usize, links: Vec<u8>, keys: &[BlockKey]) -> Self {
        let mut next: Vec<u32> = (0..keys.len() as u32).collect();
        let mut previous = next.clone();
        // Index of the first key that is not less than `target`. It never decreases, because the keys are
        // sorted and `target` increases with `key`.
        let mut at = 0;
        for (block, key) in keys.iter().enumerate() {
            let mut target = *key;
            target[axis] += 1;
            while at < keys.len() && keys[at] < target {
                at += 1;
            }
            if keys.get(at) == Some(&target) {
                next[block] = at as u32;
                previous[at] = block as u32;
            }
        }
        Self { axis, links, next, previous }
    }

    /// Finds the links and the neighbors of blocks along an axis from the links of a lattice whose links join each
    /// block to one next block at most. `slots`: the slot of each vertex; `blocks`: the number of blocks.
    fn of_slots(axis: usize, lattice: &Lattice, (slots, blocks): (&[u32], usize)) -> Self {
        let mut next: Vec<u32> = (0..blocks as u32).collect();
        let mut previous = next.clone();
        let mut links = vec![0; blocks];
        for (vertex, &slot) in (0..).zip(slots) {
            let Some(other) = lattice.neighbors(vertex)[2 * axis + 1] else { continue };
            let (block, other) = (slot as usize / LANES, slots[other as usize] as usize / LANES);
            links[block] |= 1 << (slot as usize % LANES);
            if other != block {
                next[block] = other as u32;
                previous[other] = block as u32;
            }
        }
        Self { axis, links, next, previous }
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
    pub(crate) fn next_slot(&self, slot: usize) -> Option<usize> {
        let (block, lane) = (slot / LANES, slot % LANES);
        let stride = lane_stride(self.axis);
        let is_lower = LOWER[self.axis] >> lane & 1 != 0;
        (self.links[block] >> lane & 1 != 0)
            .then(|| if is_lower { slot + stride } else { self.next(block) * LANES + lane - stride })
    }

    /// Returns the slot of the previous vertex along the axis, if it is linked to the vertex.
    pub(crate) fn previous_slot(&self, slot: usize) -> Option<usize> {
        let (block, lane) = (slot / LANES, slot % LANES);
        let stride = lane_stride(self.axis);
        let (block, links, lane) = if LOWER[self.axis] >> lane & 1 == 0 {
            (block, self.links[block], lane - stride)
        } else {
            let (previous, links) = self.previous(block);
            (previous, links, lane + stride)
        };
        (links >> lane & 1 != 0).then_some(block * LANES + lane)
    }

    /// Returns the memory of the links, in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.links.len() + size_of_val(self.next.as_slice()) + size_of_val(self.previous.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    /// Returns a box of vertices whose first vertex is at `low`.
    fn lattice(low: [i32; 3], size: [i32; 3]) -> Lattice {
        let [nx, ny, nz] = size.map(|vertices| vertices - 1);
        let cells =
            (0..nx * ny * nz).map(|k| [k / (ny * nz) + low[0], k / nz % ny + low[1], k % nz + low[2]]);
        Lattice::from_cells(&cells.collect::<Vec<_>>(), 1.0, Point3::origin(), false).unwrap()
    }

    #[test]
    fn blocks_of_even_boxes_are_full() {
        for low in [[0, 0, 0], [1, 0, 0], [0, -1, 0], [3, 5, -7]] {
            let layout = Layout::new(&lattice(low, [4, 6, 10]));
            assert_eq!((layout.blocks(), layout.planes()), (30, 2), "{low:?}");
            assert!(layout.occupied().iter().all(|&lanes| lanes == 0xff), "{low:?}");
        }
        assert_eq!(Layout::new(&lattice([0; 3], [5, 3, 2])).blocks(), 6);
    }

    #[test]
    fn next_slots_follow_the_links() {
        for low in [[0, 0, 0], [1, -1, 1]] {
            let mut cells: Vec<_> = lattice(low, [4, 5, 3]).cells().to_vec();
            // Apart from the box, two cells that touch along an edge.
            cells.extend([[low[0] + 9, low[1], low[2]], [low[0] + 10, low[1] + 1, low[2]]]);
            let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
            let layout = Layout::new(&lattice);
            let slots = layout.slots();
            for (vertex, (index, linked)) in lattice.indices().iter().zip(lattice.links()).enumerate() {
                for axis in 0..3 {
                    let mut target = *index;
                    target[axis] += 1;
                    let next = lattice.indices().iter().position(|index| *index == target);
                    let is_linked = linked >> (2 * axis + 1) & 1 != 0;
                    let expected = next.filter(|_| is_linked).map(|next| slots[next] as usize);
                    assert_eq!(layout.axis(axis).next_slot(slots[vertex] as usize), expected);
                    let back = expected.and_then(|next| layout.axis(axis).previous_slot(next));
                    assert_eq!(back, expected.map(|_| slots[vertex] as usize));
                }
            }
        }
    }
}
