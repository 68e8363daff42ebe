//! Computes the points of a smooth surface as points that move along straight lines: each by the smooth interpolant of
//! its cell.

use fearless_simd::{Simd, SimdBase, dispatch, f32x8, f32x16};

use super::line::{Moving, load};
use crate::lattice::{SmoothCoordinate, SmoothTerms, Smoothing, polynomial, smooth_value, trilinear_value};
use crate::simd::level;
use crate::simd::vector::Product;

/// Number of points that are computed at a time, one in each lane.
const POINTS: usize = 16;

/// Lanes of a [`Moving`] that are not zero.
const COMPONENTS: [usize; 6] = [0, 1, 2, 4, 5, 6];

/// Run of consecutive surface points in one cell.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// Corners of the cell.
    pub(super) corners: [u32; 8],
    /// Number of points.
    pub(super) points: usize,
}

/// The lattice of smooth surface points: the points, their slopes along the axes, and the slope weights.
#[derive(Clone, Copy)]
pub(super) struct SmoothLattice<'a> {
    pub(super) points: &'a [Moving],
    pub(super) slopes: &'a [[Moving; 3]],
    pub(super) slope_weights: &'a [f32],
}

/// Writes the slopes of the lattice points to `slopes`. A slope moves along a straight line, as the points do.
pub(super) fn update_slopes(smoothing: &Smoothing, points: &[Moving], slopes: &mut Vec<[Moving; 3]>) {
    slopes.resize(points.len(), [Moving::default(); 3]);
    dispatch!(level(), simd => {
        for stencil in smoothing.stencils() {
            let found = stencil.slopes(|vertex| load(simd, points, &[vertex])[0]);
            for (slope, out) in found.into_iter().zip(&mut slopes[stencil.vertex as usize]) {
                out.store(slope);
            }
        }
    });
}

/// Local coordinates of surface points in their cells.
#[derive(Clone, Debug)]
pub(super) struct LocalCoordinates {
    /// The coordinates along each axis, with some more zeros at the end.
    axes: [Vec<f32>; 3],
}

impl LocalCoordinates {
    pub(super) fn new(points: impl Iterator<Item = [f32; 3]>) -> Self {
        let mut axes = [const { Vec::new() }; 3];
        for point in points.chain([[0.0; 3]; POINTS]) {
            axes.iter_mut().zip(point).for_each(|(axis, x)| axis.push(x));
        }
        Self { axes }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.axes.iter().map(|axis| size_of_val(&**axis)).sum()
    }

    /// Loads the coordinates of [`POINTS`] consecutive points.
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, first: usize) -> [f32x16<S>; 3] {
        let mut coordinates = [f32x16::splat(simd, 0.0); 3];
        for axis in 0..3 {
            coordinates[axis] = f32x16::from_slice(simd, &self.axes[axis][first..first + POINTS]);
        }
        coordinates
    }
}

/// The coefficients of a cell. The moving points are stored lane by lane, so that all coefficients of a lane
/// are consecutive.
struct CellTerms {
    /// The smooth interpolant of each lane.
    smooth: [SmoothTerms<f32>; 8],
    /// The trilinear interpolant of each lane.
    linear: [[f32; 8]; 8],
    slope_weights: [f32; 8],
    /// Whether the slope weight is 1 in the whole cell.
    has_full_weight: bool,
}

