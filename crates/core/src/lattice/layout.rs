//! Where lattice vertices are stored: blocks of eight along one axis, only those that hold a vertex.
//!
//! ```text
//! plane  x = const: all its lines            planes are stored one after another: x is the outer axis
//! line   one after another along the inner axis
//! block  0: lanes 0..8   1: lanes 0..8  …    along the lane axis; the next along it is the next in storage
//! ```
//!
//! The cascade begins and ends with x, so all of its other passes stay within a plane. Whether y or z runs along
//! the lanes, and its offset, are chosen by counting blocks: 16 candidates. The order in which the window sums
//! visit the axes does not depend on this choice.

use std::ops::Range;

use super::Lattice;
use crate::simd::lanes::LANES;

/// The blocks of a lattice and how they are linked.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    slots: Vec<u32>,
    occupied: Vec<u8>,
    axes: [AxisLinks; 3],
    lane_axis: usize,
    /// The first block of each line, and the end.
    lines: Vec<u32>,
    /// The first line of each plane, and the end.
    planes: Vec<u32>,
}

/// A candidate: the lanes' axis, and what is added to a grid coordinate before it is cut into blocks.
#[derive(Clone, Copy)]
struct Candidate {
    lanes: usize,
    offset: i32,
}

/// Plane, line, and place along the line: sorted as blocks are stored.
type BlockKey = [i32; 3];

impl Candidate {
    /// The block that holds a grid position, and the lane.
    fn place(self, index: [i32; 3]) -> (BlockKey, usize) {
        let along = index[self.lanes] + self.offset;
        let lanes = LANES as i32;
        let block = [index[0], index[self.inner()], along.div_euclid(lanes)];
        (block, along.rem_euclid(lanes) as usize)
    }

    /// The axis across the lines of a plane.
    fn inner(self) -> usize {
        3 - self.lanes
    }

    /// The component of a block's key that counts along an axis.
    fn component(self, axis: usize) -> usize {
        match axis {
            0 => 0,
            axis if axis == self.lanes => 2,
            _ => 1,
        }
    }
}

impl Layout {
    /// The layout of a lattice with the fewest blocks.
    pub(crate) fn new(lattice: &Lattice) -> Self {
        let candidate = fewest_blocks(lattice.indices());
        let mut keys: Vec<BlockKey> =
            lattice.indices().iter().map(|&index| candidate.place(index).0).collect();
        keys.sort_unstable();
        keys.dedup();

        let mut slots = Vec::with_capacity(lattice.len());
        let mut occupied = vec![0; keys.len()];
        let mut links = [0, 1, 2].map(|_| vec![0; keys.len()]);
        let mut last = ([i32::MIN; 3], 0);
        for (&index, &linked) in lattice.indices().iter().zip(lattice.links()) {
            let (key, lane) = candidate.place(index);
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
            let across = (axis != candidate.lanes).then(|| Neighbours::new(&keys, candidate.component(axis)));
            axis += 1;
            AxisLinks { links, across }
        });
        let lines = starts(&keys, |a, b| a[..2] != b[..2]);
        let line_keys: Vec<BlockKey> =
            lines[..lines.len() - 1].iter().map(|&block| keys[block as usize]).collect();
        let planes = starts(&line_keys, |a, b| a[0] != b[0]);
        Self { slots, occupied, axes, lane_axis: candidate.lanes, lines, planes }
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.occupied.len()
    }

    /// Memory that it takes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.slots())
            + self.blocks()
            + self.axes.iter().map(AxisLinks::bytes).sum::<usize>()
            + size_of_val(self.lines.as_slice())
            + size_of_val(self.planes.as_slice())
    }

    /// The slot of each lattice vertex.
    pub(crate) fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// The lanes of a block that hold a vertex, as bits.
    pub(crate) fn occupied(&self) -> &[u8] {
        &self.occupied
    }

    /// The links along an axis of the lattice.
    pub(crate) fn axis(&self, axis: usize) -> &AxisLinks {
        &self.axes[axis]
    }

    /// The axis along the lanes: 1 or 2.
    pub(crate) fn lane_axis(&self) -> usize {
        self.lane_axis
    }

    /// Number of planes.
    pub(crate) fn planes(&self) -> usize {
        self.planes.len() - 1
    }

    /// The blocks of each line of a plane.
    pub(crate) fn lines(&self, plane: usize) -> impl ExactSizeIterator<Item = Range<usize>> {
        let lines = &self.lines[self.planes[plane] as usize..=self.planes[plane + 1] as usize];
        lines.windows(2).map(|ends| ends[0] as usize..ends[1] as usize)
    }

    /// The blocks of some planes.
    pub(crate) fn blocks_of(&self, planes: Range<usize>) -> Range<usize> {
        let first = |plane: usize| self.lines[self.planes[plane] as usize] as usize;
        first(planes.start)..first(planes.end)
    }
}

