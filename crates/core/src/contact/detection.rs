//! Which samples touch a collider: strips of cells, then cells, then samples.

use fearless_simd::{Simd, dispatch};

use super::ContactReport;
use super::bounds::may_touch;
use super::field::{Curved, Field, Flat};
use super::numbered::Numbered;
use super::patch::{Patch, Touching};
use super::quad::{self, Quad, vector};
use crate::Lanes;
use crate::contact::posed::PosedShape;
use crate::contact::samples::{SampleCells, monomials};
use crate::simd::level;

/// Finds the samples that touch; its buffers.
#[derive(Clone, Debug)]
pub(super) struct Detection {
    /// Place of the vertex in each row, local.
    places: Vec<Quad>,
    /// Its distance from a plane.
    heights: Vec<f64>,
    patches: Patches,
}

/// The patches of one collider, in a fixed order.
#[derive(Clone, Debug)]
struct Patches {
    list: Vec<Patch>,
    /// The rows of their vertices, in the same order.
    rows: Numbered,
}

impl Detection {
    /// For samples of vertices in so many rows.
    pub(super) fn new(rows: usize) -> Self {
        Self {
            places: vec![[0.0; 4]; rows],
            heights: vec![0.0; rows],
            patches: Patches { list: Vec::new(), rows: Numbered::new(rows) },
        }
    }

    /// Reads the places of the samples' vertices.
    pub(super) fn read(&mut self, positions: &Lanes<3>, slots: &[u32]) {
        quad::read(&mut self.places, positions, slots);
    }

    /// The place of the vertex in a row.
    pub(super) fn place(&self, row: u32) -> &Quad {
        &self.places[row as usize]
    }

    /// The patches that were found last, in a fixed order.
    pub(super) fn patches(&self) -> impl Iterator<Item = &Patch> {
        self.patches.list.iter().filter(|patch| patch.counts())
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
        patches.clear();
        if !may_touch(shape, places.iter(), skin) {
            return;
        }
        if let Some((normal, offset)) = shape.plane() {
            for (height, place) in heights.iter_mut().zip(&*places) {
                *height = normal.dot(&vector(place)) - offset;
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
    fn clear(&mut self) {
        self.list.clear();
        self.rows.clear();
    }

    /// Samples lie between the corners of their cells: only the cells that may touch are looked into.
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
                let known = field.cell(corners);
                for block in samples.of_cell(cell) {
                    if !field.may_touch_block(simd, &known, block, skin) {
                        continue;
                    }
                    let monomials = monomials(simd, &block.places);
                    let low = field.distances(simd, &known, &monomials[0]);
                    let high = field.distances(simd, &known, &monomials[1]);
                    if let Some(touching) = Touching::within(simd, [low, high], &block.shares, skin) {
                        count += touching.count;
                        report.deepest = report.deepest.max(touching.deepest);
                        let patch = self.about(corners[usize::from(block.corner)]);
                        patch.take(simd, &touching, block, corners, &monomials);
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
