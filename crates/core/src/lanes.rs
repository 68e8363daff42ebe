//! Storage in blocks of eight lattice vertices along one axis: an array of structures of eight lanes.

/// Lattice vertices in a block: the lanes of one `f32x8`.
pub const LANES: usize = 8;

/// `N` numbers for each lattice vertex, stored as blocks of `N` rows of eight lanes.
///
/// A *slot* is `8 * block + lane`; which slot a lattice vertex has is known to its layout.
///
/// ```text
/// block 0: [c0 of slots 0..8] [c1 of slots 0..8] ... [c(N-1) of slots 0..8]
/// block 1: [c0 of slots 8..16] ...
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lanes<const N: usize> {
    blocks: Vec<[[f32; LANES]; N]>,
}

impl<const N: usize> Lanes<N> {
    /// Zeros in `blocks` blocks.
    pub fn zeros(blocks: usize) -> Self {
        Self { blocks: vec![[[0.0; LANES]; N]; blocks] }
    }

    /// The numbers of one slot.
    #[inline]
    pub fn get(&self, slot: u32) -> [f32; N] {
        let (block, lane) = split(slot);
        let block = &self.blocks[block];
        std::array::from_fn(|c| block[c][lane])
    }

    /// Sets the numbers of one slot.
    #[inline]
    pub fn set(&mut self, slot: u32, value: [f32; N]) {
        let (block, lane) = split(slot);
        let block = &mut self.blocks[block];
        for (row, value) in block.iter_mut().zip(value) {
            row[lane] = value;
        }
    }

    /// The blocks in storage order.
    #[inline]
    pub fn blocks(&self) -> &[[[f32; LANES]; N]] {
        &self.blocks
    }

    /// The blocks in storage order, to write to.
    #[inline]
    pub fn blocks_mut(&mut self) -> &mut [[[f32; LANES]; N]] {
        &mut self.blocks
    }
}

#[inline]
fn split(slot: u32) -> (usize, usize) {
    (slot as usize / LANES, slot as usize % LANES)
}
