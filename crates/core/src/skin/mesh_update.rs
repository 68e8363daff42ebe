//! The update of the mesh: interpolates mesh vertices from the corners of their lattice cells, trilinearly
//! ([`interpolate_cell`]) or smoothly ([`interpolate_smooth_cell`]).
//!
//! A chunk consists of the mesh vertices, here called points, that are interpolated into one tile; see
//! `skin`. Two points that share a SIMD register are called a pair.

use fearless_simd::{Simd, SimdBase, dispatch, f32x4, f32x8};

use super::one_ring_blocks::TileLayout;
use super::pose::{ComponentMotion, Pose};
use crate::lattice::{
    Embedding, PointMap, Slopes, SmoothCoordinate, SmoothTerms, polynomial, smooth_value, trilinear_value,
};
use crate::simd::level;
use crate::simd::moving::{Moving, position_at};
use crate::simd::vector::Product;
use crate::simd::xyzx::{Pair, Xyzx, broadcast_lanes, xyzx};

/// Largest product of the distances of a point from its cell along two axes (for a smooth skin, largest square of a
/// distance), in squared cells, for which the polynomial of the cell is used. The polynomial and the linear
/// continuation of the cell then differ by less than the rounding error of `f32`.
const MAX_OUTSIDE: f32 = 1e-8;

/// Points in the order of their interpolation: by chunk, and within a chunk by cell.
///
/// The number of points of each cell in a chunk is even, because the last point is stored twice if necessary.
#[derive(Clone, Debug, Default)]
pub(super) struct EmbeddedPoints {
    /// Lattice vertices at the corners of each cell that contains points.
    corners: Vec<[u32; 8]>,
    /// End of each chunk in the arrays below.
    ends: Vec<Ends>,
    /// The cells of each chunk.
    runs: Vec<CellRun>,
    /// Local coordinates of each pair of points in their cell: `(u, v, w, u)` of both points.
    coords: Vec<Pair>,
    /// Ranks of each pair of points, for a smooth skin; see `SurfaceMotion`.
    sources: Vec<[u32; 2]>,
    /// Points that need the linear continuation of their cell: row in the tile, and index in `corners`.
    outliers: Vec<(u32, u32)>,
}

/// Ends of one chunk in the arrays of [`EmbeddedPoints`].
#[derive(Clone, Copy, Debug, Default)]
struct Ends {
    runs: usize,
    coords: usize,
    outliers: usize,
}

/// The points of one cell in one chunk.
#[derive(Clone, Debug)]
struct CellRun {
    /// Index in `corners`.
    cell: u32,
    /// Number of pairs of points.
    pairs: u32,
}

/// Builder of [`EmbeddedPoints`]. Chunks are added with [`TileLayout::add`].
pub(super) struct EmbeddedPointsBuilder {
    /// Cell of each point (index in `corners`), and local coordinates of the point in the cell.
    points: Vec<(u32, [f32; 3])>,
    /// Rank of each point: its index in the order of [`Embedding::by_cell`].
    ranks: Vec<u32>,
    is_smooth: bool,
    embedded: EmbeddedPoints,
}

impl EmbeddedPointsBuilder {
    /// Creates a builder without chunks. `points[k]` is the index in the embedding of point `k`.
    pub(super) fn new(embedding: &Embedding, points: &[u32]) -> Self {
        let mut cell_of = vec![0; embedding.len()];
        let mut embedded = EmbeddedPoints::default();
        for (cell, group) in (0..).zip(embedding.by_cell()) {
            embedded.corners.push(*group.corners);
            group.points.iter().for_each(|&point| cell_of[point as usize] = cell);
        }
        let entry = |&point: &u32| (cell_of[point as usize], embedding.local(point as usize));
        let mut rank_of = vec![0; embedding.len()];
        let order = embedding.by_cell().flat_map(|cell| cell.points);
        (0..).zip(order).for_each(|(rank, &point)| rank_of[point as usize] = rank);
        Self {
            points: points.iter().map(entry).collect(),
            ranks: points.iter().map(|&point| rank_of[point as usize]).collect(),
            is_smooth: embedding.smoothing().is_some(),
            embedded,
        }
    }

