//! Computes signed distances of a body's samples from a shape, and lower bounds that cull most samples.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8, f64x4};
use nalgebra::{Point3, Vector3};

use super::interpolant::{SmoothInterpolant, value};
use super::samples::SampleBlock;
use super::shape::PosedShape;
use super::smooth_rows::RowSlopes;
use super::vec4::{Vec4, wide};
use crate::lattice::polynomial;

/// Greatest sum of the magnitudes of the weights of the slopes along an axis in a smooth position: the maximum of
/// `t (1 - t)² + t² (1 - t)`. A smooth position is in the convex hull of the corners, enlarged by this multiple of the
/// greatest slope along each axis.
const SLOPE_BOUND: f64 = 0.25;

/// Greatest displacement of a smooth position, relative to the greatest displacement of a lattice vertex: a slope along
/// each axis changes by at most twice the displacement of a vertex.
pub(super) const SMOOTH_DISPLACEMENT: f64 = 1.0 + 6.0 * SLOPE_BOUND;

/// Signed distance of a body's samples from a shape, in cells.
///
/// A point is *within `skin`* if its signed distance is at most `skin`. A row is an index into
/// `SampleCells::vertices`.
pub(super) trait Field {
    /// Interpolants in a cell: of the distance, or of the position.
    type Cell;

    /// Returns false only if no sample in the cells with the corners `rows` is within `skin`. May return true in this
    /// case as well.
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
    /// Slopes of the distances, if the skin is smooth.
    pub(super) slopes: Option<HeightSlopes<'a>>,
}

/// Slopes of the distances from a plane of all rows, and the slope weights.
#[derive(Clone, Copy)]
pub(super) struct HeightSlopes<'a> {
    pub(super) slopes: &'a [[f64; 3]],
    pub(super) slope_weights: &'a [f32],
}

/// Distance from a plane within a cell, as a polynomial (coefficients of 1, x, y, xy, z, xz, yz, xyz).
pub(super) struct PlaneCell {
    coefficients: [f64; 8],
    /// The coefficients in f32, to cull blocks.
    coefficients_f32: [f32; 8],
    /// Bound of the rounding error of a distance computed in f32.
    rounding: f32,
    /// The smooth distance, if the skin is smooth.
    smooth: Option<SmoothInterpolant>,
}

/// Distance from a shape of any kind.
#[derive(Clone, Copy)]
pub(super) struct ShapeField<'a> {
    pub(super) shape: &'a PosedShape<'a>,
    /// Position of the vertex of each row, in the body's frame.
    pub(super) positions: &'a [Vec4],
    /// Slopes of the positions, if the skin is smooth.
    pub(super) slopes: Option<RowSlopes<'a>>,
}

/// Position within a cell: for each coordinate, the coefficients of the trilinear interpolant, and the smooth
/// interpolant if the skin is smooth.
pub(super) type ShapeCell = [([f64; 8], Option<SmoothInterpolant>); 3];

impl Field for PlaneField<'_> {
    type Cell = PlaneCell;

    #[inline(always)]
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool {
        let Some(HeightSlopes { slopes, .. }) = self.slopes else {
            return rows.iter().any(|&row| self.heights[row as usize] <= skin);
        };
        let (mut lowest, mut greatest) = (f64::INFINITY, [0.0_f64; 3]);
        for &row in rows {
            lowest = lowest.min(self.heights[row as usize]);
            for axis in 0..3 {
                greatest[axis] = greatest[axis].max(slopes[row as usize][axis].abs());
            }
        }
        lowest - SLOPE_BOUND * (greatest[0] + greatest[1] + greatest[2]) <= skin
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
        let smooth = self.slopes.and_then(|HeightSlopes { slopes, slope_weights }| {
            let (mut corner_slopes, mut corner_weights) = ([[0.0; 3]; 8], [0.0; 8]);
            for k in 0..8 {
                corner_slopes[k] = slopes[corners[k] as usize];
                corner_weights[k] = f64::from(slope_weights[corners[k] as usize]);
            }
            SmoothInterpolant::new(heights, corner_slopes, corner_weights)
        });
        PlaneCell { coefficients, coefficients_f32, rounding: 8.0 * f32::EPSILON * sum, smooth }
    }

    #[inline(always)]
    fn may_touch_block<S: Simd>(&self, simd: S, cell: &PlaneCell, block: &SampleBlock, skin: f64) -> bool {
        if cell.smooth.is_some() {
            return true;
        }
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
        match &cell.smooth {
            None => value(simd, &cell.coefficients, monomials),
            Some(smooth) => smooth.value(simd, &cell.coefficients, monomials),
        }
    }
}

