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
use super::axis_links::AxisLinks;
use super::blocks::{BlockKey, block_keys, fewest_blocks, key_and_lane};
use super::charts::Chart;
use super::loose::LooseCells;
use crate::simd::lanes::{LANES, slot_of};

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
            let (key, lane) = key_and_lane(offset, index);
            if key != last.0 {
                last = (key, keys.binary_search(&key).expect("each vertex has a block"));
            }
            let block = last.1;
            slots.push(slot_of((block, lane)));
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
            lattice.indices().iter().map(|&index| key_and_lane(chart.offset, index)).collect();
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
                slot_of((block, lane))
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

    /// Returns an array by slot with the values of the lattice vertices, and the default elsewhere.
    pub(crate) fn by_slot<T: Clone + Default>(&self, values: impl Iterator<Item = T>) -> Vec<T> {
        let mut array = vec![T::default(); self.blocks() * LANES];
        self.slots.iter().zip(values).for_each(|(&slot, value)| array[slot as usize] = value);
        array
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

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::voxel::step;

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
                    let target = step(*index, axis, 1);
                    let next = lattice.indices().iter().position(|index| *index == target);
                    let is_linked = linked >> (2 * axis + 1) & 1 != 0;
                    let expected = next.filter(|_| is_linked).map(|next| slots[next]);
                    assert_eq!(layout.axis(axis).next_slot(slots[vertex]), expected);
                    let back = expected.and_then(|next| layout.axis(axis).previous_slot(next));
                    assert_eq!(back, expected.map(|_| slots[vertex]));
                }
            }
        }
    }
}