    /// Returns the points of all chunks that were added.
    pub(super) fn finish(self) -> EmbeddedPoints {
        self.embedded
    }

    /// Returns the indices of `points`, sorted by the cell of the point.
    fn by_cell(&self, points: &[u32]) -> Vec<usize> {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by_key(|&k| self.points[points[k] as usize].0);
        order
    }
}

impl TileLayout for EmbeddedPointsBuilder {
    fn rows(&self, points: &[u32]) -> Vec<usize> {
        let cell = |&k: &usize| self.points[points[k] as usize].0;
        let mut rows = vec![0; points.len()];
        let mut first = 0;
        for run in self.by_cell(points).chunk_by(|a, b| cell(a) == cell(b)) {
            (first..).zip(run).for_each(|(row, &k)| rows[k] = row);
            first += run.len().next_multiple_of(2);
        }
        rows
    }

    /// Appends a chunk. If a cell has an odd number of points, the last point of the cell is stored twice.
    fn add(&mut self, points: &[u32]) {
        let order = self.by_cell(points);
        let point = |&k: &usize| self.points[points[k] as usize];
        let is_smooth = self.is_smooth;
        let rank = |&k: &usize| self.ranks[points[k] as usize];
        let EmbeddedPoints { ends, runs, coords, sources, outliers, .. } = &mut self.embedded;
        let begin = coords.len();
        for run in order.chunk_by(|a, b| point(a).0 == point(b).0) {
            let cell = point(&run[0]).0;
            let first = 2 * (coords.len() - begin) as u32;
            let outside = (first..).zip(run).filter(|(_, k)| is_outside(point(k).1, is_smooth));
            outliers.extend(outside.map(|(row, _)| (row, cell)));
            coords.extend(run.chunks(2).map(|pair| {
                let (first, last) = (&pair[0], &pair[pair.len() - 1]);
                let ([a, b, c], [d, e, f]) = (point(first).1, point(last).1);
                [a, b, c, a, d, e, f, d]
            }));
            if is_smooth {
                sources.extend(run.chunks(2).map(|pair| [rank(&pair[0]), rank(&pair[pair.len() - 1])]));
            }
            runs.push(CellRun { cell, pairs: run.len().div_ceil(2) as u32 });
        }
        ends.push(Ends { runs: runs.len(), coords: coords.len(), outliers: outliers.len() });
    }
}

impl EmbeddedPoints {
    /// Returns the number of interpolated points, including the points that are stored twice.
    pub(super) fn len(&self) -> usize {
        2 * self.coords.len()
    }