/// Where a new group of neighbouring items begins, and the end.
fn starts<T>(items: &[T], parts: impl Fn(&T, &T) -> bool) -> Vec<u32> {
    let inner = items.windows(2).enumerate().filter(|(_, pair)| parts(&pair[0], &pair[1]));
    let inner = inner.map(|(at, _)| at as u32 + 1);
    std::iter::once(0).chain(inner).chain([items.len() as u32]).collect()
}

/// The candidate with the fewest blocks; of equals the first.
fn fewest_blocks(indices: &[[i32; 3]]) -> Candidate {
    let mut best = (usize::MAX, Candidate { lanes: 1, offset: 0 });
    for lanes in [1, 2] {
        let mut lines: Vec<[i32; 3]> = indices.iter().map(|i| [i[0], i[3 - lanes], i[lanes]]).collect();
        lines.sort_unstable();
        for offset in 0..LANES as i32 {
            let block = |line: &[i32; 3]| [line[0], line[1], (line[2] + offset).div_euclid(LANES as i32)];
            let blocks = 1 + lines.windows(2).filter(|pair| block(&pair[0]) != block(&pair[1])).count();
            if blocks < best.0 {
                best = (blocks, Candidate { lanes, offset });
            }
        }
    }
    best.1
}

/// The links along one axis.
#[derive(Clone, Debug)]
pub(crate) struct AxisLinks {
    /// Bit `l` of a block: its vertex in lane `l` is linked to the next one along the axis.
    pub(crate) links: Vec<u8>,
    /// The neighbours of blocks along the axis; `None` where the lanes run along it, and the next block is the
    /// next in storage.
    pub(crate) across: Option<Neighbours>,
}

/// The blocks next to each other along an axis.
#[derive(Clone, Debug)]
pub(crate) struct Neighbours {
    /// The block next along the axis; the block itself where there is none.
    pub(crate) next: Vec<u32>,
    /// The block before along the axis; the block itself where there is none.
    pub(crate) previous: Vec<u32>,
}

impl Neighbours {
    /// Of blocks with the sorted keys `keys`, along the axis that component `component` of a key counts.
    fn new(keys: &[[i32; 3]], component: usize) -> Self {
        let mut next: Vec<u32> = (0..keys.len() as u32).collect();
        let mut previous = next.clone();
        // What is sought grows with what it is sought for, as the keys are sorted.
        let mut at = 0;
        for (block, key) in keys.iter().enumerate() {
            let mut sought = *key;
            sought[component] += 1;
            while at < keys.len() && keys[at] < sought {
                at += 1;
            }
            if keys.get(at) == Some(&sought) {
                next[block] = at as u32;
                previous[at] = block as u32;
            }
        }
        Self { next, previous }
    }
}

impl AxisLinks {
    /// The slot next along the axis, if a link leads there.
    pub(crate) fn next_slot(&self, slot: usize) -> Option<usize> {
        let (block, lane) = (slot / LANES, slot % LANES);
        if self.links[block] >> lane & 1 == 0 {
            return None;
        }
        Some(match &self.across {
            Some(neighbours) => neighbours.next[block] as usize * LANES + lane,
            None => slot + 1,
        })
    }

    /// Memory that they take.
    pub(crate) fn bytes(&self) -> usize {
        let Neighbours { next, previous } = match &self.across {
            Some(neighbours) => neighbours,
            None => return self.links.len(),
        };
        self.links.len() + size_of_val(next.as_slice()) + size_of_val(previous.as_slice())
    }
}
