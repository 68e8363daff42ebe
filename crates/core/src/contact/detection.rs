//! Detection: the samples that touch a collider, by strips of cells, then cells, then blocks of samples.

use fearless_simd::{Simd, dispatch};

use super::field::{Curved, Field, Flat, may_touch, monomials};
use super::patch::{Patch, Touching};
use super::rows::{RowSet, held};
use super::samples::SampleCells;
use super::shape::PosedShape;
use super::vec4::{Vec4, read, wide};
use crate::simd::lanes::Lanes;
use crate::simd::level;

/// The contacts that a step found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactReport {
    /// Samples inside a collider or within a thousandth of a cell of it, counted for each collider. At zero the step
    /// changed nothing.
    pub contacts: usize,
    /// Greatest depth of a sample before it was pushed out, in cells.
    pub deepest: f64,
}

/// Finds the patches that touch a shape; its buffers.
#[derive(Clone, Debug)]
pub(super) struct Detection {
    /// Place of the vertex in each row, local.
    places: Vec<Vec4>,
    /// Its distance from a plane.
    heights: Vec<f64>,
    patches: Patches,
}

/// The patches of one collider, in a fixed order.
#[derive(Clone, Debug)]
struct Patches {
    list: Vec<Patch>,
    /// The rows of their vertices, in the same order.
    rows: RowSet,
}

impl Detection {
    /// For samples of vertices in `rows` rows.
    pub(super) fn new(rows: usize) -> Self {
        Self {
            places: vec![Vec4::zeros(); rows],
            heights: vec![0.0; rows],
            patches: Patches { list: Vec::new(), rows: RowSet::new(rows) },
        }
    }

    /// Memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Patches { list, rows } = &self.patches;
        held(&self.places) + held(&self.heights) + held(list) + rows.bytes()
    }

    /// Reads the places of the samples' vertices.
    pub(super) fn read(&mut self, positions: &Lanes<3>, slots: &[u32]) {
        read(&mut self.places, positions, slots);
    }

    /// The places of the samples' vertices, by row.
    pub(super) fn places(&self) -> &[Vec4] {
        &self.places
    }

    /// The patches that were found last, in a fixed order.
    pub(super) fn patches(&self) -> impl Iterator<Item = &Patch> {
        self.patches.list.iter().filter(|patch| patch.has_weight())
    }

    /// Finds the samples that are inside the shape or nearer to it than `skin`, in cells; adds them to the report.
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
            let field = Flat { heights };
            dispatch!(level(), simd => patches.search(simd, &field, samples, skin, report));
        } else {
            let field = Curved { shape, places };
            dispatch!(level(), simd => patches.search(simd, &field, samples, skin, report));
        }
    }
}

impl Patches {
    /// Collects the touching samples. Samples lie between the corners of their cells, so cells whose corners are away
    /// from the shape are skipped.
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
                let maps = field.cell(corners);
                for block in samples.of_cell(cell) {
                    if !field.may_touch_block(simd, &maps, block, skin) {
                        continue;
                    }
                    let monomials = monomials(simd, &block.places);
                    let low = field.distances(simd, &maps, &monomials[0]);
                    let high = field.distances(simd, &maps, &monomials[1]);
                    if let Some(touching) = Touching::within(simd, [low, high], &block.shares, skin) {
                        count += touching.count;
                        report.deepest = report.deepest.max(touching.deepest);
                        let patch = self.about(corners[usize::from(block.corner)]);
                        patch.add(simd, &touching, block, corners, &monomials);
                    }
                }
            }
        }
        // Shares of powers of two: the sum is exact.
        report.contacts += count as usize;
    }

    /// The patch about the vertex in a row.
    #[inline(always)]
    fn about(&mut self, row: u32) -> &mut Patch {
        let number = self.rows.number(row) as usize;
        if number == self.list.len() {
            self.list.push(Patch::new());
        }
        &mut self.list[number]
    }
}
