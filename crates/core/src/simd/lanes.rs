//! Stores numbers of lattice vertices in blocks of eight vertices, one vertex in each lane of an `f32x8`.
//!
//! The eight vertices of a block form a cube of 2 × 2 × 2 vertices of the lattice. A row has one number of each of
//! these vertices. Lane 4 x + 2 y + z has the vertex at (x, y, z), where each coordinate is 0 (lower) or 1 (upper).
//! Kernels load and store whole rows. They are written as plain loops, because a closure passed to `map` or `from_fn`
//! can be compiled as a separate function without the SIMD level of its caller.

use std::ops::{Deref, DerefMut};

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8, f32x16, mask32x8, u8x32};

/// Number of lattice vertices in a block: one for each lane of an `f32x8`.
pub(crate) const LANES: usize = 8;

/// For each axis, the bit mask of the lanes with the lower coordinate.
pub(crate) const LOWER: [u8; 3] = [0x0f, 0x33, 0x55];

/// Returns the difference between the lanes of two neighbors along an axis in a block.
pub(crate) const fn lane_stride(axis: usize) -> usize {
    4 >> axis
}

/// Returns the row of the vertices halfway between two consecutive blocks along an axis: the upper half of the block
/// `before` in the lower lanes, and the lower half of the block `after` in the upper lanes. These are the vertices one
/// link after the vertices of `before`, and one link before the vertices of `after`.
#[inline(always)]
pub(crate) fn between<S: Simd, const AXIS: usize>(simd: S, before: f32x8<S>, after: f32x8<S>) -> f32x8<S> {
    match AXIS {
        0 => {
            let ((_, upper), (lower, _)) = (simd.split_f32x8(before), simd.split_f32x8(after));
            simd.combine_f32x4(upper, lower)
        }
        1 => simd.slide_within_blocks_f32x8::<2>(before, after),
        _ => {
            let upper = mask32x8::from_bitmask(simd, u64::from(!LOWER[2]));
            let swapped = upper.select(before, after);
            simd.swizzle_dyn_within_blocks_f32x8(swapped, u8x32::load_array(simd, SWAPPED_ALONG_Z))
        }
    }
}

/// Byte indices that exchange the lower and the upper lanes along z.
const SWAPPED_ALONG_Z: [u8; 32] = {
    let mut bytes = [0; 32];
    let mut i = 0;
    while i < 32 {
        bytes[i] = (i % 16) as u8 ^ 4;
        i += 1;
    }
    bytes
};

/// Returns the bits of the vertices halfway between two consecutive blocks along an axis, as [`between`].
#[inline(always)]
pub(crate) const fn bits_between(axis: usize, before: u8, after: u8) -> u8 {
    (before >> lane_stride(axis)) & LOWER[axis] | (after << lane_stride(axis)) & !LOWER[axis]
}

/// One number for each of the eight lattice vertices of a block. The alignment keeps a row within one cache
/// line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Row([f32; LANES]);

impl Row {
    /// A row of zeros.
    pub(crate) const ZERO: Self = Self::all(0.0);

    /// Returns a row with `value` in each lane.
    pub(crate) const fn all(value: f32) -> Self {
        Self([value; LANES])
    }
}

impl Deref for Row {
    type Target = [f32; LANES];

    #[inline(always)]
    fn deref(&self) -> &[f32; LANES] {
        &self.0
    }
}

impl DerefMut for Row {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f32; LANES] {
        &mut self.0
    }
}

/// `N` numbers for each of the eight lattice vertices of a block.
pub(crate) type Block<const N: usize> = [Row; N];

/// `N` numbers for each lattice vertex, stored as blocks of `N` rows of eight lanes.
///
/// A *slot* is the index `8 * block + lane` of a lattice vertex in this storage. The layout of the lattice
/// maps lattice vertices to slots.
///
/// ```text
/// block 0: [number 0 of slots 0..8] [number 1 of slots 0..8] ... [number N-1 of slots 0..8]
/// block 1: [number 0 of slots 8..16] ...
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lanes<const N: usize> {
    blocks: Vec<[Row; N]>,
}

