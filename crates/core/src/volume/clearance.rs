//! Finds the limits within which lattice vertices may move without the surface entering a collider.
//!
//! The surface is represented by its samples, which are grouped by lattice cell ([`SampleCells`]). A *row* is
//! an index into `SampleCells::vertices`. Positions and distances are in cells of the body's frame. Colliders
//! at one time are called obstacles where only their shapes matter.

use fearless_simd::{Simd, dispatch};
use nalgebra::{Point3, Vector3};

use super::limits::Limit;
use super::report::ComponentReport;
use crate::contact::{
    Colliders, Field, PosedShape, SampleBlock, SampleCells, ShapeField, SignedDistance, SmoothRows, Vec4,
    monomials, wide,
};
use crate::simd::level;
use crate::sparse_set::SparseSet;
use crate::state::BodyFrame;

/// Tolerated increase of the depth of a sample in a collider by the correction, in cells.
const TOLERANCE: f64 = 1e-3;

/// Finds the limits at other bodies: of vertices with these positions, within a distance in cells. Adds them to a list.
pub(crate) type FindLimits<'a> = dyn FnMut(&[[f32; 3]], f64, &mut Vec<Limit>) + 'a;

/// Searches for limits, and stores the limits that it finds.
#[derive(Clone, Debug, Default)]
pub(crate) struct LimitSearch {
    /// Position of the vertex of each row, without the correction.
    positions: Vec<Vec4>,
    /// Position of the vertex of each row, with the correction.
    corrected: Vec<Vec4>,
    /// Slopes of `positions` and their weights, if the skin is smooth.
    slopes: SmoothRows,
    /// Slopes of `corrected`, if the skin is smooth.
    corrected_slopes: SmoothRows,
    /// Rows with a limit at the current collider.
    rows: SparseSet,
    /// Nearest sample of each row in `rows`.
    nearest: Vec<Nearest>,
    /// Limits at all colliders.
    pub(crate) limits: Vec<Limit>,
    /// Whether the soft limits of each component are removed.
    drops_soft: Vec<bool>,
}

/// Colliders at one time, in the frame of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacles<'a> {
    /// Colliders of the scene.
    pub(crate) colliders: &'a Colliders,
    /// Time in seconds, at which moving colliders are evaluated.
    pub(crate) time: f64,
    /// Frame of the body.
    pub(crate) frame: BodyFrame,
}

/// Nearest sample of a vertex: the sample with the least clearance in the cells around the vertex.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    /// Distance by which the sample may move against `normal`, in cells. It is relative to the uncorrected
    /// sample in `find`, and to the corrected sample in `add_limits_for_entered_cells`.
    clearance: f64,
    /// Unit normal away from the collider.
    normal: Vector3<f64>,
}

