//! The exact volume of the trilinear cells, from their outer faces alone.

use fearless_simd::{Simd, dispatch};

use super::line::{Arm, Determinants, Line, Moving, load};
use super::measure::Scratch;
use super::sums::{ChunkedSum, DETERMINANTS, group_by_component};
use crate::parallel::Executor;
use crate::simd::level;

/// Sum over the faces of occupied cells that no other occupied cell shares; what inner faces add cancels.
///
/// A face of a trilinear cell is a bilinear patch, whose flux is the mean of its two triangulations:
/// `(a + b + c + d) . ((c - a) x (d - b)) / 24`, with `a b c d` in order around it, outside on the right-hand side.
#[derive(Clone, Debug)]
pub(super) struct CellMeasure {
    faces: Vec<[u32; 4]>,
    sums: ChunkedSum,
}

impl CellMeasure {
    pub(super) fn new(mut faces: Vec<[u32; 4]>, components: usize, of_vertex: &[u32]) -> Self {
        let counts = group_by_component(&mut faces, components, |face| of_vertex[face[0] as usize]);
        Self { faces, sums: ChunkedSum::new(&counts, DETERMINANTS) }
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.faces)
    }

    /// Adds the coefficients of each component to those of `scratch`.
    pub(super) fn add_coefficients(&self, executor: &Executor, scratch: &mut Scratch) {
        let Scratch { points, sums, coefficients, .. } = scratch;
        let faces = &self.faces;
        self.sums.add_to(
            executor,
            1.0 / 24.0,
            sums,
            coefficients,
            |range| dispatch!(level(), simd => sum(simd, &faces[range], points)),
        );
    }
}

/// The sum over some faces.
#[inline(always)]
fn sum<S: Simd>(simd: S, faces: &[[u32; 4]], points: &[Moving]) -> [f64; 4] {
    let mut sum = Determinants::zero(simd);
    for face in faces {
        let [a, b, c, d] = load(simd, points, face);
        let middle =
            Line::zxy(simd, a).plus(Line::zxy(simd, b)).plus(Line::zxy(simd, c).plus(Line::zxy(simd, d)));
        sum.add(middle, Arm::new(simd, c - a), Arm::new(simd, d - b));
    }
    sum.coefficients()
}

/// The corners of a cell's face in neighbour order (-x, +x, -y, +y, -z, +z), counter-clockwise seen from outside.
///
/// ```text
///        6-----7      corner k lies at (k & 1, k >> 1 & 1, k >> 2 & 1)
///       /|    /|
///      4-----5 |      z  y
///      | 2---|-3      | /
///      |/    |/       |/
///      0-----1        +--- x
/// ```
pub(super) const FACE_CORNERS: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(k: usize) -> [f64; 3] {
        [(k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2 & 1) as f64]
    }

    #[test]
    fn faces_look_outwards() {
        for (side, corners) in FACE_CORNERS.iter().enumerate() {
            let [a, b, _, d] = corners.map(corner);
            let (u, v): ([f64; 3], [f64; 3]) =
                (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| d[k] - a[k]));
            let normal: [f64; 3] =
                std::array::from_fn(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
            let mut expected = [0.0; 3];
            expected[side / 2] = if side % 2 == 0 { -1.0 } else { 1.0 };
            assert_eq!(normal, expected, "side {side}");
        }
    }
}
