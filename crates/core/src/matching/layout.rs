//! Where lattice vertices are stored: blocks of eight along one axis, only those that hold a vertex.
//!
//! ```text
//! lane axis →   block 0: lanes 0..8   block 1: lanes 0..8   …      numbered along the lane axis first
//! ```
//!
//! The axis that runs along the lanes and its offset are chosen by counting blocks: 24 candidates. The order in
//! which the window sums visit the axes does not depend on this choice.

use crate::lanes::LANES;
use crate::lattice::Lattice;

/// No block.
const NONE: u32 = u32::MAX;

/// The blocks of a lattice and how they are linked.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    slots: Vec<u32>,
    occupied: Vec<u8>,
    axes: [AxisLinks; 3],
}

/// How blocks are linked along one axis of the lattice.
#[derive(Clone, Debug)]
pub(crate) struct AxisLinks {
    /// Whether the lanes of a block run along this axis.
    pub(crate) along_lanes: bool,
    /// Bit `l` of a block: its vertex in lane `l` is linked to the next one along the axis.
    pub(crate) links: Vec<u8>,
    /// The block next along the axis; meaningful where a link leads there.
    pub(crate) next: Vec<u32>,
    /// The block before along the axis; the block itself where there is none, whose links never lead back to it.
    pub(crate) previous: Vec<u32>,
}

/// A candidate: the lanes' axis, and what is added to a grid coordinate before it is cut into blocks.
#[derive(Clone, Copy)]
struct Candidate {
    axis: usize,
    offset: i32,
}

impl Candidate {
    /// The block that holds a grid position, as a key sorted like storage, and the lane.
    fn place(self, index: [i32; 3]) -> ([i32; 3], usize) {
        let along = index[self.axis] + self.offset;
        let (inner, outer) = self.others();
        let lanes = LANES as i32;
        ([index[outer], index[inner], along.div_euclid(lanes)], along.rem_euclid(lanes) as usize)
    }

    /// The two other axes, the one that is numbered faster first.
    fn others(self) -> (usize, usize) {
        match self.axis {
            0 => (1, 2),
            1 => (0, 2),
            _ => (0, 1),
        }
    }
}

impl Layout {
    /// The layout of a lattice with the fewest blocks.
    pub(crate) fn new(lattice: &Lattice) -> Self {
        let candidate = fewest_blocks(lattice.indices());
        let mut keys: Vec<[i32; 3]> =
            lattice.indices().iter().map(|&index| candidate.place(index).0).collect();
        keys.sort_unstable();
        keys.dedup();
        let block_of = |key: [i32; 3]| keys.binary_search(&key).ok();

        let mut slots = Vec::with_capacity(lattice.len());
        let mut occupied = vec![0; keys.len()];
        let mut links = [0, 1, 2].map(|_| vec![0; keys.len()]);
        let mut last = ([i32::MIN; 3], 0);
        for (&index, &linked) in lattice.indices().iter().zip(lattice.links()) {
            let (key, lane) = candidate.place(index);
            if key != last.0 {
                last = (key, block_of(key).expect("each vertex has a block"));
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
            let along_lanes = axis == candidate.axis;
            let (inner, _) = candidate.others();
            let component = if along_lanes { 2 } else { usize::from(axis == inner) };
            axis += 1;
            let mut next = vec![NONE; keys.len()];
            let mut previous: Vec<u32> = (0..keys.len() as u32).collect();
            for (block, key) in keys.iter().enumerate() {
                let mut key = *key;
                key[component] += 1;
                if let Some(neighbour) = block_of(key) {
                    next[block] = neighbour as u32;
                    previous[neighbour] = block as u32;
                }
            }
            AxisLinks { along_lanes, links, next, previous }
        });
        Self { slots, occupied, axes }
    }

    /// Number of blocks.
    pub(crate) fn blocks(&self) -> usize {
        self.occupied.len()
    }

    /// Memory that it takes.
    pub(crate) fn bytes(&self) -> usize {
        let per_block = size_of::<u8>() + 3 * (size_of::<u8>() + 2 * size_of::<u32>());
        size_of_val(self.slots()) + self.blocks() * per_block
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
}

impl AxisLinks {
    /// The slot next along the axis, if a link leads there.
    pub(crate) fn next_slot(&self, slot: usize) -> Option<usize> {
        let (block, lane) = (slot / LANES, slot % LANES);
        if self.links[block] >> lane & 1 == 0 {
            return None;
        }
        Some(match (self.along_lanes, lane + 1 < LANES) {
            (true, true) => slot + 1,
            (true, false) => self.next[block] as usize * LANES,
            (false, _) => self.next[block] as usize * LANES + lane,
        })
    }
}

/// The candidate with the fewest blocks; of equals the first.
fn fewest_blocks(indices: &[[i32; 3]]) -> Candidate {
    let mut best = (usize::MAX, Candidate { axis: 0, offset: 0 });
    for axis in 0..3 {
        let (inner, outer) = Candidate { axis, offset: 0 }.others();
        let mut lines: Vec<[i32; 3]> = indices.iter().map(|i| [i[outer], i[inner], i[axis]]).collect();
        lines.sort_unstable();
        for offset in 0..LANES as i32 {
            let block = |line: &[i32; 3]| [line[0], line[1], (line[2] + offset).div_euclid(LANES as i32)];
            let blocks = 1 + lines.windows(2).filter(|pair| block(&pair[0]) != block(&pair[1])).count();
            if blocks < best.0 {
                best = (blocks, Candidate { axis, offset });
            }
        }
    }
    best.1
}