impl LimitSearch {
    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let positions = size_of_val(&*self.positions) + size_of_val(&*self.corrected);
        let slopes = self.slopes.bytes() + self.corrected_slopes.bytes();
        let limits = size_of_val(&*self.limits) + size_of_val(&*self.drops_soft);
        positions + slopes + self.rows.bytes() + size_of_val(&*self.nearest) + limits
    }

    /// Begins without limits. `reports`: of the correction without limits.
    pub(crate) fn begin(&mut self, reports: &[ComponentReport]) {
        self.limits.clear();
        self.drops_soft.clear();
        self.drops_soft.extend(reports.iter().map(|report| !report.capped));
    }

    /// Keeps the soft limits of components whose volume is restored with them. `reports`: of the
    /// correction with limits.
    pub(crate) fn keep_unsolved(&mut self, reports: &[ComponentReport]) {
        for (drops_soft, report) in self.drops_soft.iter_mut().zip(reports) {
            *drops_soft &= report.capped;
        }
    }

    /// Removes the [soft](Limit::is_soft) limits of the components that need it. Returns whether there are any.
    /// `component`: returns the component of a vertex.
    pub(crate) fn remove_soft(&mut self, component: impl Fn(u32) -> usize) -> bool {
        let Self { limits, drops_soft, .. } = self;
        let count = limits.len();
        limits.retain(|limit| !(limit.is_soft && drops_soft[component(limit.vertex)]));
        limits.len() < count
    }

    /// Replaces the limits: finds those at colliders, see [`find`](Self::find), and those at other bodies.
    pub(crate) fn replace(
        &mut self,
        samples: Option<&SampleCells>,
        positions: &[[f32; 3]],
        obstacles: &Obstacles<'_>,
        distance: f64,
        find_at_bodies: &mut FindLimits<'_>,
    ) {
        self.limits.clear();
        if let Some(samples) = samples {
            self.find(samples, positions, obstacles, distance);
        }
        find_at_bodies(positions, distance, &mut self.limits);
    }

    /// Finds the limits of the vertices whose displacement by `distance` cells could move a sample into a
    /// collider.
    ///
    /// * `positions`: uncorrected positions, one per lattice vertex.
    ///
    /// For each collider, a vertex gets a limit if a sample in the cells around the vertex is within
    /// `distance` of the collider. The clearance of the limit is the least distance of these samples from the
    /// collider, at least 0.
    ///
    /// With a linear skin, a sample is a weighted mean of the corners of its cell. If no corner moves farther against
    /// the normal of a plane than the least distance of the cell's samples, no sample of the cell enters the plane. For
    /// other shapes, whose normal is not constant, and for a smooth skin,
    /// [`add_limits_for_entered_cells`](Self::add_limits_for_entered_cells) is needed as well.
    fn find(
        &mut self,
        samples: &SampleCells,
        positions: &[[f32; 3]],
        obstacles: &Obstacles<'_>,
        distance: f64,
    ) {
        copy_positions(&mut self.positions, samples, positions);
        if let Some(stencils) = samples.stencils() {
            self.slopes.update_slopes(stencils, &self.positions);
            self.slopes.update_slope_weights(stencils, &self.positions);
        }
        self.rows.resize(samples.vertices.len());
        self.limits.clear();
        for shape in obstacles.shapes() {
            self.clear();
            let slopes = samples.stencils().map(|_| self.slopes.with_weights_of(&self.slopes));
            let field = ShapeField { shape: &shape, positions: &self.positions, slopes };
            if field.any_may_touch(distance) {
                let (rows, nearest) = (&mut self.rows, &mut self.nearest);
                dispatch!(level(), simd => search(simd, &field, samples, distance, |cell, sample| {
                    let SignedDistance { distance: clearance, normal } =
                        shape.signed_distance(&sample.position);
                    keep_nearest(rows, nearest, &samples.corners[cell], Nearest { clearance, normal });
                }));
            }
            self.limits.extend(row_limits(samples, &self.rows, &self.nearest, |_| Vector3::zeros()));
        }
    }

    /// Adds limits for the cells in which a corrected sample enters a collider other than a plane, or with a smooth
    /// skin any collider. Returns whether any limit was added.
    ///
    /// * `positions`: corrected positions, one per lattice vertex.
    ///
    /// The corners of a cell get limits if the deepest sample of the cell has sunk into the collider by more
    /// than [`TOLERANCE`]: from the surface of the collider, or from its uncorrected position if this
    /// position is already inside. Let `n` be the normal of the collider at the uncorrected sample, and `P`
    /// the tangent plane of the collider with this normal (or the plane through the uncorrected sample, if
    /// the sample is inside). The limits reduce the displacement of each corner against `n` by the distance
    /// of the corrected sample behind `P`, so that the sample does not pass `P`. A convex collider lies
    /// entirely behind its tangent planes, so a sample that was outside does not enter the collider. A sample of a
    /// smooth skin also depends on vertices around its cell, so that further rounds may be needed.
    pub(crate) fn add_limits_for_entered_cells(
        &mut self,
        samples: &SampleCells,
        positions: &[[f32; 3]],
        obstacles: &Obstacles<'_>,
    ) -> bool {
        let previous_len = self.limits.len();
        copy_positions(&mut self.corrected, samples, positions);
        if let Some(stencils) = samples.stencils() {
            self.corrected_slopes.update_slopes(stencils, &self.corrected);
        }
        for shape in obstacles.shapes().filter(|shape| needs_entered_cells(shape, samples)) {
            self.clear();
            let Self { positions, corrected, slopes, corrected_slopes, rows, nearest, .. } = self;
            let is_smooth = samples.stencils().is_some();
            let slopes_before = is_smooth.then(|| slopes.with_weights_of(slopes));
            let slopes_after = is_smooth.then(|| corrected_slopes.with_weights_of(slopes));
            let entered = ShapeField { shape: &shape, positions: corrected, slopes: slopes_after };
            let uncorrected = ShapeField { shape: &shape, positions, slopes: slopes_before };
            if entered.any_may_touch(0.0) {
                dispatch!(level(), simd => search(simd, &entered, samples, 0.0, |cell, sample| {
                    let position = sample.position_in(simd, &uncorrected, &samples.corners[cell]);
                    let before = shape.signed_distance(&position);
                    let after = shape.signed_distance(&sample.position);
                    if after.distance < before.distance.min(0.0) - TOLERANCE {
                        let moved = (sample.position - position).dot(&before.normal);
                        let (clearance, normal) = (moved + before.distance.max(0.0), before.normal);
                        keep_nearest(rows, nearest, &samples.corners[cell], Nearest { clearance, normal });
                    }
                }));
            }
            let displacement = |row: usize| wide(&(self.corrected[row] - self.positions[row]));
            self.limits.extend(row_limits(samples, &self.rows, &self.nearest, displacement));
        }
        self.limits.len() > previous_len
    }

    /// Clears the rows and nearest samples of the previous collider.
    fn clear(&mut self) {
        self.rows.clear();
        self.nearest.clear();
    }
}