impl Field for ShapeField<'_> {
    type Cell = ShapeCell;

    #[inline(always)]
    fn may_touch(&self, rows: &[u32], skin: f64) -> bool {
        match self.slopes {
            None => may_touch(self.shape, rows.iter().map(|&row| &self.positions[row as usize]), skin),
            Some(RowSlopes { slopes, .. }) => {
                let rows = rows.iter().map(|&row| row as usize);
                smooth_may_touch(self.shape, rows.map(|row| (&self.positions[row], &slopes[row])), skin)
            }
        }
    }

    #[inline(always)]
    fn cell(&self, corners: &[u32; 8]) -> ShapeCell {
        let mut cell = [([0.0; 8], None), ([0.0; 8], None), ([0.0; 8], None)];
        for c in 0..3 {
            let mut values = [0.0; 8];
            for k in 0..8 {
                values[k] = f64::from(self.positions[corners[k] as usize][c]);
            }
            cell[c].0 = polynomial(values);
            if let Some(RowSlopes { slopes, slope_weights }) = self.slopes {
                let (mut corner_slopes, mut corner_weights) = ([[0.0; 3]; 8], [0.0; 8]);
                for k in 0..8 {
                    for axis in 0..3 {
                        corner_slopes[k][axis] = f64::from(slopes[corners[k] as usize][axis][c]);
                    }
                    corner_weights[k] = f64::from(slope_weights[corners[k] as usize]);
                }
                cell[c].1 = SmoothInterpolant::new(values, corner_slopes, corner_weights);
            }
        }
        cell
    }

    #[inline(always)]
    fn may_touch_block<S: Simd>(&self, _: S, _: &ShapeCell, _: &SampleBlock, _: f64) -> bool {
        true
    }

    #[inline(always)]
    fn distances<S: Simd>(&self, simd: S, cell: &ShapeCell, monomials: &[f64x4<S>; 8]) -> f64x4<S> {
        let points = self.positions(simd, cell, monomials);
        let mut distances = [0.0; 4];
        for lane in 0..4 {
            distances[lane] = self.shape.signed_distance(&points[lane]).distance;
        }
        f64x4::from_slice(simd, &distances)
    }
}

impl ShapeField<'_> {
    /// Returns false only if no sample is within `skin`. May return true in this case as well.
    pub(super) fn any_may_touch(&self, skin: f64) -> bool {
        match self.slopes {
            None => {
                let (center, half) = aabb_of_all(self.positions);
                self.shape.may_touch(&center, &half, skin)
            }
            Some(RowSlopes { slopes, .. }) => {
                smooth_may_touch(self.shape, self.positions.iter().zip(slopes), skin)
            }
        }
    }

    /// Computes the positions of four samples in the body's frame, from their monomials in the cell.
    #[inline(always)]
    pub(super) fn positions<S: Simd>(
        &self,
        simd: S,
        cell: &ShapeCell,
        monomials: &[f64x4<S>; 8],
    ) -> [Point3<f64>; 4] {
        let mut points = [Point3::origin(); 4];
        for c in 0..3 {
            let values = match &cell[c] {
                (linear, None) => value(simd, linear, monomials),
                (linear, Some(smooth)) => smooth.value(simd, linear, monomials),
            };
            let values = values.to_array();
            for lane in 0..4 {
                points[lane][c] = values[lane];
            }
        }
        points
    }
}