impl CellTerms {
    #[inline(always)]
    fn new<S: Simd>(simd: S, cell: &[u32; 8], lattice: SmoothLattice<'_>) -> Self {
        let corners = load(simd, lattice.points, cell);
        let (mut slopes, mut slope_weights) = ([[corners[0]; 3]; 8], [0.0; 8]);
        for k in 0..8 {
            let corner = cell[k] as usize;
            slopes[k] = load(simd, &lattice.slopes[corner], &[0, 1, 2]);
            slope_weights[k] = lattice.slope_weights[corner];
        }
        let has_full_weight = slope_weights == [1.0; 8];
        let smooth = [SmoothTerms([[0.0; 8]; 4]); 8];
        let mut terms =
            Self { smooth, linear: [[0.0; 8]; 8], slope_weights: polynomial(slope_weights), has_full_weight };
        let (smooth, linear) = (SmoothTerms::new(corners, slopes), transposed(simd, polynomial(corners)));
        for c in 0..8 {
            linear[c].store_array(&mut terms.linear[c]);
        }
        for group in 0..4 {
            let lanes = transposed(simd, smooth.0[group]);
            for c in 0..8 {
                lanes[c].store_array(&mut terms.smooth[c].0[group]);
            }
        }
        terms
    }

    /// Returns lane `c` of [`POINTS`] moving points at local coordinates.
    #[inline(always)]
    fn at<S: Simd>(
        &self,
        c: usize,
        local: [f32x16<S>; 3],
        functions: [SmoothCoordinate<f32x16<S>>; 3],
    ) -> f32x16<S> {
        // Points of the surface are up to 0.002 cells outside their cell, where the polynomial is accurate enough.
        let mut offset = smooth_value(&self.smooth[c], functions);
        let mut linear = self.linear[c];
        let corner = std::mem::take(&mut linear[0]);
        if !self.has_full_weight {
            let (linear, [x, y, z]) = (trilinear_value(&linear, local), functions);
            offset =
                trilinear_value(&self.slope_weights, [x.s, y.s, z.s]).times_plus(offset - linear, linear);
        }
        offset + corner
    }
}

/// Transposes eight rows of eight lanes.
#[inline(always)]
fn transposed<S: Simd>(simd: S, mut rows: [f32x8<S>; 8]) -> [f32x8<S>; 8] {
    // Each perfect shuffle moves the highest bit of the row to the lowest bit of the lane.
    for _ in 0..3 {
        let before = rows;
        for row in 0..4 {
            (rows[2 * row], rows[2 * row + 1]) = simd.interleave_f32x8(before[row], before[row + 4]);
        }
    }
    rows
}

/// Computes the points of consecutive runs. `first`: index of the first point in `local`.
#[inline(always)]
pub(super) fn interpolate_smooth<S: Simd>(
    simd: S,
    runs: &[Run],
    lattice: SmoothLattice<'_>,
    (local, mut first): (&LocalCoordinates, usize),
    mut surface_points: &mut [Moving],
) {
    for run in runs {
        let terms = CellTerms::new(simd, &run.corners, lattice);
        let (run_points, later_points) = surface_points.split_at_mut(run.points);
        for (group, points) in run_points.chunks_mut(POINTS).enumerate() {
            let local = local.load(simd, first + group * POINTS);
            let mut functions = [SmoothCoordinate { s: local[0], e: local[0], k: local[0] }; 3];
            for axis in 0..3 {
                functions[axis] = SmoothCoordinate::new(local[axis]);
            }
            let mut rows = [f32x16::splat(simd, 0.0); 8];
            for c in COMPONENTS {
                rows[c] = terms.at(c, local, functions);
            }
            store(simd, rows, points);
        }
        first += run.points;
        surface_points = later_points;
    }
}

/// Stores the first of [`POINTS`] points, whose lanes are the columns of `rows`.
#[inline(always)]
fn store<S: Simd>(simd: S, mut rows: [f32x16<S>; 8], points: &mut [Moving]) {
    // As in `transposed`, with twice the lanes: row `k` of the result has points `2 k` and `2 k + 1`.
    for _ in 0..3 {
        let before = rows;
        for row in 0..4 {
            (rows[2 * row], rows[2 * row + 1]) = simd.interleave_f32x16(before[row], before[row + 4]);
        }
    }
    for (points, pair) in points.chunks_mut(2).zip(rows) {
        let (first, second) = simd.split_f32x16(pair);
        points[0].store(first);
        if let Some(point) = points.get_mut(1) {
            point.store(second);
        }
    }
}
