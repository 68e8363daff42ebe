//! Stores scratch points of a thread, addressed by 16-bit byte offsets. Every such offset is in bounds, so
//! that a gather needs no bounds check.
//!
//! A row of a tile is one point [`Xyzx`]: 16 bytes.

use std::cell::RefCell;

use fearless_simd::{Bytes, Simd, SimdBase, f32x4, f32x8, u8x16};

use crate::simd::xyzx::{Eight, Pair, Xyzx};

/// Size of a row in bytes.
const ROW: usize = size_of::<Xyzx>();

/// Number of rows of a [`Tile`].
pub(crate) const ROWS: usize = (1 << 16) / ROW;

/// [`ROWS`] points, addressed by the offset of their first byte, and one row of padding. The padding makes a
/// read of 16 bytes valid at every 16-bit offset, so that the compiler can omit the bounds check.
#[repr(align(64))]
pub(crate) struct Tile([u8; (ROWS + 1) * ROW]);

/// Returns the byte offset of a row.
///
/// # Panics
///
/// If `row` is [`ROWS`] or greater.
pub(crate) fn offset(row: usize) -> u16 {
    assert!(row < ROWS, "row {row} is out of range: a tile has {ROWS} rows");
    (row * ROW) as u16
}

impl Tile {
    /// Returns the rows in pairs, without the padding.
    pub(crate) fn pairs(&mut self) -> &mut [Pair] {
        bytemuck::cast_slice_mut(&mut self.0[..ROWS * ROW])
    }

    /// Returns the rows in groups of eight, without the padding.
    pub(crate) fn blocks(&mut self) -> &mut [Eight] {
        bytemuck::cast_slice_mut(&mut self.0[..ROWS * ROW])
    }

    /// Returns the rows, followed by the row of padding.
    pub(crate) fn rows(&mut self) -> &mut [Xyzx] {
        bytemuck::cast_slice_mut(&mut self.0)
    }

    /// Returns the row at a byte offset.
    #[inline(always)]
    pub(crate) fn get(&self, offset: u16) -> Xyzx {
        bytemuck::pod_read_unaligned(self.bytes(offset))
    }

    /// Loads the rows at eight byte offsets, two rows into each register.
    #[inline(always)]
    pub(crate) fn gather<S: Simd>(&self, simd: S, offsets: &[u16; 8]) -> [f32x8<S>; 4] {
        let [a, b, c, d, e, f, g, h] = *offsets;
        [
            self.load_pair(simd, a, b),
            self.load_pair(simd, c, d),
            self.load_pair(simd, e, f),
            self.load_pair(simd, g, h),
        ]
    }

    /// Loads the rows at two byte offsets into one register.
    #[inline(always)]
    fn load_pair<S: Simd>(&self, simd: S, first: u16, second: u16) -> f32x8<S> {
        simd.combine_f32x4(self.load(simd, first), self.load(simd, second))
    }

    /// Loads the row at a byte offset into a register.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S, offset: u16) -> f32x4<S> {
        f32x4::from_bytes(u8x16::load_array_ref(simd, self.bytes(offset)))
    }

    /// Returns the bytes of the row at a byte offset.
    #[inline(always)]
    fn bytes(&self, offset: u16) -> &[u8; ROW] {
        let first = usize::from(offset);
        self.0[first..].first_chunk().expect("every 16-bit offset is within the tile")
    }
}

/// Calls `work` with the two tiles of the calling thread, which are allocated once per thread. They contain
/// the data of the previous call.
pub(crate) fn with_tiles<R>(work: impl FnOnce(&mut Tile, &mut Tile) -> R) -> R {
    thread_local! {
        static TILES: RefCell<[Box<Tile>; 2]> = RefCell::new([(); 2].map(|()| Box::new(Tile([0; (ROWS + 1) * ROW]))));
    }
    TILES.with_borrow_mut(|[first, second]| work(first, second))
}
