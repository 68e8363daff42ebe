//! Meshes and numbers for unit tests.

use super::Mesh;

/// The faces of a box, counter-clockwise seen from outside. Corner k is at the offset (k & 1, k >> 1 & 1, k >> 2 & 1).
pub(crate) const BOX_FACES: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

/// Returns the corners of a box.
pub(crate) fn box_corners(low: [f64; 3], high: [f64; 3]) -> [[f64; 3]; 8] {
    std::array::from_fn(|k| std::array::from_fn(|a| if k >> a & 1 == 0 { low[a] } else { high[a] }))
}

/// Returns a box with 8 vertices and 6 faces.
pub(crate) fn cuboid(low: [f64; 3], high: [f64; 3]) -> Mesh {
    Mesh::new(box_corners(low, high).to_vec(), &BOX_FACES).unwrap()
}

/// Random numbers. A linear congruential generator (Knuth's MMIX) is random enough for tests.
pub(crate) struct Random(pub u64);

impl Random {
    /// Returns a number from 0 to 1.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a whole number from 0 to `n - 1`.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() * n as f64) as usize
    }
}
