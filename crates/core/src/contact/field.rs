//! What culling asks of a collider's shape: whether samples of some cells may touch it, and where they are.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8, f64x4};
use nalgebra::Point3;

use super::bounds::may_touch;
use super::quad::Quad;
use crate::contact::posed::PosedShape;
use crate::contact::samples::{SampleBlock, value};
use crate::lattice::polynomial;

/// A shape as seen by the samples of a body.
pub(super) trait Field {
    /// What is known of a cell: trilinear maps of its samples.
    type Cell;

    /// Whether a sample that lies between the vertices in these rows may be within the skin.
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool;

    /// What to know of a cell with corners in these rows.
    fn cell(&self, corners: &[u32; 8]) -> Self::Cell;

    /// Whether a sample of a block may be within the skin.
    fn may_touch_block<S: Simd>(&self, simd: S, cell: &Self::Cell, block: &SampleBlock, skin: f64) -> bool;

    /// The distances of four samples, by the monomials of their places.
    fn distances<S: Simd>(&self, simd: S, cell: &Self::Cell, monomials: &[f64x4<S>; 8]) -> f64x4<S>;
}

/// A plane, whose distance is as linear as places are: known everywhere where it is known of the vertices.
pub(super) struct Flat<'a> {
    /// Distance of the vertex in each row.
    pub(super) heights: &'a [f64],
}

/// The distances of the samples of a cell from a plane, as a polynomial.
pub(super) struct Heights {
    exact: [f64; 8],
    /// In f32, to pass over blocks.
    narrow: [f32; 8],
    /// What that may be wrong by.
    rounding: f32,
}

/// Any other shape.
pub(super) struct Curved<'a> {
    pub(super) shape: &'a PosedShape,
    /// Place of the vertex in each row.
    pub(super) places: &'a [Quad],
}

impl Field for Flat<'_> {
    type Cell = Heights;

    #[inline(always)]
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool {
        rows.iter().any(|&row| self.heights[row as usize] <= skin)
    }

    #[inline(always)]
    fn cell(&self, corners: &[u32; 8]) -> Heights {
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
        Heights { exact, narrow, rounding: 8.0 * f32::EPSILON * size }
    }

    #[inline(always)]
    fn may_touch_block<S: Simd>(&self, simd: S, cell: &Heights, block: &SampleBlock, skin: f64) -> bool {
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
    fn distances<S: Simd>(&self, simd: S, cell: &Heights, monomials: &[f64x4<S>; 8]) -> f64x4<S> {
        value(simd, &cell.exact, monomials)
    }
}

impl Field for Curved<'_> {
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

impl Curved<'_> {
    /// Where four samples are, by the monomials of their places.
    #[inline(always)]
    pub(super) fn places<S: Simd>(
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
