//! Finds the samples that touch a collider: tests strips of cells, then cells, then blocks of samples.
//!
//! A row is an index into `SampleCells::vertices`.

use fearless_simd::{Simd, dispatch};

use super::field::{
    Field, HeightSlopes, PlaneField, ShapeField, may_touch, may_touch_for_any_slopes, smooth_may_touch,
};
use super::interpolant::monomials;
use super::patch::{Patch, Touching};
use super::rows::{RowSet, buffer_bytes};
use super::samples::SampleCells;
use super::shape::PosedShape;
use super::smooth_rows::{RowSlopes, SmoothRows};
use super::vec4::{Vec4, read, wide};
use crate::simd::lanes::Lanes;
use crate::simd::level;

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
#[derive(Clone, Debug)]
pub(super) struct Detection {
    /// Position of the vertex of each row, in the body's frame.
    positions: Vec<Vec4>,
    /// Signed distance of the vertex of each row from the plane that is searched.
    heights: Vec<f64>,
    /// Slopes of the positions, if the skin is smooth. Empty until a shape is near.
    smooth: SmoothRows,
    /// Whether `smooth` belongs to `positions`.
    has_slopes: bool,
    /// Slopes of `heights`, if the skin is smooth.
    height_slopes: Vec<[f64; 3]>,
    patches: Patches,
}

/// Patches of one collider, in a fixed order.
#[derive(Clone, Debug)]
struct Patches {
    list: Vec<Patch>,
    /// Row of the nearest vertex of each patch, in the order of `list`.
    rows: RowSet,
}

impl Detection {
    /// Creates the buffers for `rows` vertices.
    pub(super) fn new(rows: usize) -> Self {
        Self {
            positions: vec![Vec4::zeros(); rows],
            heights: vec![0.0; rows],
            smooth: SmoothRows::default(),
            has_slopes: false,
            height_slopes: Vec::new(),
            patches: Patches { list: Vec::new(), rows: RowSet::new(rows) },
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
    }

    /// Copies the positions of the vertices of all rows from the state. `slots`: slot of each row. The rows of
    /// `leaving` get positions of NaN, which touch nothing.
    pub(super) fn read(&mut self, positions: &Lanes<3>, slots: &[u32], leaving: &[u32]) {
        read(&mut self.positions, positions, slots);
        for &row in leaving {
            self.positions[row as usize] = Vec4::repeat(f32::NAN);
        }
        self.has_slopes = false;
    }

    /// Returns false only if no sample is within `skin` of the shape. May return true in this case as well.
    pub(super) fn may_touch(&mut self, shape: &PosedShape, samples: &SampleCells, skin: f64) -> bool {
        let Self { positions, smooth, has_slopes, .. } = self;
        let Some(stencils) = samples.stencils() else { return may_touch(shape, positions.iter(), skin) };
        if !may_touch_for_any_slopes(shape, positions.iter(), skin) {
            return false;
        }
        if !*has_slopes {
            smooth.update_slopes(stencils, positions);
            smooth.update_trust(stencils, positions);
            *has_slopes = true;
        }
        let slopes = smooth.with_trust_of(smooth).slopes;
        smooth_may_touch(shape, positions.iter().zip(slopes), skin)
    }

    /// Returns the position of the vertex of each row.
    pub(super) fn positions(&self) -> &[Vec4] {
        &self.positions
    }

    /// Returns the patches that the last call of `find` found, in a fixed order.
    pub(super) fn patches(&self) -> impl Iterator<Item = &Patch> {
        self.patches.list.iter().filter(|patch| patch.has_weight())
    }

    /// Finds the samples inside the shape or within `skin` cells of it, and adds them to the report.
    pub(super) fn find(
        &mut self,
        shape: &PosedShape,
        samples: &SampleCells,
        skin: f64,
        report: &mut ContactReport,
    ) {
        self.patches.list.clear();
        self.patches.rows.clear();
        if !self.may_touch(shape, samples, skin) {
            return;
        }
        let Self { positions, heights, smooth, height_slopes, patches, .. } = self;
        let slopes = samples.stencils().map(|_| smooth.with_trust_of(smooth));
        if let Some((normal, offset)) = shape.plane() {
            for (height, position) in heights.iter_mut().zip(&*positions) {
                *height = normal.dot(&wide(position)) - offset;
            }
            let slopes = slopes.map(|RowSlopes { slopes, trust }| {
                let along = |slopes: &[Vec4; 3]| slopes.map(|slope| normal.dot(&wide(&slope)));
                height_slopes.clear();
                height_slopes.extend(slopes.iter().map(along));
                HeightSlopes { slopes: height_slopes, trust }
            });
            let field = PlaneField { heights, slopes };
            dispatch!(level(), simd => patches.search(simd, &field, samples, skin, report));
        } else {
            let field = ShapeField { shape, positions, slopes };
            dispatch!(level(), simd => patches.search(simd, &field, samples, skin, report));
        }
    }
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
                    let monomials = monomials(simd, &block.positions);
                    let low = field.distances(simd, &interpolants, &monomials[0]);
                    let high = field.distances(simd, &interpolants, &monomials[1]);
                    if let Some(touching) = Touching::within(simd, [low, high], &block.fractions, skin) {
                        count += touching.count;
                        report.deepest = report.deepest.max(touching.deepest);
                        let patch = self.patch_at(corners[usize::from(block.corner)]);
                        patch.add(simd, &touching, block, corners, &monomials);
                    }
                }
            }
        }
        // The fractions are powers of two, so the sum is exact.
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
