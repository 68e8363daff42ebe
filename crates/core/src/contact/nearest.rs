//! Finds the sample of each cell that is nearest to a shape, at displayed positions of the lattice vertices.
//!
//! A row is an index into `SampleCells::vertices`.

use fearless_simd::{Simd, dispatch};
use nalgebra::Point3;

use super::field::{Field, SMOOTH_DISPLACEMENT, ShapeField};
use super::interpolant::monomials;
use super::samples::{SampleBlock, SampleCells};
use super::shape::PosedShape;
use super::smooth_rows::SmoothRows;
use super::vec4::Vec4;
use crate::simd::level;

/// The samples of a body at a start, and moved from it.
#[derive(Debug, Default)]
pub(crate) struct MovedSamples {
    start: Posed,
    moved: Posed,
}

/// Positions of the vertices of all rows.
#[derive(Debug, Default)]
struct Posed {
    positions: Vec<Vec4>,
    /// Slopes of the positions, if the skin is smooth, and of `MovedSamples::start` their weights.
    slopes: SmoothRows,
}

impl MovedSamples {
    /// Sets the positions at the start, one per lattice vertex.
    pub(crate) fn set_start(&mut self, samples: &SampleCells, positions: &[[f32; 3]]) {
        self.start.set(samples, positions);
        if let Some(stencils) = samples.stencils() {
            self.start.slopes.update_slope_weights(stencils, &self.start.positions);
        }
    }

    /// Sets the moved positions, one per lattice vertex.
    pub(crate) fn set_moved(&mut self, samples: &SampleCells, positions: &[[f32; 3]]) {
        self.moved.set(samples, positions);
    }

    /// Calls `visit` for each cell that has a sample within `distance` cells of a shape at the start: with the position
    /// of its nearest sample, and the lattice vertices at the corners of the cell.
    pub(crate) fn for_each_near(
        &self,
        samples: &SampleCells,
        shape: &PosedShape<'_>,
        distance: f64,
        mut visit: impl FnMut(Point3<f64>, [u32; 8]),
    ) {
        let field = self.field(&self.start, samples, shape);
        if field.any_may_touch(distance) {
            dispatch!(level(), simd => search(simd, &field, samples, distance, |cell, sample| {
                visit(sample.position, samples.vertices_of(cell));
            }));
        }
    }

    /// Calls `visit` for each cell of which a moved sample is in a shape: with the positions of its deepest sample at the
    /// start and moved, and the lattice vertices at the corners of the cell.
    pub(crate) fn for_each_entered(
        &self,
        samples: &SampleCells,
        shape: &PosedShape<'_>,
        mut visit: impl FnMut([Point3<f64>; 2], [u32; 8]),
    ) {
        let [start, moved] = [&self.start, &self.moved].map(|posed| self.field(posed, samples, shape));
        if moved.any_may_touch(0.0) {
            dispatch!(level(), simd => search(simd, &moved, samples, 0.0, |cell, sample| {
                let before = sample.position_in(simd, &start, &samples.corners[cell]);
                visit([before, sample.position], samples.vertices_of(cell));
            }));
        }
    }

    /// Returns the distances of samples from a shape.
    fn field<'a>(
        &'a self,
        posed: &'a Posed,
        samples: &SampleCells,
        shape: &'a PosedShape<'a>,
    ) -> ShapeField<'a> {
        let slopes = samples.stencils().map(|_| posed.slopes.with_weights_of(&self.start.slopes));
        ShapeField { shape, positions: &posed.positions, slopes }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let bytes = |posed: &Posed| size_of_val(&*posed.positions) + posed.slopes.bytes();
        bytes(&self.start) + bytes(&self.moved)
    }
}

impl Posed {
    /// Sets the positions, one per lattice vertex, and their slopes.
    fn set(&mut self, samples: &SampleCells, positions: &[[f32; 3]]) {
        self.positions.clear();
        self.positions.extend(samples.vertices.iter().map(|&vertex| {
            let [x, y, z] = positions[vertex as usize];
            Vec4::new(x, y, z, 0.0)
        }));
        if let Some(stencils) = samples.stencils() {
            self.slopes.update_slopes(stencils, &self.positions);
        }
    }
}

impl SampleCells {
    /// Returns whether the skin is smooth, so that samples are not weighted means of the corners of their cells.
    pub(crate) fn is_smooth(&self) -> bool {
        self.stencils().is_some()
    }

    /// Returns the greatest displacement of a sample, relative to the greatest displacement of a vertex.
    pub(crate) fn greatest_factor(&self) -> f64 {
        if self.is_smooth() { SMOOTH_DISPLACEMENT } else { 1.0 }
    }

    /// Returns the lattice vertices at the corners of a cell.
    fn vertices_of(&self, cell: usize) -> [u32; 8] {
        self.corners[cell].map(|row| self.vertices[row as usize])
    }
}

/// Sample of a cell.
struct Sample<'a> {
    position: Point3<f64>,
    /// Block of eight samples that contains the sample.
    block: &'a SampleBlock,
    /// Index of the sample in the block: in which half of it, and where in this half.
    index: [usize; 2],
}

impl Sample<'_> {
    /// Returns the position of the sample, computed with the vertex positions of `field`. `corners`: rows of
    /// the corners of the sample's cell.
    #[inline(always)]
    fn position_in<S: Simd>(&self, simd: S, field: &ShapeField<'_>, corners: &[u32; 8]) -> Point3<f64> {
        let [half, lane] = self.index;
        let monomials: [_; 2] = monomials(simd, &self.block.positions);
        field.positions(simd, &field.cell(corners), &monomials[half])[lane]
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
            let interpolants = field.cell(&samples.corners[cell]);
            let (mut least, mut nearest) = (distance, None);
            for block in samples.cell_blocks(cell) {
                let monomials: [_; 2] = monomials(simd, &block.positions);
                for (half, monomials) in monomials.iter().enumerate().take(block.halves()) {
                    let positions = field.positions(simd, &interpolants, monomials);
                    for (lane, position) in positions.into_iter().enumerate() {
                        let distance = field.shape.signed_distance(&position).distance;
                        if distance <= least {
                            (least, nearest) =
                                (distance, Some(Sample { position, block, index: [half, lane] }));
                        }
                    }
                }
            }
            if let Some(sample) = nearest {
                visit(cell, sample);
            }
        }
    }
}
