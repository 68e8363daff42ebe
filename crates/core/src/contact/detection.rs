//! Finds the samples that touch a collider: tests strips of cells, then cells, then blocks of samples.
//!
//! A row is an index into `SampleCells::vertices`.

use fearless_simd::{Simd, SimdBase, dispatch, f64x4};

use super::field::{
    Aabb, Field, HeightSlopes, PlaneField, ShapeField, aabb_of_all, may_touch_for_any_slopes,
};
use super::interpolant::monomials;
use super::memory::buffer_bytes;
use super::patch::{Patch, Touching};
use super::posed_collider::PosedCollider;
use super::samples::{SampleBlock, SampleCells};
use super::shape::PosedShape;
use super::sides::Side;
use super::smooth_rows::{RowSlopes, SmoothRows};
use super::swept::{Paths, Sweep, distances};
use super::vec4::{Vec4, read, wide};
use crate::simd::lanes::{LANES, Lanes};
use crate::simd::level;
use crate::sparse_set::SparseSet;

/// Contacts of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Number of samples inside a collider or within a thousandth of a cell of it, summed over the
    /// colliders. If it is zero, the contact stage changed nothing.
    pub contacts: usize,
    /// Greatest depth of a sample before the push-out, in cells.
    pub deepest: f64,
}

/// Finds the patches that touch a shape; owns the buffers of the search.
#[derive(Clone, Debug, Default)]
pub(super) struct Detection {
    /// Position of the vertex of each row, in the body's frame.
    pub(super) positions: Vec<Vec4>,
    /// Bounds of `positions`; `None` until a shape is searched.
    bounds: Option<Aabb>,
    /// Signed distance of the vertex of each row from the plane that is searched.
    heights: Vec<f64>,
    /// Slopes of the positions, if the skin is smooth. Empty until a shape is near.
    smooth: SmoothRows,
    /// Whether `smooth` belongs to `positions`.
    has_slopes: bool,
    /// Slopes of `heights`, if the skin is smooth.
    height_slopes: Vec<[f64; 3]>,
    patches: Patches,
    paths: Paths,
    /// Whether the last step found samples by their paths, so that samples may have side points.
    has_swept: bool,
}

/// Patches of one collider, in a fixed order.
#[derive(Clone, Debug, Default)]
struct Patches {
    list: Vec<Patch>,
    /// Row of the nearest vertex of each patch, in the order of `list`.
    rows: SparseSet,
}

impl Detection {
    /// Creates the buffers for `rows` vertices.
    pub(super) fn new(rows: usize) -> Self {
        Self {
            positions: vec![Vec4::zeros(); rows],
            heights: vec![0.0; rows],
            patches: Patches { list: Vec::new(), rows: SparseSet::new(rows) },
            ..Self::default()
        }
    }

