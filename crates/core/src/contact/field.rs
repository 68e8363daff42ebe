//! Computes signed distances of a body's samples from a shape, and lower bounds that cull most samples.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8, f64x4};
use nalgebra::{Point3, Vector3};

use super::samples::SampleBlock;
use super::shape::PosedShape;
use super::vec4::Vec4;
use crate::lattice::{self, polynomial};
use crate::simd::lanes::LANES;

/// Signed distance of a body's samples from a shape, in cells.
///
/// A point is *within `skin`* if its signed distance is at most `skin`. A row is an index into
/// `SampleCells::vertices`.
pub(crate) trait Field {
    /// Trilinear interpolants in a cell: of the distance, or of the position.
    type Cell;

    /// Returns false only if no point in the convex hull of the vertices of `rows` is within `skin`. May
    /// return true in this case as well.
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool;

    /// Computes the interpolants of the cell whose corners have the rows `corners`.
    fn cell(&self, corners: &[u32; 8]) -> Self::Cell;

    /// Returns false only if no sample of a block of the cell is within `skin`. May return true in this case
    /// as well.
    fn may_touch_block<S: Simd>(&self, simd: S, cell: &Self::Cell, block: &SampleBlock, skin: f64) -> bool;

    /// Computes the distances of four samples from the monomials of their positions.
    fn distances<S: Simd>(&self, simd: S, cell: &Self::Cell, monomials: &[f64x4<S>; 8]) -> f64x4<S>;
}

/// Distance from a plane. It is linear in space, so its trilinear interpolant in a cell is exact.
pub(super) struct PlaneField<'a> {
    /// Signed distance of the vertex of each row.
    pub(super) heights: &'a [f64],
}

/// Distance from a plane within a cell, as a polynomial (coefficients of 1, x, y, xy, z, xz, yz, xyz).
pub(super) struct PlaneCell {
    coefficients: [f64; 8],
    /// The coefficients in f32, to cull blocks.
    coefficients_f32: [f32; 8],
    /// Bound of the rounding error of a distance computed in f32.
    rounding: f32,
}

/// Distance from a shape of any kind.
pub(crate) struct ShapeField<'a> {
    pub(crate) shape: &'a PosedShape,
    /// Position of the vertex of each row, in the body's frame.
    pub(crate) positions: &'a [Vec4],
}

impl Field for PlaneField<'_> {
    type Cell = PlaneCell;

    #[inline(always)]
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool {
        rows.iter().any(|&row| self.heights[row as usize] <= skin)
    }

    #[inline(always)]
    fn cell(&self, corners: &[u32; 8]) -> PlaneCell {
        let mut heights = [0.0; 8];
        for k in 0..8 {
            heights[k] = self.heights[corners[k] as usize];
        }
        let coefficients = polynomial(heights);
        let (mut coefficients_f32, mut sum) = ([0.0; 8], 0.0);
        for k in 0..8 {
            coefficients_f32[k] = coefficients[k] as f32;
            sum += coefficients_f32[k].abs();
        }
        PlaneCell { coefficients, coefficients_f32, rounding: 8.0 * f32::EPSILON * sum }
    }

    #[inline(always)]
    fn may_touch_block<S: Simd>(&self, simd: S, cell: &PlaneCell, block: &SampleBlock, skin: f64) -> bool {
        let t = &cell.coefficients_f32;
        let x = f32x8::load_array_ref(simd, &block.positions[0]);
        let y = f32x8::load_array_ref(simd, &block.positions[1]);
        let z = f32x8::load_array_ref(simd, &block.positions[2]);
        let splat = |value| f32x8::splat(simd, value);
        let lower = (splat(t[0]) + x * t[1]) + (splat(t[2]) + x * t[3]) * y;
        let upper = (splat(t[4]) + x * t[5]) + (splat(t[6]) + x * t[7]) * y;
        (lower + upper * z).simd_le(skin as f32 + cell.rounding).any_true()
    }

    #[inline(always)]
    fn distances<S: Simd>(&self, simd: S, cell: &PlaneCell, monomials: &[f64x4<S>; 8]) -> f64x4<S> {
        value(simd, &cell.coefficients, monomials)
    }
}

impl Field for ShapeField<'_> {
    type Cell = [[f64; 8]; 3];

    #[inline(always)]
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool {
        may_touch(self.shape, rows.iter().map(|&row| &self.positions[row as usize]), skin)
    }

    #[inline(always)]
    fn cell(&self, corners: &[u32; 8]) -> [[f64; 8]; 3] {
        let mut terms = [[0.0; 8]; 3];
        for c in 0..3 {
            for k in 0..8 {
                terms[c][k] = f64::from(self.positions[corners[k] as usize][c]);
            }
            terms[c] = polynomial(terms[c]);
        }
        terms
    }

    #[inline(always)]
    fn may_touch_block<S: Simd>(&self, _: S, _: &[[f64; 8]; 3], _: &SampleBlock, _: f64) -> bool {
        true
    }

    #[inline(always)]
    fn distances<S: Simd>(&self, simd: S, cell: &[[f64; 8]; 3], monomials: &[f64x4<S>; 8]) -> f64x4<S> {
        let points = self.positions(simd, cell, monomials);
        let mut distances = [0.0; 4];
        for lane in 0..4 {
            distances[lane] = self.shape.signed_distance(&points[lane]).distance;
        }
        f64x4::from_slice(simd, &distances)
    }
}

