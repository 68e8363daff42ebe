//! How blocks are linked along an axis of the lattice.

use crate::simd::lanes::LANES;

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
    pub(super) fn new(keys: &[[i32; 3]], component: usize) -> Self {
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