    /// Returns the memory of the buffers in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Patches { list, rows } = &self.patches;
        let smooth = self.smooth.bytes() + buffer_bytes(&self.height_slopes);
        buffer_bytes(&self.positions)
            + buffer_bytes(&self.heights)
            + buffer_bytes(list)
            + rows.bytes()
            + smooth
            + self.paths.bytes()
    }

    /// Copies the positions of the vertices of all rows from the state. `slots`: slot of each row. The rows of
    /// `leaving` get positions of NaN, which touch nothing.
    pub(super) fn read(&mut self, positions: &Lanes<3>, slots: &[u32], leaving: &[u32]) {
        read(&mut self.positions, positions, slots);
        for &row in leaving {
            self.positions[row as usize] = Vec4::repeat(f32::NAN);
        }
        self.has_slopes = false;
        self.bounds = None;
    }

    /// As [`read`](Self::read), of positions that contacts changed: updates the paths of the samples.
    pub(super) fn read_moved(&mut self, positions: &Lanes<3>, slots: &[u32], leaving: &[u32]) {
        self.read(positions, slots, leaving);
        self.paths.update(&self.positions);
    }

    /// Begins the paths of the samples in a step, at whose end the positions were read. `velocities` are those in the
    /// step.
    pub(super) fn begin_paths(&mut self, velocities: &Lanes<3>, slots: &[u32], dt: f64) {
        self.paths.begin(&self.positions, velocities, slots, dt);
    }

    /// Returns the AABB of the positions.
    fn bounds(&mut self) -> Aabb {
        *self.bounds.get_or_insert_with(|| aabb_of_all(&self.positions))
    }

    /// Returns false only if no sample is within `skin` of the shape. May return true in this case as well.
    pub(super) fn may_touch(&mut self, shape: &PosedShape<'_>, samples: &SampleCells, skin: f64) -> bool {
        let bounds = self.bounds();
        if samples.stencils().is_none() {
            return shape.may_touch(&bounds.0, &bounds.1, skin);
        }
        if !may_touch_for_any_slopes(shape, &bounds, skin) {
            return false;
        }
        self.update_slopes(samples);
        let slopes = self.smooth.of(samples);
        ShapeField { shape, positions: &self.positions, slopes }.any_may_touch(skin)
    }

    /// Computes the slopes of the positions if the skin is smooth.
    fn update_slopes(&mut self, samples: &SampleCells) {
        let Self { positions, smooth, has_slopes, .. } = self;
        if let (Some(stencils), false) = (samples.stencils(), *has_slopes) {
            smooth.update_slopes(stencils, positions);
            smooth.update_slope_weights(stencils, positions);
            *has_slopes = true;
        }
    }

    /// Returns the side points.
    pub(super) fn sides(&self) -> &[Side] {
        self.paths.sides()
    }

    /// Restores side points. Ignores those that do not belong to these samples.
    pub(super) fn set_sides(&mut self, sides: &[Side], samples: &SampleCells) {
        self.paths.set_sides(sides, samples.block_count() * LANES);
    }

    /// Returns the patches that the last call of `find` found, in a fixed order.
    pub(super) fn patches(&self) -> impl Iterator<Item = &Patch> {
        self.patches.list.iter().filter(|patch| patch.has_weight())
    }

    /// Finds the samples inside a collider or within `skin` cells of it, and adds them to the report. Where the nearest
    /// surface may be on the wrong side, the paths of the samples decide.
    pub(super) fn find(
        &mut self,
        collider: &PosedCollider<'_>,
        samples: &SampleCells,
        skin: f64,
        report: &mut ContactReport,
    ) {
        self.patches.list.clear();
        self.patches.rows.clear();
        let shape = &collider.shape;
        if self.finds_by_paths(collider, samples, skin, report) || !self.may_touch(shape, samples, skin) {
            return;
        }
        let Self { positions, heights, smooth, height_slopes, patches, .. } = self;
        let slopes = smooth.of(samples);
        if let Some((normal, offset)) = shape.plane() {
            for (height, position) in heights.iter_mut().zip(&*positions) {
                *height = normal.dot(&wide(position)) - offset;
            }
            let slopes = slopes.map(|RowSlopes { slopes, slope_weights }| {
                let along = |slopes: &[Vec4; 3]| slopes.map(|slope| normal.dot(&wide(&slope)));
                height_slopes.clear();
                height_slopes.extend(slopes.iter().map(along));
                HeightSlopes { slopes: height_slopes, slope_weights }
            });
            let field = PlaneField { heights, slopes };
            dispatch!(level(), simd => patches.search(simd, &field, samples, skin, report));
        } else {
            let field = ShapeField { shape, positions, slopes };
            dispatch!(level(), simd => patches.search(simd, &field, samples, skin, report));
        }
    }

    /// Finds the samples by their paths, as [`find`](Self::find), if the collider needs it. Returns whether it does.
    fn finds_by_paths(
        &mut self,
        collider: &PosedCollider<'_>,
        samples: &SampleCells,
        skin: f64,
        report: &mut ContactReport,
    ) -> bool {
        let bounds = self.bounds();
        let Some(motion) = self.paths.motion(collider, &bounds) else { return false };
        if self.is_far(collider, samples, skin + motion) {
            return true;
        }
        let Self { positions, smooth, patches, paths, has_swept, .. } = self;
        let slopes = smooth.of(samples);
        let sweep = paths.sweep(collider, ShapeField { shape: &collider.shape, positions, slopes }, motion);
        let (count, is_mesh) = (report.contacts, matches!(collider.shape, PosedShape::Mesh(_)));
        dispatch!(level(), simd => patches.search_paths(simd, &sweep, samples, (skin, is_mesh), report));
        *has_swept |= report.contacts > count;
        true
    }

    /// Returns true only if no sample has a side point at a collider, and none is within `distance` of it.
    fn is_far(&mut self, collider: &PosedCollider<'_>, samples: &SampleCells, distance: f64) -> bool {
        let may_touch = self.may_touch(&collider.shape, samples, distance);
        let is_far = !may_touch && self.paths.sides_at(collider.index).is_empty();
        if !is_far {
            self.update_slopes(samples);
        }
        is_far
    }

    /// Stores the side points of the samples after the step. `colliders`: during the step.
    pub(super) fn keep_sides<'a>(
        &mut self,
        state: &Lanes<3>,
        (samples, leaving): (&SampleCells, &[u32]),
        colliders: impl Iterator<Item = PosedCollider<'a>>,
    ) {
        if !std::mem::take(&mut self.has_swept) {
            self.paths.clear_sides();
            return;
        }
        self.read_moved(state, &samples.slots, leaving);
        let mut found = self.paths.take_scratch();
        for collider in colliders {
            let bounds = self.bounds();
            let Some(motion) = self.paths.motion(&collider, &bounds) else { continue };
            if self.is_far(&collider, samples, motion) {
                continue;
            }
            let Self { positions, smooth, paths, .. } = &*self;
            let slopes = smooth.of(samples);
            let field = ShapeField { shape: &collider.shape, positions, slopes };
            let sweep = paths.sweep(&collider, field, motion);
            dispatch!(level(), simd => find_sides(simd, &sweep, samples, &mut found));
        }
        self.paths.replace_sides(found);
    }
}