impl Obstacles<'_> {
    /// Returns whether any collider needs [`LimitSearch::add_limits_for_entered_cells`].
    pub(crate) fn need_entered_cells(&self, samples: &SampleCells) -> bool {
        self.shapes().any(|shape| needs_entered_cells(&shape, samples))
    }

    /// Returns the shapes of the colliders in the body's frame.
    fn shapes(&self) -> impl Iterator<Item = PosedShape<'_>> {
        self.colliders.at(self.time, self.frame)
    }
}

/// Returns whether the limits of [`LimitSearch::find`] may let samples enter a shape: if it is not a plane, or if the
/// skin is smooth, so that a sample is not a weighted mean of the corners of its cell with positive weights.
fn needs_entered_cells(shape: &PosedShape<'_>, samples: &SampleCells) -> bool {
    shape.plane().is_none() || samples.stencils().is_some()
}

/// Replaces `out` by the position of the vertex of each row. `positions`: one per lattice vertex.
fn copy_positions(out: &mut Vec<Vec4>, samples: &SampleCells, positions: &[[f32; 3]]) {
    out.clear();
    out.extend(samples.vertices.iter().map(|&vertex| {
        let [x, y, z] = positions[vertex as usize];
        Vec4::new(x, y, z, 0.0)
    }));
}

/// Returns the limit of the vertex of each row in `rows`.
///
/// * `nearest`: the nearest sample of each of these rows.
/// * `displacement`: returns the displacement of a row's vertex in the configuration to which the clearances
///   of `nearest` are relative. Its part against the normal is added to the clearance, so that the limit is
///   relative to the uncorrected position.
fn row_limits(
    samples: &SampleCells,
    rows: &SparseSet,
    nearest: &[Nearest],
    displacement: impl Fn(usize) -> Vector3<f64>,
) -> impl Iterator<Item = Limit> {
    rows.list().iter().zip(nearest).map(move |(&row, nearest)| Limit {
        vertex: samples.vertices[row as usize],
        normal: nearest.normal,
        clearance: (nearest.clearance - nearest.normal.dot(&displacement(row as usize))).max(0.0),
        is_soft: false,
    })
}

/// Replaces the nearest sample of each corner of a cell by `sample`, if its clearance is less.
///
/// * `rows`: rows with a nearest sample; the rows of the corners are added.
/// * `corners`: rows of the corners.
fn keep_nearest(rows: &mut SparseSet, nearest: &mut Vec<Nearest>, corners: &[u32; 8], sample: Nearest) {
    for &row in corners {
        let index = rows.index_or_insert(row) as usize;
        if index == nearest.len() {
            nearest.push(sample);
        } else if sample.clearance < nearest[index].clearance {
            nearest[index] = sample;
        }
    }
}

/// Sample of a cell.
struct Sample<'a> {
    position: Point3<f64>,
    /// Block of eight samples that contains the sample.
    block: &'a SampleBlock,
    /// Half of the block that contains the sample: 0 or 1.
    half: usize,
    /// Index of the sample in this half, 0..4.
    lane: usize,
}

impl Sample<'_> {
    /// Returns the position of the sample, computed with the vertex positions of `field`. `corners`: rows of
    /// the corners of the sample's cell.
    #[inline(always)]
    fn position_in<S: Simd>(&self, simd: S, field: &ShapeField<'_>, corners: &[u32; 8]) -> Point3<f64> {
        let half_monomials = &monomials(simd, &self.block.positions)[self.half];
        field.positions(simd, &field.cell(corners), half_monomials)[self.lane]
    }
}

/// Calls `visit` for each cell that has a sample within `distance` of the shape of `field`, with the index of
/// the cell and its nearest sample.
#[inline(always)]
fn search<S: Simd>(
    simd: S,
    field: &ShapeField<'_>,
    samples: &SampleCells,
    distance: f64,
    mut visit: impl FnMut(usize, Sample<'_>),
) {
    for (strip, cells) in samples.strips() {
        if !field.may_touch(strip, distance) {
            continue;
        }
        for cell in cells {
            if !field.may_touch(&samples.corners[cell], distance) {
                continue;
            }
            if let Some(sample) = nearest_sample(simd, field, samples, cell, distance) {
                visit(cell, sample);
            }
        }
    }
}

/// Returns the sample of a cell that is nearest to the shape of `field`, if it is within `max_distance`.
#[inline(always)]
fn nearest_sample<'a, S: Simd>(
    simd: S,
    field: &ShapeField<'_>,
    samples: &'a SampleCells,
    cell: usize,
    max_distance: f64,
) -> Option<Sample<'a>> {
    let interpolants = field.cell(&samples.corners[cell]);
    let (mut nearest_distance, mut nearest) = (max_distance, None);
    for block in samples.cell_blocks(cell) {
        for (half, half_monomials) in monomials(simd, &block.positions).iter().enumerate() {
            let positions = field.positions(simd, &interpolants, half_monomials);
            for (lane, position) in positions.into_iter().enumerate() {
                let distance = field.shape.signed_distance(&position).distance;
                if distance <= nearest_distance {
                    nearest_distance = distance;
                    nearest = Some(Sample { position, block, half, lane });
                }
            }
        }
    }
    nearest
}