/// Returns false only if no point in the AABB of `positions` is within `skin` of the shape; see [`Field`].
/// May return true in this case as well.
///
/// Ignores coordinates that are NaN. If all coordinates along an axis are NaN, returns false.
fn may_touch<'a>(shape: &PosedShape<'_>, positions: impl Iterator<Item = &'a Vec4>, skin: f64) -> bool {
    let (center, half) = aabb(positions);
    shape.may_touch(&center, &half, skin)
}

/// As [`may_touch`], for the smooth positions in the cells around vertices with these positions and slopes.
fn smooth_may_touch<'a>(
    shape: &PosedShape<'_>,
    vertices: impl Iterator<Item = (&'a Vec4, &'a [Vec4; 3])>,
    skin: f64,
) -> bool {
    let mut greatest = [Vec4::zeros(); 3];
    let positions = vertices.inspect(|(_, slopes)| {
        for (greatest, slope) in greatest.iter_mut().zip(*slopes) {
            for c in 0..4 {
                // Ignores NaN, as `aabb` does.
                let length = slope[c].abs();
                greatest[c] = if length > greatest[c] { length } else { greatest[c] };
            }
        }
    });
    let (center, half) = aabb(positions.map(|(position, _)| position));
    let reach = wide(&(greatest[0] + greatest[1] + greatest[2])) * SLOPE_BOUND;
    shape.may_touch(&center, &(half + reach), skin)
}

/// Returns false only if no smooth position of a body whose vertices have this AABB is within `skin` of the shape,
/// whatever the slopes are.
///
/// A slope is a difference of two positions, so its components are at most the extents of the AABB, twice its half
/// extents.
pub(super) fn may_touch_for_any_slopes(shape: &PosedShape<'_>, (center, half): &Aabb, skin: f64) -> bool {
    shape.may_touch(center, &(half * (1.0 + 6.0 * SLOPE_BOUND)), skin)
}

/// Center and half extents of an AABB, enlarged by the rounding error.
pub(super) type Aabb = (Point3<f64>, Vector3<f64>);

/// Returns the AABB of `positions`.
fn aabb<'a>(positions: impl Iterator<Item = &'a Vec4>) -> Aabb {
    let mut extremes = Extremes::NONE;
    positions.for_each(|position| extremes.add(position));
    extremes.aabb()
}

/// Returns the AABB of `positions`, with the bits of [`aabb`].
pub(super) fn aabb_of_all(positions: &[Vec4]) -> Aabb {
    // Four independent extremes, which the processor can compute in parallel.
    let mut four = [Extremes::NONE; 4];
    let (chunks, rest) = positions.as_chunks::<4>();
    for chunk in chunks {
        for (extremes, position) in four.iter_mut().zip(chunk) {
            extremes.add(position);
        }
    }
    let [mut all, others @ ..] = four;
    let others = others.iter().flat_map(|extremes| [&extremes.low, &extremes.high]);
    others.chain(rest).for_each(|position| all.add(position));
    all.aabb()
}

/// The least and the greatest of each component of positions. NaN does not count.
#[derive(Clone, Copy)]
struct Extremes {
    low: Vec4,
    high: Vec4,
}

impl Extremes {
    const NONE: Self = Self {
        low: Vec4::new(f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY),
        high: Vec4::new(f32::NEG_INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY),
    };

    #[inline(always)]
    fn add(&mut self, position: &Vec4) {
        let Self { low, high } = self;
        for c in 0..4 {
            // Comparisons compile to one instruction for all components; `min` and `max` do not.
            low[c] = if position[c] < low[c] { position[c] } else { low[c] };
            high[c] = if position[c] > high[c] { position[c] } else { high[c] };
        }
    }

    fn aabb(&self) -> Aabb {
        let (low, high) = (wide(&self.low), wide(&self.high));
        // Rounding can move a sample slightly outside its cell.
        (((low + high) * 0.5).into(), (high - low) * 0.5 * (1.0 + 1e-5))
    }
}
