//! The values that change in a run, in the bytes of a frame.
//!
//! ```text
//! for each body       u64 number of points, f32 x, y, z of each point
//!                     u64 2, f32 bounds of the points: smallest x, y, z, largest x, y, z
//!                     u64 number of points, f32 x, y, z of the velocity of each point; only if the stage has them
//!                     u64 number of normals, f32 x, y, z of each normal; only if the body has normals
//! for each collider   f64 matrix that transforms row vectors, by rows; NaN if it is disabled
//!                     as the points and the bounds of a body; only if its mesh is animated
//! ```
//!
//! Each array begins at a multiple of 8. All numbers are little endian.

use super::prim::{Stored, StoredKind};

/// Size of a matrix, in bytes.
pub(super) const MATRIX: u64 = 16 * 8;

/// Offset of the numbers of an array after its number of elements, in bytes.
pub(super) const ARRAY_HEAD: u64 = 8;

/// Places of the values in the bytes of a frame.
#[derive(Debug, Default)]
pub(super) struct Layout {
    bytes: u64,
}

impl Layout {
    /// Adds an array of vectors.
    pub(super) fn add_vectors(&mut self, count: usize) -> Stored {
        self.add(StoredKind::Vectors3, ARRAY_HEAD + 12 * count as u64)
    }

    /// Adds a matrix.
    pub(super) fn add_matrix(&mut self) -> Stored {
        self.add(StoredKind::Matrix, MATRIX)
    }

    /// Returns the size of a frame, in bytes: a multiple of 8.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }

    fn add(&mut self, kind: StoredKind, bytes: u64) -> Stored {
        let at = self.bytes;
        self.bytes = (at + bytes).next_multiple_of(8);
        Stored { kind, at }
    }
}

/// Appends an array of vectors to the bytes of a frame.
pub(super) fn push_vectors(frame: &mut Vec<u8>, vectors: impl ExactSizeIterator<Item = [f32; 3]>) {
    frame.extend((vectors.len() as u64).to_le_bytes());
    frame.extend(vectors.flat_map(|vector| vector.map(f32::to_le_bytes)).flatten());
    frame.resize(frame.len().next_multiple_of(8), 0);
}

/// Appends the bounds of points.
pub(super) fn push_bounds(frame: &mut Vec<u8>, points: &[[f32; 3]]) {
    let fold = |start: f32, choose: fn(f32, f32) -> f32| {
        let choose = |a: [f32; 3], b: &[f32; 3]| std::array::from_fn(|axis| choose(a[axis], b[axis]));
        if points.is_empty() { [0.0; 3] } else { points.iter().fold([start; 3], choose) }
    };
    let bounds = [fold(f32::INFINITY, f32::min), fold(f32::NEG_INFINITY, f32::max)];
    push_vectors(frame, bounds.into_iter());
}

/// Appends a matrix that transforms column vectors.
pub(super) fn push_matrix(frame: &mut Vec<u8>, matrix: &nalgebra::Matrix4<f64>) {
    // The columns are the rows of the matrix that transforms row vectors.
    frame.extend(matrix.as_slice().iter().flat_map(|number| number.to_le_bytes()));
}
