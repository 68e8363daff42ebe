//! Rows at byte offsets of 16 bits: near memory of one thread that is gathered from without a test.

use std::cell::RefCell;

use fearless_simd::{Bytes, Simd, SimdBase, f32x4, f32x8, u8x16};

use crate::simd::xyzx::{Eight, Pair, Xyzx};

/// Bytes of a row.
const ROW: usize = size_of::<Xyzx>();

/// Rows that a [`Tile`] holds.
pub(crate) const ROWS: usize = (1 << 16) / ROW;

/// [`ROWS`] rows, addressed by the offset of their first byte, and one more: so no offset of 16 bits leads outside,
/// and the compiler knows.
#[repr(align(64))]
pub(crate) struct Tile([u8; (ROWS + 1) * ROW]);

/// The offset of a row.
///
/// # Panics
///
/// If there is none of that number.
pub(crate) fn offset(row: usize) -> u16 {
    assert!(row < ROWS, "row {row} of a tile of {ROWS}");
    (row * ROW) as u16
}

impl Tile {
    /// The rows, two by two.
    pub(crate) fn pairs(&mut self) -> &mut [Pair] {
        bytemuck::cast_slice_mut(&mut self.0[..ROWS * ROW])
    }

    /// The rows, eight by eight.
    pub(crate) fn eights(&mut self) -> &mut [Eight] {
        bytemuck::cast_slice_mut(&mut self.0[..ROWS * ROW])
    }

    /// The rows.
    pub(crate) fn rows(&mut self) -> &mut [Xyzx] {
        bytemuck::cast_slice_mut(&mut self.0)
    }

    /// The row at an offset.
    #[inline(always)]
    pub(crate) fn get(&self, offset: u16) -> Xyzx {
        bytemuck::pod_read_unaligned(self.bytes(offset))
    }

    /// The rows at eight offsets, two in each register.
    #[inline(always)]
    pub(crate) fn gather<S: Simd>(&self, simd: S, at: &[u16; 8]) -> [f32x8<S>; 4] {
        let [a, b, c, d, e, f, g, h] = *at;
        [self.two(simd, a, b), self.two(simd, c, d), self.two(simd, e, f), self.two(simd, g, h)]
    }

    #[inline(always)]
    fn two<S: Simd>(&self, simd: S, first: u16, second: u16) -> f32x8<S> {
        simd.combine_f32x4(self.one(simd, first), self.one(simd, second))
    }

    /// The row at an offset, in a register.
    #[inline(always)]
    pub(crate) fn one<S: Simd>(&self, simd: S, offset: u16) -> f32x4<S> {
        f32x4::from_bytes(u8x16::load_array_ref(simd, self.bytes(offset)))
    }

    #[inline(always)]
    fn bytes(&self, offset: u16) -> &[u8; ROW] {
        let first = usize::from(offset);
        self.0[first..].first_chunk().expect("offsets lie within")
    }
}

/// Lets `work` have two tiles of this thread, with whatever was left in them.
pub(crate) fn with_tiles<R>(work: impl FnOnce(&mut Tile, &mut Tile) -> R) -> R {
    thread_local! {
        static TILES: RefCell<[Box<Tile>; 2]> = RefCell::new([(); 2].map(|()| Box::new(Tile([0; (ROWS + 1) * ROW]))));
    }
    TILES.with_borrow_mut(|[first, second]| work(first, second))
}