    /// Returns the memory of the tables, in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { corners, ends, runs, coords, sources, outliers } = self;
        let tables = size_of_val(&**corners) + size_of_val(&**ends) + size_of_val(&**runs);
        tables + size_of_val(&**sources) + size_of_val(&**coords) + size_of_val(&**outliers)
    }

    /// Writes the positions of the points of a chunk to `pairs`, given the positions of the lattice vertices.
    ///
    /// Positions are in cells from the origin of the body frame.
    pub(super) fn interpolate(&self, chunk: usize, pose: Pose, pairs: &mut [Pair]) {
        let Pose { lattice, slopes, motion, .. } = pose;
        let begin = if chunk == 0 { Ends::default() } else { self.ends[chunk - 1] };
        let end = self.ends[chunk];
        let coords = &self.coords[begin.coords..end.coords];
        let runs = &self.runs[begin.runs..end.runs];
        if let Some(motion) = motion {
            let mut remaining = (&self.sources[begin.coords..end.coords], &mut *pairs);
            for run in runs {
                let (sources, later_sources) = remaining.0.split_at(run.pairs as usize);
                let (pairs, later_pairs) = remaining.1.split_at_mut(run.pairs as usize);
                let component = motion.component_of_vertex[self.corners[run.cell as usize][0] as usize];
                let component = &motion.components[component as usize];
                dispatch!(level(), simd => move_points(simd, component, motion.points, sources, pairs));
                remaining = (later_sources, later_pairs);
            }
        } else {
            dispatch!(level(), simd => {
                let mut remaining = (coords, &mut *pairs);
                for run in runs {
                    let (coords, later_coords) = remaining.0.split_at(run.pairs as usize);
                    let (pairs, later_pairs) = remaining.1.split_at_mut(run.pairs as usize);
                    let corners = &self.corners[run.cell as usize];
                    match slopes {
                        None => interpolate_cell(simd, corners, lattice, coords, pairs),
                        Some(slopes) => interpolate_smooth_cell(simd, corners, lattice, slopes, coords, pairs),
                    }
                    remaining = (later_coords, later_pairs);
                }
            });
        }
        for &(row, cell) in &self.outliers[begin.outliers..end.outliers] {
            let (pair, half) = (row as usize / 2, row as usize % 2 * 4);
            let local = [0, 1, 2].map(|axis| coords[pair][half + axis]);
            let outlier = PointMap::new(&self.corners[cell as usize], lattice, slopes).at(local);
            pairs[pair][half..half + 4].copy_from_slice(&xyzx(outlier));
        }
    }
}

/// Returns whether the polynomial and the linear continuation of a cell differ at local coordinates. The trilinear
/// polynomial is linear along each axis, and the smooth one is not.
fn is_outside(local: [f32; 3], is_smooth: bool) -> bool {
    let [u, v, w] = local.map(|x| (x - x.clamp(0.0, 1.0)).abs());
    // Coordinates that are not finite count as outside.
    let use_polynomial = match is_smooth {
        false => u * v <= MAX_OUTSIDE && v * w <= MAX_OUTSIDE && w * u <= MAX_OUTSIDE,
        true => u * u <= MAX_OUTSIDE && v * v <= MAX_OUTSIDE && w * w <= MAX_OUTSIDE,
    };
    !use_polynomial
}

/// Moves pairs of points to the ends of their motions. `sources`: the indices of each pair in `points`.
#[inline(always)]
fn move_points<S: Simd>(
    simd: S,
    ComponentMotion { lambda, center }: &ComponentMotion,
    points: &[Moving],
    sources: &[[u32; 2]],
    pairs: &mut [Pair],
) {
    let (lambda, center) = (*lambda, f32x4::load_array_ref(simd, center));
    for (pair, [first, second]) in pairs.iter_mut().zip(sources) {
        let first = position_at(simd, points[*first as usize].load(simd), lambda, center);
        let second = position_at(simd, points[*second as usize].load(simd), lambda, center);
        simd.combine_f32x4(first, second).store_array(pair);
    }
}

/// Interpolates pairs of points of one cell by the trilinear polynomial of the cell about corner 0.
///
/// `corners`: lattice vertices at the corners. `lattice`: positions of the lattice vertices.
#[inline(always)]
fn interpolate_cell<S: Simd>(
    simd: S,
    corners: &[u32; 8],
    lattice: &[Xyzx],
    coords: &[Pair],
    pairs: &mut [Pair],
) {
    let mut terms = [f32x4::splat(simd, 0.0); 8];
    for k in 0..8 {
        terms[k] = f32x4::load_array_ref(simd, &lattice[corners[k] as usize]);
    }
    let terms = polynomial(terms);
    let mut doubled = [f32x8::splat(simd, 0.0); 8];
    for k in 0..8 {
        doubled[k] = simd.combine_f32x4(terms[k], terms[k]);
    }
    let [one, x, y, xy, z, xz, yz, xyz] = doubled;
    for (local, pair) in coords.iter().zip(pairs) {
        let [u, v, w, _] = broadcast_lanes(simd, f32x8::load_array_ref(simd, local));
        // The small offset from corner 0 is summed first, which reduces the rounding error.
        let upper = u.times_plus(xyz, yz).times_plus(v, u.times_plus(xz, z));
        let offset = upper.times_plus(w, u.times_plus(xy, y).times_plus(v, u * x));
        (one + offset).store_array(pair);
    }
}