impl<const N: usize> Lanes<N> {
    /// Creates storage of `blocks` blocks, filled with zeros.
    pub fn zeros(blocks: usize) -> Self {
        Self::filled(blocks, [Row::ZERO; N])
    }

    /// Creates storage of `blocks` blocks, each a copy of `block`.
    pub fn filled(blocks: usize, block: [Row; N]) -> Self {
        Self { blocks: vec![block; blocks] }
    }

    /// Replaces the storage by one of `blocks` blocks, filled with zeros, if it has fewer.
    pub(crate) fn grow(&mut self, blocks: usize) {
        if self.blocks.len() < blocks {
            *self = Self::zeros(blocks);
        }
    }

    /// Overwrites these blocks with a copy of `other`. Reuses the allocation.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.blocks.clone_from(&other.blocks);
    }

    /// Removes all blocks. Keeps the allocation.
    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
    }

    /// Returns the numbers of one slot.
    #[inline]
    pub fn get(&self, slot: u32) -> [f32; N] {
        let (block, lane) = block_and_lane(slot);
        let block = &self.blocks[block];
        std::array::from_fn(|c| block[c][lane])
    }

    /// Sets the numbers of one slot.
    #[inline]
    pub fn set(&mut self, slot: u32, value: [f32; N]) {
        let (block, lane) = block_and_lane(slot);
        let block = &mut self.blocks[block];
        for (row, value) in block.iter_mut().zip(value) {
            row[lane] = value;
        }
    }

    /// Returns the memory of the blocks in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.blocks())
    }

    /// Returns the blocks in storage order.
    #[inline]
    pub fn blocks(&self) -> &[[Row; N]] {
        &self.blocks
    }

    /// Returns the blocks in storage order, mutable.
    #[inline]
    pub fn blocks_mut(&mut self) -> &mut [[Row; N]] {
        &mut self.blocks
    }
}

/// Loads the first `N` rows of a block.
#[inline(always)]
pub(crate) fn load<S: Simd, const N: usize, const M: usize>(simd: S, block: &Block<M>) -> [f32x8<S>; N] {
    let mut rows = [f32x8::splat(simd, 0.0); N];
    for c in 0..N {
        rows[c] = f32x8::load_array_ref(simd, &block[c]);
    }
    rows
}

/// Stores `values` in the first `N` of `rows`.
#[inline(always)]
pub(crate) fn store<S: Simd, const N: usize>(values: [f32x8<S>; N], rows: &mut [Row]) {
    for c in 0..N {
        values[c].store_array(&mut rows[c]);
    }
}

/// Loads the first `N` rows of two blocks. Each result has the row of the first block in lanes 0 to 7 and the
/// row of the second block in lanes 8 to 15. Computing on two independent blocks at once hides the latency of
/// long dependency chains.
#[inline(always)]
pub(crate) fn load_two<S: Simd, const N: usize, const M: usize>(
    simd: S,
    blocks: [&Block<M>; 2],
) -> [f32x16<S>; N] {
    let mut rows = [f32x16::splat(simd, 0.0); N];
    for c in 0..N {
        let [a, b] = blocks;
        let (a, b) = (f32x8::load_array_ref(simd, &a[c]), f32x8::load_array_ref(simd, &b[c]));
        rows[c] = simd.combine_f32x8(a, b);
    }
    rows
}

/// Splits rows loaded by [`load_two`] into the rows of the two blocks.
#[inline(always)]
pub(crate) fn split_two<S: Simd, const N: usize>(simd: S, values: [f32x16<S>; N]) -> [[f32x8<S>; N]; 2] {
    let mut blocks = [[f32x8::splat(simd, 0.0); N]; 2];
    for c in 0..N {
        (blocks[0][c], blocks[1][c]) = simd.split_f32x16(values[c]);
    }
    blocks
}

