//! The inverse rest covariances of the regions, stored once for all blocks that have the same ones.

use std::collections::HashMap;

use fearless_simd::{Simd, f32x8, f32x16};

use crate::simd::lanes::{Block, Lanes, load, load_two};

/// C⁻¹ of each region, xx, yy, zz, xy, xz, yz, with the rest covariance C = M⁻¹ Σ m/n y yᵀ. y is the rest offset of a
/// vertex from the rest centroid, in cells. Zero in lanes without a vertex, and for planar regions at the fronts of
/// cracks.
///
/// Most blocks inside a solid body have the same covariances. A step that reads few different blocks finds them in
/// the cache.
#[derive(Clone, Debug)]
pub(crate) struct InverseCovariances {
    /// The different blocks, in the order in which they first appear.
    blocks: Vec<Block<6>>,
    /// Whether the covariances of each of these are multiples of the identity, as in whole windows.
    is_isotropic: Vec<bool>,
    /// Index in `blocks` of each block of the layout.
    indices: Vec<u32>,
}

impl InverseCovariances {
    /// Stores the inverse covariances of each block.
    pub(super) fn new(covariances: &Lanes<6>) -> Self {
        let (mut blocks, mut known) = (Vec::new(), HashMap::new());
        let index_of = |block: &Block<6>| {
            let bits = block.map(|row| row.map(f32::to_bits));
            *known.entry(bits).or_insert_with(|| {
                blocks.push(*block);
                blocks.len() as u32 - 1
            })
        };
        let indices = covariances.blocks().iter().map(index_of).collect();
        blocks.shrink_to_fit();
        let is_isotropic = blocks.iter().map(is_isotropic).collect();
        Self { blocks, is_isotropic, indices }
    }

    /// Returns C⁻¹ of the region around the vertex in a slot.
    #[cfg(test)]
    pub(crate) fn get(&self, slot: u32) -> [f32; 6] {
        let (block, lane) = crate::simd::lanes::block_and_lane(slot);
        self.blocks[self.indices[block] as usize].map(|row| row[lane])
    }

    /// Loads C⁻¹ of the regions of two blocks of the layout.
    #[inline(always)]
    pub(super) fn load_two<S: Simd>(&self, simd: S, blocks: [usize; 2]) -> [f32x16<S>; 6] {
        let [a, b] = blocks.map(|block| &self.blocks[self.indices[block] as usize]);
        load_two(simd, [a, b])
    }

    /// Loads C⁻¹ of the regions of a block of the layout.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S, block: usize) -> [f32x8<S>; 6] {
        load(simd, &self.blocks[self.indices[block] as usize])
    }

    /// Returns whether C⁻¹ of all regions of two blocks of the layout are multiples of the identity.
    #[inline(always)]
    pub(super) fn are_isotropic(&self, blocks: [usize; 2]) -> bool {
        blocks.iter().all(|&block| self.is_isotropic[self.indices[block] as usize])
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let blocks = size_of_val(self.blocks.as_slice()) + size_of_val(self.is_isotropic.as_slice());
        blocks + size_of_val(self.indices.as_slice())
    }
}

/// Returns whether all matrices of a block are multiples of the identity, to rounding errors of their sums.
fn is_isotropic([xx, yy, zz, xy, xz, yz]: &Block<6>) -> bool {
    let near = |a: f32, b: f32| (a - b).abs() <= 8.0 * f32::EPSILON * a;
    let is_diagonal = [xy, xz, yz].iter().all(|row| row.iter().all(|&number| number == 0.0));
    is_diagonal && (0..xx.len()).all(|lane| near(xx[lane], yy[lane]) && near(xx[lane], zz[lane]))
}