/// Adds the side points of the samples of a sweep.
#[inline(always)]
fn find_sides<S: Simd>(simd: S, sweep: &Sweep<'_>, samples: &SampleCells, found: &mut Vec<Side>) {
    let collider = sweep.collider.index;
    sweep.search(simd, samples, 0.0, |_, (block, _), ends, contacts| {
        for lane in 0..LANES {
            let point =
                contacts[lane].and_then(|contact| sweep.collider.shape.side_point(&ends[lane], &contact));
            if let Some(point) = point {
                let point = sweep.collider.rest_point(&point).into();
                found.push(Side { collider, sample: block * LANES as u32 + lane as u32, point });
            }
        }
    });
}

impl Patches {
    /// Collects the touching samples into patches.
    #[inline(always)]
    fn search<S: Simd>(
        &mut self,
        simd: S,
        field: &impl Field,
        samples: &SampleCells,
        skin: f64,
        report: &mut ContactReport,
    ) {
        let mut count = 0.0;
        for (rows, cells) in samples.strips() {
            if !field.may_touch(rows, skin) {
                continue;
            }
            for cell in cells {
                let corners = &samples.corners[cell];
                if !field.may_touch(corners, skin) {
                    continue;
                }
                let interpolants = field.cell(corners);
                for block in samples.cell_blocks(cell) {
                    if !field.may_touch_block(simd, &interpolants, block, skin) {
                        continue;
                    }
                    let place = (corners, block);
                    count += match block.halves() {
                        1 => self.add_block::<_, _, 1>(simd, (field, &interpolants), place, skin, report),
                        _ => self.add_block::<_, _, 2>(simd, (field, &interpolants), place, skin, report),
                    };
                }
            }
        }
        // The fractions are powers of two, so the sum is exact.
        report.contacts += count as usize;
    }

    /// Adds the touching samples of a block to the patch of their corner. Returns their number, by fractions.
    #[inline(always)]
    fn add_block<S: Simd, F: Field, const HALVES: usize>(
        &mut self,
        simd: S,
        (field, interpolants): (&F, &F::Cell),
        (corners, block): (&[u32; 8], &SampleBlock),
        skin: f64,
        report: &mut ContactReport,
    ) -> f64 {
        let monomials: [_; HALVES] = monomials(simd, &block.positions);
        let mut distances = [f64x4::splat(simd, 0.0); HALVES];
        for half in 0..HALVES {
            distances[half] = field.distances(simd, interpolants, &monomials[half]);
        }
        let Some(touching) = Touching::within(simd, distances, &block.fractions, skin) else { return 0.0 };
        report.deepest = report.deepest.max(touching.deepest);
        let patch = self.patch_at(corners[usize::from(block.corner)]);
        patch.add(simd, &touching, block, corners, &monomials);
        touching.count
    }

    /// Collects the samples that a sweep finds into patches, as [`search`](Self::search). `is_mesh`: whether the shape
    /// is a mesh.
    #[inline(always)]
    fn search_paths<S: Simd>(
        &mut self,
        simd: S,
        sweep: &Sweep<'_>,
        samples: &SampleCells,
        (skin, is_mesh): (f64, bool),
        report: &mut ContactReport,
    ) {
        let mut count = 0.0;
        sweep.search(simd, samples, skin, |corners, (_, block), _, contacts| {
            let distances = distances(simd, contacts);
            let Some(touching) = Touching::within(simd, distances, &block.fractions, skin) else { return };
            count += touching.count;
            report.deepest = report.deepest.max(touching.deepest);
            let patch = self.patch_at(corners[usize::from(block.corner)]);
            patch.add::<_, 2>(simd, &touching, block, corners, &monomials(simd, &block.positions));
            patch.add_sides(contacts, &block.fractions, skin, is_mesh);
        });
        report.contacts += count as usize;
    }

    /// Returns the patch of the vertex of a row. Adds an empty patch if there is none yet.
    #[inline(always)]
    fn patch_at(&mut self, row: u32) -> &mut Patch {
        let index = self.rows.index_or_insert(row) as usize;
        if index == self.list.len() {
            self.list.push(Patch::new());
        }
        &mut self.list[index]
    }
}