/// Returns the block and the lane of a slot.
#[inline(always)]
pub(crate) fn block_and_lane(slot: u32) -> (usize, usize) {
    (slot as usize / LANES, slot as usize % LANES)
}

/// Returns the slot of a lane of a block.
#[inline]
pub(crate) fn slot_of((block, lane): (usize, usize)) -> u32 {
    (block * LANES + lane) as u32
}

/// Serializes the numbers as little-endian bytes in storage order. This format is exact, compact and fast.
#[cfg(feature = "serde")]
impl<const N: usize> serde::Serialize for Lanes<N> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let numbers = self.blocks.as_flattened().iter().flat_map(|row| row.0);
        let mut bytes = Vec::with_capacity(self.bytes());
        numbers.for_each(|number| bytes.extend_from_slice(&number.to_le_bytes()));
        serializer.serialize_bytes(&bytes)
    }
}

#[cfg(feature = "serde")]
impl<'de, const N: usize> serde::Deserialize<'de> for Lanes<N> {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_bytes(BytesVisitor::<N>)
    }
}

/// Reads the bytes of [`Lanes`], also from formats that write bytes as a list of numbers.
#[cfg(feature = "serde")]
struct BytesVisitor<const N: usize>;

#[cfg(feature = "serde")]
impl<'de, const N: usize> serde::de::Visitor<'de> for BytesVisitor<N> {
    type Value = Lanes<N>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the bytes of a lattice array")
    }

    fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> Result<Lanes<N>, E> {
        let (words, extra_bytes) = bytes.as_chunks::<4>();
        let (rows, extra_words) = words.as_chunks::<LANES>();
        let (blocks, extra_rows) = rows.as_chunks::<N>();
        if !(extra_bytes.is_empty() && extra_words.is_empty() && extra_rows.is_empty()) {
            return Err(E::custom("a lattice array is not a whole number of blocks"));
        }
        let number = |word: &[u8; 4]| f32::from_le_bytes(*word);
        Ok(Lanes {
            blocks: blocks.iter().map(|block| block.map(|row| Row(row.map(|word| number(&word))))).collect(),
        })
    }

    fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut list: A) -> Result<Lanes<N>, A::Error> {
        let mut bytes = Vec::new();
        while let Some(byte) = list.next_element()? {
            bytes.push(byte);
        }
        self.visit_bytes(&bytes)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::simd::level;

    #[test]
    fn rows_between_blocks_have_the_upper_half_of_the_first_and_the_lower_half_of_the_second() {
        let (before, after): ([f32; 8], [f32; 8]) =
            (std::array::from_fn(|lane| lane as f32), std::array::from_fn(|lane| (8 + lane) as f32));
        let rows = dispatch!(level(), simd => {
            let (before, after) = (f32x8::load_array(simd, before), f32x8::load_array(simd, after));
            [
                between::<_, 0>(simd, before, after).to_array(),
                between::<_, 1>(simd, before, after).to_array(),
                between::<_, 2>(simd, before, after).to_array(),
            ]
        });
        assert_eq!(rows[0], [4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0]);
        assert_eq!(rows[1], [2.0, 3.0, 8.0, 9.0, 6.0, 7.0, 12.0, 13.0]);
        assert_eq!(rows[2], [1.0, 8.0, 3.0, 10.0, 5.0, 12.0, 7.0, 14.0]);
        for (axis, row) in rows.iter().enumerate() {
            for bit in 0..16 {
                let bits = bits_between(axis, ((1_u16 << bit) & 0xff) as u8, ((1_u16 << bit) >> 8) as u8);
                let expected = row.iter().position(|&value| value == bit as f32).map_or(0, |lane| 1 << lane);
                assert_eq!(bits, expected, "axis {axis}, bit {bit}");
            }
        }
    }
}
