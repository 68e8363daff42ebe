//! The values of fields: 64 bits with flags, a type, and 48 bits that hold the value or its offset in the file.

use super::prim::{Stored, StoredKind};

/// Offset of the first frame.
pub(crate) const FRAMES: u64 = 96;

/// The beginning of a file whose table of contents is at offset `contents`, with the hash of what follows the frames.
pub(crate) fn head(contents: u64, hash: u64) -> [u8; FRAMES as usize] {
    let mut head = [0; FRAMES as usize];
    head[..8].copy_from_slice(b"PXR-USDC");
    head[9] = 8;
    head[16..24].copy_from_slice(&contents.to_le_bytes());
    head[88..].copy_from_slice(&hash.to_le_bytes());
    head
}

/// The frames of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameTable<'a> {
    /// Offset of each frame.
    pub(super) starts: &'a [u64],
    /// Offset of the end of the last frame.
    pub(super) end: u64,
    /// Time codes of the frames.
    pub(super) times: &'a [f64],
}

/// Types of values in a file.
#[derive(Clone, Copy)]
#[repr(u8)]
pub(super) enum Type {
    Bool = 1,
    Int = 3,
    Float = 8,
    Double = 9,
    String = 10,
    Token = 11,
    Asset = 12,
    Matrix4d = 15,
    Vec2f = 20,
    Vec3f = 24,
    TokenListOp = 32,
    PathListOp = 34,
    TokenVector = 41,
    Specifier = 42,
    Variability = 44,
    TimeSamples = 46,
    DoubleVector = 48,
}

pub(super) const ARRAY: u64 = 1 << 63;
const INLINED: u64 = 1 << 62;

impl Type {
    /// A value at an offset in the file.
    pub(super) fn at(self, offset: u64) -> u64 {
        (self as u64) << 48 | offset
    }

    /// An array at an offset in the file.
    pub(super) fn array(self, offset: u64) -> u64 {
        ARRAY | self.at(offset)
    }

    /// A value that fits into 32 bits.
    pub(super) fn inlined(self, value: u32) -> u64 {
        INLINED | self.at(value.into())
    }
}

impl Stored {
    /// Returns the field value of a frame at offset `start`.
    pub(super) fn in_frame(self, start: u64) -> u64 {
        let at = start + self.at;
        match self.kind {
            StoredKind::Vectors3 => Type::Vec3f.array(at),
            StoredKind::Matrix => Type::Matrix4d.at(at),
        }
    }
}

/// Headers of lists: the whole list, or names that are put before those of weaker layers.
pub(super) const EXPLICIT: u8 = 0b0000_0011;
pub(super) const PREPENDED: u8 = 0b0010_0000;
