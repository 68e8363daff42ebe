//! The inverse rest spreads of the regions, stored once for all blocks that have the same ones.

use std::collections::HashMap;

use fearless_simd::{Simd, f32x16};

use crate::simd::lanes::{Block, Lanes, load_two};

/// C⁻¹ of each region, xx, yy, zz, xy, xz, yz, with the rest spread C = M⁻¹ Σ m/n y yᵀ. y is the rest offset of a
/// vertex from the rest centroid, in cells. Zero in lanes without a vertex, and for planar regions at the fronts of
/// cracks.
///
/// Most blocks inside a solid body have the same spreads. A step that reads few different blocks finds them in the cache.
#[derive(Clone, Debug)]
pub(crate) struct InverseSpreads {
    /// The different blocks, in the order in which they first appear.
    blocks: Vec<Block<6>>,
    /// Index in `blocks` of each block of the layout.
    indices: Vec<u32>,
}

impl InverseSpreads {
    /// Stores the inverse spreads of each block.
    pub(super) fn new(spreads: &Lanes<6>) -> Self {
        let (mut blocks, mut known) = (Vec::new(), HashMap::new());
        let index_of = |block: &Block<6>| {
            let bits = block.map(|row| row.map(f32::to_bits));
            *known.entry(bits).or_insert_with(|| {
                blocks.push(*block);
                blocks.len() as u32 - 1
            })
        };
        let indices = spreads.blocks().iter().map(index_of).collect();
        blocks.shrink_to_fit();
        Self { blocks, indices }
    }

    /// Returns C⁻¹ of the region around the vertex in a slot.
    #[cfg(test)]
    pub(crate) fn get(&self, slot: u32) -> [f32; 6] {
        use crate::simd::lanes::LANES;
        let (block, lane) = (slot as usize / LANES, slot as usize % LANES);
        self.blocks[self.indices[block] as usize].map(|row| row[lane])
    }

    /// Loads C⁻¹ of the regions of two blocks of the layout.
    #[inline(always)]
    pub(super) fn load_two<S: Simd>(&self, simd: S, blocks: [usize; 2]) -> [f32x16<S>; 6] {
        let [a, b] = blocks.map(|block| &self.blocks[self.indices[block] as usize]);
        load_two(simd, [a, b])
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice()) + size_of_val(self.indices.as_slice())
    }
}
