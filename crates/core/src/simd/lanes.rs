//! Stores numbers of lattice vertices in blocks of eight vertices, one vertex in each lane of an `f32x8`.
//!
//! The eight vertices of a block are consecutive along one axis of the lattice. A row has one number of each
//! of these vertices. Kernels load and store whole rows. They are written as plain loops, because a closure
//! passed to `map` or `from_fn` can be compiled as a separate function without the SIMD level of its caller.

use std::ops::{Deref, DerefMut};

use fearless_simd::{Simd, SimdBase, f32x8, f32x16};

/// Number of lattice vertices in a block: one for each lane of an `f32x8`.
pub(crate) const LANES: usize = 8;

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
#[inline]
fn split(slot: u32) -> (usize, usize) {
    (slot as usize / LANES, slot as usize % LANES)
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