/// Interpolates pairs of points of one cell by the smooth interpolant of the cell, or trilinearly where the slope
/// weights are 0.
///
/// `corners`: lattice vertices at the corners. `lattice`, `slopes`: positions and slopes of the lattice vertices.
#[inline(always)]
fn interpolate_smooth_cell<S: Simd>(
    simd: S,
    corners: &[u32; 8],
    lattice: &[Xyzx],
    slopes: Slopes<'_>,
    coords: &[Pair],
    pairs: &mut [Pair],
) {
    let mut slope_weights = [0.0; 8];
    let (mut lowest, mut highest) = (1.0_f32, 0.0_f32);
    for k in 0..8 {
        slope_weights[k] = slopes.slope_weights[corners[k] as usize];
        (lowest, highest) = (lowest.min(slope_weights[k]), highest.max(slope_weights[k]));
    }
    if highest == 0.0 {
        return interpolate_cell(simd, corners, lattice, coords, pairs);
    }
    let mut positions = [f32x4::splat(simd, 0.0); 8];
    let mut corner_slopes = [[f32x4::splat(simd, 0.0); 3]; 8];
    for k in 0..8 {
        positions[k] = f32x4::load_array_ref(simd, &lattice[corners[k] as usize]);
        for axis in 0..3 {
            corner_slopes[k][axis] = f32x4::load_array_ref(simd, &slopes.slopes[corners[k] as usize][axis]);
        }
    }
    let smooth = SmoothTerms::new(positions, corner_slopes);
    let mut terms = SmoothTerms([[f32x8::splat(simd, 0.0); 8]; 4]);
    for group in 0..4 {
        for k in 0..8 {
            terms.0[group][k] = simd.combine_f32x4(smooth.0[group][k], smooth.0[group][k]);
        }
    }
    let first = simd.combine_f32x4(positions[0], positions[0]);
    if lowest == 1.0 {
        for (local, pair) in coords.iter().zip(pairs) {
            let (_, coordinates) = local_coordinates(simd, local);
            (first + smooth_value(&terms, coordinates)).store_array(pair);
        }
        return;
    }
    let (corners, slope_weights) = (polynomial(positions), polynomial(slope_weights));
    let mut linear = [f32x8::splat(simd, 0.0); 8];
    let mut weight_terms = linear;
    for k in 0..8 {
        weight_terms[k] = f32x8::splat(simd, slope_weights[k]);
        if k > 0 {
            linear[k] = simd.combine_f32x4(corners[k], corners[k]);
        }
    }
    for (local, pair) in coords.iter().zip(pairs) {
        let (t, [x, y, z]) = local_coordinates(simd, local);
        let linear = trilinear_value(&linear, t);
        let difference = smooth_value(&terms, [x, y, z]) - linear;
        let slope_weights = trilinear_value(&weight_terms, [x.s, y.s, z.s]);
        (first + slope_weights.times_plus(difference, linear)).store_array(pair);
    }
}

/// Returns the local coordinates of a pair of points, and the functions of each of them. All four lanes of a half
/// contain the number of the point in that half.
#[inline(always)]
fn local_coordinates<S: Simd>(simd: S, local: &Pair) -> ([f32x8<S>; 3], [SmoothCoordinate<f32x8<S>>; 3]) {
    let local = f32x8::load_array_ref(simd, local);
    let SmoothCoordinate { s, e, k } = SmoothCoordinate::new(local);
    let [u, v, w, _] = broadcast_lanes(simd, local);
    let [s, e, k] = [broadcast_lanes(simd, s), broadcast_lanes(simd, e), broadcast_lanes(simd, k)];
    let along = |axis: usize| SmoothCoordinate { s: s[axis], e: e[axis], k: k[axis] };
    ([u, v, w], [along(0), along(1), along(2)])
}