impl ShapeField<'_> {
    /// Computes the positions of four samples in the body's frame, from their monomials in the cell.
    #[inline(always)]
    pub(crate) fn positions<S: Simd>(
        &self,
        simd: S,
        cell: &[[f64; 8]; 3],
        monomials: &[f64x4<S>; 8],
    ) -> [Point3<f64>; 4] {
        let mut points = [Point3::origin(); 4];
        for c in 0..3 {
            let values = value(simd, &cell[c], monomials).to_array();
            for lane in 0..4 {
                points[lane][c] = values[lane];
            }
        }
        points
    }
}

/// Computes the monomials 1, x, y, xy, z, xz, yz, xyz at eight positions in a cell.
///
/// The first element of the result belongs to the first four positions, the second element to the last four.
/// `positions`: x, y and z of the positions, as in `SampleBlock::positions`.
#[inline(always)]
pub(crate) fn monomials<S: Simd>(simd: S, positions: &[[f32; LANES]; 3]) -> [[f64x4<S>; 8]; 2] {
    let one = f64x4::splat(simd, 1.0);
    let mut halves = [[one; 3]; 2];
    for a in 0..3 {
        (halves[0][a], halves[1][a]) = simd.widen_f32x8(f32x8::load_array_ref(simd, &positions[a]));
    }
    [lattice::monomials(one, halves[0]), lattice::monomials(one, halves[1])]
}

/// Evaluates a polynomial at four positions. `terms`: its coefficients, as returned by
/// [`polynomial`](crate::lattice::polynomial). `monomials`: the monomials of the positions.
#[inline(always)]
fn value<S: Simd>(simd: S, terms: &[f64; 8], monomials: &[f64x4<S>; 8]) -> f64x4<S> {
    let mut sum = f64x4::splat(simd, terms[0]);
    for k in 1..8 {
        sum += f64x4::splat(simd, terms[k]) * monomials[k];
    }
    sum
}

/// Returns false only if no point in the AABB of `positions` is within `skin` of the shape; see [`Field`].
/// May return true in this case as well.
///
/// Ignores coordinates that are NaN. If all coordinates along an axis are NaN, returns false.
pub(crate) fn may_touch<'a>(
    shape: &PosedShape,
    positions: impl Iterator<Item = &'a Vec4>,
    skin: f64,
) -> bool {
    let (center, half) = aabb(positions);
    shape.lower_bound(&center, &half) <= skin
}

/// Returns the center and half extents of the AABB of `positions`, enlarged by the rounding error.
fn aabb<'a>(positions: impl Iterator<Item = &'a Vec4>) -> (Point3<f64>, Vector3<f64>) {
    let (mut low, mut high) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for position in positions {
        for c in 0..4 {
            // Comparisons compile to one instruction for all components; `min` and `max` do not.
            low[c] = if position[c] < low[c] { position[c] } else { low[c] };
            high[c] = if position[c] > high[c] { position[c] } else { high[c] };
        }
    }
    let (low, high) = (low.map(f64::from), high.map(f64::from));
    let center = Point3::from(std::array::from_fn(|a| 0.5 * (low[a] + high[a])));
    // Rounding can move a sample slightly outside its cell.
    let half = Vector3::from_fn(|a, _| 0.5 * (high[a] - low[a]) * (1.0 + 1e-5));
    (center, half)
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;
    use crate::lattice::corner_sums;
    use crate::simd::level;

    /// Returns the trilinear weights of a cell's corners. Bit a of the number of a corner is the coordinate
    /// of the corner along axis a.
    fn trilinear(local: [f32; 3]) -> [f64; 8] {
        let t = local.map(f64::from);
        std::array::from_fn(|k| (0..3).map(|a| if k >> a & 1 == 1 { t[a] } else { 1.0 - t[a] }).product())
    }

    #[test]
    fn polynomial_values_and_corner_sums_match_trilinear_weights() {
        let corners = [5.0, -1.0, 2.0, 0.5, 8.0, 3.0, -4.0, 1.5];
        let positions = [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.875], [1.0, 0.0, 0.375]];
        let mut block = [[f32::NAN; LANES]; 3];
        for (lane, position) in positions.iter().enumerate() {
            (0..3).for_each(|a| block[a][2 * lane] = position[a]);
        }
        dispatch!(level(), simd => {
            let halves = monomials(simd, &block);
            let mut sums = [0.0; 8];
            for (lane, position) in positions.iter().enumerate() {
                let weights = trilinear(*position);
                let (half, lane) = (&halves[2 * lane / 4], 2 * lane % 4);
                let expected: f64 = weights.iter().zip(corners).map(|(w, c)| w * c).sum();
                let values = value(simd, &polynomial(corners), half).to_array();
                assert!((values[lane] - expected).abs() < 1e-13 && values[lane + 1].is_nan());
                (0..8).for_each(|k| sums[k] += half[k].to_array()[lane]);
            }
            let sums = corner_sums(sums);
            for k in 0..8 {
                let expected: f64 = positions.iter().map(|position| trilinear(*position)[k]).sum();
                assert!((sums[k] - expected).abs() < 1e-13);
            }
        });
    }
}
