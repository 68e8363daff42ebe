//! Distance fields: signed distances of a body's samples from a shape, and bounds that cull most samples.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8, f64x4};
use nalgebra::{Point3, Vector3};

use super::samples::SampleBlock;
use super::shape::PosedShape;
use super::vec4::Vec4;
use crate::lattice::{self, polynomial};
use crate::simd::lanes::LANES;

/// Signed distance of a body's samples from a shape.
pub(crate) trait Field {
    /// Trilinear interpolants in a cell: of the distance, or of the position.
    type Cell;

    /// Returns whether a point in the convex hull of the vertices in `rows` may be within `skin`.
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool;

    /// Computes the interpolants of the cell whose corners have these rows.
    fn cell(&self, corners: &[u32; 8]) -> Self::Cell;

    /// Returns whether a sample of a block may be within `skin`.
    fn may_touch_block<S: Simd>(&self, simd: S, cell: &Self::Cell, block: &SampleBlock, skin: f64) -> bool;

    /// Computes the distances of four samples from the monomials of their positions.
    fn distances<S: Simd>(&self, simd: S, cell: &Self::Cell, monomials: &[f64x4<S>; 8]) -> f64x4<S>;
}

/// Distance from a plane: linear in space, so its trilinear interpolant in a cell is exact.
pub(super) struct PlaneField<'a> {
    /// Signed distance of the vertex in each row.
    pub(super) heights: &'a [f64],
}

/// Distance from a plane within a cell, as a polynomial (coefficients of 1, x, y, xy, z, xz, yz, xyz).
pub(super) struct PlaneCell {
    exact: [f64; 8],
    /// Coefficients in f32, to cull blocks.
    narrow: [f32; 8],
    /// Bound of the rounding error of `narrow`.
    rounding: f32,
}

/// Distance from a shape of any kind.
pub(crate) struct ShapeField<'a> {
    pub(crate) shape: &'a PosedShape,
    /// Position of the vertex in each row.
    pub(crate) places: &'a [Vec4],
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
        let exact = polynomial(heights);
        let (mut narrow, mut size) = ([0.0; 8], 0.0);
        for k in 0..8 {
            narrow[k] = exact[k] as f32;
            size += narrow[k].abs();
        }
        PlaneCell { exact, narrow, rounding: 8.0 * f32::EPSILON * size }
    }

    #[inline(always)]
    fn may_touch_block<S: Simd>(&self, simd: S, cell: &PlaneCell, block: &SampleBlock, skin: f64) -> bool {
        let t = &cell.narrow;
        let x = f32x8::load_array_ref(simd, &block.places[0]);
        let y = f32x8::load_array_ref(simd, &block.places[1]);
        let z = f32x8::load_array_ref(simd, &block.places[2]);
        let all = |value| f32x8::splat(simd, value);
        let lower = (all(t[0]) + x * t[1]) + (all(t[2]) + x * t[3]) * y;
        let upper = (all(t[4]) + x * t[5]) + (all(t[6]) + x * t[7]) * y;
        (lower + upper * z).simd_le(skin as f32 + cell.rounding).any_true()
    }

    #[inline(always)]
    fn distances<S: Simd>(&self, simd: S, cell: &PlaneCell, monomials: &[f64x4<S>; 8]) -> f64x4<S> {
        value(simd, &cell.exact, monomials)
    }
}

impl Field for ShapeField<'_> {
    type Cell = [[f64; 8]; 3];

    #[inline(always)]
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool {
        may_touch(self.shape, rows.iter().map(|&row| &self.places[row as usize]), skin)
    }

    #[inline(always)]
    fn cell(&self, corners: &[u32; 8]) -> [[f64; 8]; 3] {
        let mut terms = [[0.0; 8]; 3];
        for c in 0..3 {
            for k in 0..8 {
                terms[c][k] = f64::from(self.places[corners[k] as usize][c]);
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
        let points = self.places(simd, cell, monomials);
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
    pub(crate) fn places<S: Simd>(
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

/// Computes the monomials 1, x, y, xy, z, xz, yz, xyz at eight positions, four in each half.
#[inline(always)]
pub(crate) fn monomials<S: Simd>(simd: S, places: &[[f32; LANES]; 3]) -> [[f64x4<S>; 8]; 2] {
    let one = f64x4::splat(simd, 1.0);
    let mut halves = [[one; 3]; 2];
    for a in 0..3 {
        (halves[0][a], halves[1][a]) = simd.widen_f32x8(f32x8::load_array_ref(simd, &places[a]));
    }
    [lattice::monomials(one, halves[0]), lattice::monomials(one, halves[1])]
}

/// Evaluates a [`polynomial`](crate::lattice::polynomial) from its monomials.
#[inline(always)]
fn value<S: Simd>(simd: S, terms: &[f64; 8], monomials: &[f64x4<S>; 8]) -> f64x4<S> {
    let mut sum = f64x4::splat(simd, terms[0]);
    for k in 1..8 {
        sum += f64x4::splat(simd, terms[k]) * monomials[k];
    }
    sum
}

/// Returns whether a point in the AABB of `places` may be within `skin` of the shape; false for NaN.
pub(crate) fn may_touch<'a>(shape: &PosedShape, places: impl Iterator<Item = &'a Vec4>, skin: f64) -> bool {
    let (center, half) = bounds(places);
    shape.lower_bound(&center, &half) <= skin
}

/// Returns the center and half extents of the AABB of `places`, enlarged by the rounding error.
fn bounds<'a>(places: impl Iterator<Item = &'a Vec4>) -> (Point3<f64>, Vector3<f64>) {
    let (mut low, mut high) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for place in places {
        for c in 0..4 {
            // Comparisons compile to one instruction for all components; `min` and `max` do not.
            low[c] = if place[c] < low[c] { place[c] } else { low[c] };
            high[c] = if place[c] > high[c] { place[c] } else { high[c] };
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

    /// Returns the trilinear weights of a cell's corners, numbered by bits: x is bit 0, y is bit 1, z is bit
    /// 2.
    fn trilinear(local: [f32; 3]) -> [f64; 8] {
        let t = local.map(f64::from);
        std::array::from_fn(|k| (0..3).map(|a| if k >> a & 1 == 1 { t[a] } else { 1.0 - t[a] }).product())
    }

    #[test]
    fn polynomial_values_and_corner_sums_match_trilinear_weights() {
        let corners = [5.0, -1.0, 2.0, 0.5, 8.0, 3.0, -4.0, 1.5];
        let places = [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.875], [1.0, 0.0, 0.375]];
        let mut block = [[f32::NAN; LANES]; 3];
        for (lane, place) in places.iter().enumerate() {
            (0..3).for_each(|a| block[a][2 * lane] = place[a]);
        }
        dispatch!(level(), simd => {
            let halves = monomials(simd, &block);
            let mut sums = [0.0; 8];
            for (lane, place) in places.iter().enumerate() {
                let weights = trilinear(*place);
                let (half, lane) = (&halves[2 * lane / 4], 2 * lane % 4);
                let expected: f64 = weights.iter().zip(corners).map(|(w, c)| w * c).sum();
                let values = value(simd, &polynomial(corners), half).to_array();
                assert!((values[lane] - expected).abs() < 1e-13 && values[lane + 1].is_nan());
                (0..8).for_each(|k| sums[k] += half[k].to_array()[lane]);
            }
            let sums = corner_sums(sums);
            for k in 0..8 {
                let expected: f64 = places.iter().map(|place| trilinear(*place)[k]).sum();
                assert!((sums[k] - expected).abs() < 1e-13);
            }
        });
    }
}
