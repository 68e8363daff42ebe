//! Detection of the samples that touch a collider, by strips of cells, cells, and blocks of samples.

use fearless_simd::{Simd, dispatch};

use super::field::{Field, PlaneField, ShapeField, may_touch, monomials};
use super::patch::{Patch, Touching};
use super::rows::{RowSet, buffer_bytes};
use super::samples::SampleCells;
use super::shape::PosedShape;
use super::vec4::{Vec4, read, wide};
use crate::simd::lanes::Lanes;
use crate::simd::level;

/// Contacts of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Number of samples inside a collider or within a thousandth of a cell of it, added up over the
    /// colliders. At zero the contact stage changed nothing.
    pub contacts: usize,
    /// Greatest depth of a sample before the push-out, in cells.
    pub deepest: f64,
}

/// Detection of the patches that touch a shape, with its buffers.
#[derive(Clone, Debug)]
pub(super) struct Detection {
    /// Position of the vertex in each row, in the body's frame.
    places: Vec<Vec4>,
    /// Signed distance of the vertex in each row from a plane.
    heights: Vec<f64>,
    patches: Patches,
}

/// Patches of one collider, in a fixed order.
#[derive(Clone, Debug)]
struct Patches {
    list: Vec<Patch>,
    /// Row of the vertex of each patch, in the same order.
    rows: RowSet,
}

impl Detection {
    /// Creates the buffers for `rows` vertices.
    pub(super) fn new(rows: usize) -> Self {
        Self {
            places: vec![Vec4::zeros(); rows],
            heights: vec![0.0; rows],
            patches: Patches { list: Vec::new(), rows: RowSet::new(rows) },
        }
    }

    /// Returns the memory of the buffers in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Patches { list, rows } = &self.patches;
        buffer_bytes(&self.places) + buffer_bytes(&self.heights) + buffer_bytes(list) + rows.bytes()
    }

    /// Copies the positions of the samples' vertices from the state.
    pub(super) fn read(&mut self, positions: &Lanes<3>, slots: &[u32]) {
        read(&mut self.places, positions, slots);
    }

    /// Returns the positions of the samples' vertices, by row.
    pub(super) fn places(&self) -> &[Vec4] {
        &self.places
    }

    /// Returns the patches of the last call of `find`, in a fixed order.
    pub(super) fn patches(&self) -> impl Iterator<Item = &Patch> {
        self.patches.list.iter().filter(|patch| patch.has_weight())
    }

    /// Finds the samples inside the shape or within `skin` cells of it; adds them to the report.
    pub(super) fn find(
        &mut self,
        shape: &PosedShape,
        samples: &SampleCells,
        skin: f64,
        report: &mut ContactReport,
    ) {
        let Self { places, heights, patches } = self;
        patches.list.clear();
        patches.rows.clear();
        if !may_touch(shape, places.iter(), skin) {
            return;
        }
        if let Some((normal, offset)) = shape.plane() {
            for (height, place) in heights.iter_mut().zip(&*places) {
                *height = normal.dot(&wide(place)) - offset;
            }
            let field = PlaneField { heights };
            dispatch!(level(), simd => patches.search(simd, &field, samples, skin, report));
        } else {
            let field = ShapeField { shape, places };
            dispatch!(level(), simd => patches.search(simd, &field, samples, skin, report));
        }
    }
}

impl Patches {
    /// Collects the touching samples into patches.
    ///
    /// Samples lie in the convex hull of the corners of their cell, so a cell whose corners are far from the
    /// shape is skipped.
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
                    let monomials = monomials(simd, &block.places);
                    let low = field.distances(simd, &interpolants, &monomials[0]);
                    let high = field.distances(simd, &interpolants, &monomials[1]);
                    if let Some(touching) = Touching::within(simd, [low, high], &block.shares, skin) {
                        count += touching.count;
                        report.deepest = report.deepest.max(touching.deepest);
                        let patch = self.patch_at(corners[usize::from(block.corner)]);
                        patch.add(simd, &touching, block, corners, &monomials);
                    }
                }
            }
        }
        // The shares are powers of two, so the sum is exact.
        report.contacts += count as usize;
    }

    /// Returns the patch of the vertex in a row; adds it if it is new.
    #[inline(always)]
    fn patch_at(&mut self, row: u32) -> &mut Patch {
        let number = self.rows.number(row) as usize;
        if number == self.list.len() {
            self.list.push(Patch::new());
        }
        &mut self.list[number]
    }
}
