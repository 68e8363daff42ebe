//! Clearance: the limits within which lattice vertices may move without the surface entering a collider.

use fearless_simd::{Simd, dispatch};
use nalgebra::{Point3, Vector3};

use super::limits::Limit;
use crate::contact::{
    Colliders, Field, PosedShape, RowSet, SampleBlock, SampleCells, ShapeField, SignedDistance, Vec4,
    may_touch, monomials, wide,
};
use crate::simd::level;
use crate::state::BodyFrame;

/// Tolerated increase of a sample's depth by the correction, in cells.
const TOLERANCE: f64 = 1e-3;

/// Search of the limits, with its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Clearance {
    /// Position of the vertex in each row of the samples, in the body's frame, without the correction.
    places: Vec<Vec4>,
    /// Position of the vertex in each row with the correction.
    corrected: Vec<Vec4>,
    rows: RowSet,
    /// Nearest sample of each row of `rows`.
    nearest: Vec<Nearest>,
    pub(super) limits: Vec<Limit>,
}

/// Colliders at one time, in the frame of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacles<'a> {
    pub(crate) colliders: &'a Colliders,
    /// Time in seconds.
    pub(crate) time: f64,
    /// Frame of the body.
    pub(crate) frame: BodyFrame,
}

/// Sample with the least clearance in the cells around a vertex.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    /// Distance from the collider in cells; `add_entered` subtracts the displacement against the normal.
    clearance: f64,
    /// Unit normal away from the collider.
    normal: Vector3<f64>,
}

impl Clearance {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let places = size_of_val(&*self.places) + size_of_val(&*self.corrected);
        places + self.rows.bytes() + size_of_val(&*self.nearest) + size_of_val(&*self.limits)
    }

    /// Finds the limits of the vertices whose displacement by `distance` cells could move a sample into a
    /// collider.
    ///
    /// There is one limit for each vertex and collider. `positions`: one per lattice vertex, in cells of the
    /// body's frame. A sample lies in the convex hull of its cell's corners. If no corner moves farther than
    /// the least clearance of the cell's samples, no sample of the cell enters a plane. Curved shapes need
    /// [`add_entered`](Self::add_entered) too.
    pub(super) fn find(
        &mut self,
        samples: &SampleCells,
        positions: &[[f32; 3]],
        obstacles: &Obstacles<'_>,
        distance: f64,
    ) {
        read(&mut self.places, samples, positions);
        self.rows.resize(samples.vertices.len());
        self.limits.clear();
        for shape in obstacles.shapes() {
            self.clear();
            let field = ShapeField { shape: &shape, places: &self.places };
            if may_touch(&shape, self.places.iter(), distance) {
                let (rows, nearest) = (&mut self.rows, &mut self.nearest);
                dispatch!(level(), simd => search(simd, &field, samples, distance, |cell, sample| {
                    let SignedDistance { distance: clearance, normal } = shape.signed_distance(&sample.place);
                    keep_nearest(rows, nearest, &samples.corners[cell], Nearest { clearance, normal });
                }));
            }
            self.limits.extend(limits(samples, &self.rows, &self.nearest, |_| Vector3::zeros()));
        }
    }

    /// Adds limits for cells whose corrected surface enters a curved collider; returns whether there are any.
    ///
    /// The displacement of each corner is cut back along the normal at the sample's uncorrected position, so
    /// that the sample does not pass the tangent plane of the collider there. A convex collider lies entirely
    /// behind that plane.
    pub(super) fn add_entered(
        &mut self,
        samples: &SampleCells,
        positions: &[[f32; 3]],
        obstacles: &Obstacles<'_>,
    ) -> bool {
        let before = self.limits.len();
        read(&mut self.corrected, samples, positions);
        for shape in obstacles.shapes().filter(|shape| shape.plane().is_none()) {
            self.clear();
            let Self { places, corrected, rows, nearest, .. } = self;
            if may_touch(&shape, corrected.iter(), 0.0) {
                let entered = ShapeField { shape: &shape, places: corrected };
                let uncorrected = ShapeField { shape: &shape, places };
                dispatch!(level(), simd => search(simd, &entered, samples, 0.0, |cell, sample| {
                    let place = sample.place_in(simd, &uncorrected, &samples.corners[cell]);
                    let before = shape.signed_distance(&place);
                    let after = shape.signed_distance(&sample.place);
                    if after.distance < before.distance.min(0.0) - TOLERANCE {
                        let moved = (sample.place - place).dot(&before.normal);
                        let (clearance, normal) = (moved + before.distance.max(0.0), before.normal);
                        keep_nearest(rows, nearest, &samples.corners[cell], Nearest { clearance, normal });
                    }
                }));
            }
            let displacement = |row: usize| wide(&(self.corrected[row] - self.places[row]));
            self.limits.extend(limits(samples, &self.rows, &self.nearest, displacement));
        }
        self.limits.len() > before
    }

    /// Clears the search of one collider.
    fn clear(&mut self) {
        self.rows.clear();
        self.nearest.clear();
    }
}

impl Obstacles<'_> {
    /// Returns whether any collider is not a plane, and so needs [`Clearance::add_entered`].
    pub(super) fn are_curved(&self) -> bool {
        self.shapes().any(|shape| shape.plane().is_none())
    }

    /// Returns the shapes in the body's frame.
    fn shapes(&self) -> impl Iterator<Item = PosedShape> {
        self.colliders.at(self.time, self.frame)
    }
}

/// Copies the positions of the samples' vertices.
fn read(places: &mut Vec<Vec4>, samples: &SampleCells, positions: &[[f32; 3]]) {
    places.clear();
    places.extend(samples.vertices.iter().map(|&vertex| {
        let [x, y, z] = positions[vertex as usize];
        Vec4::new(x, y, z, 0.0)
    }));
}

/// Returns the limits of the vertices in `rows`, which already have a displacement.
fn limits(
    samples: &SampleCells,
    rows: &RowSet,
    nearest: &[Nearest],
    displacement: impl Fn(usize) -> Vector3<f64>,
) -> impl Iterator<Item = Limit> {
    rows.list().iter().zip(nearest).map(move |(&row, nearest)| Limit {
        vertex: samples.vertices[row as usize],
        normal: nearest.normal,
        clearance: (nearest.clearance - nearest.normal.dot(&displacement(row as usize))).max(0.0),
    })
}

/// Keeps, for each corner of a cell, the sample with the least clearance.
fn keep_nearest(rows: &mut RowSet, nearest: &mut Vec<Nearest>, corners: &[u32; 8], sample: Nearest) {
    for &row in corners {
        let number = rows.number(row) as usize;
        if number == nearest.len() {
            nearest.push(sample);
        } else if sample.clearance < nearest[number].clearance {
            nearest[number] = sample;
        }
    }
}

/// Sample of a cell: its position, and its place in its block.
struct Sample<'a> {
    place: Point3<f64>,
    block: &'a SampleBlock,
    half: usize,
    lane: usize,
}

impl Sample<'_> {
    /// Returns its position with the vertex positions of another field.
    #[inline(always)]
    fn place_in<S: Simd>(&self, simd: S, field: &ShapeField<'_>, corners: &[u32; 8]) -> Point3<f64> {
        let monomials = &monomials(simd, &self.block.places)[self.half];
        field.places(simd, &field.cell(corners), monomials)[self.lane]
    }
}

/// Calls `visit` with the nearest sample of each cell that has a sample within `distance` of a shape.
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

/// Returns the sample of a cell that is nearest to a shape, if it is within `limit`.
#[inline(always)]
fn nearest_sample<'a, S: Simd>(
    simd: S,
    field: &ShapeField<'_>,
    samples: &'a SampleCells,
    cell: usize,
    limit: f64,
) -> Option<Sample<'a>> {
    let interpolants = field.cell(&samples.corners[cell]);
    let (mut least, mut found) = (limit, None);
    for block in samples.cell_blocks(cell) {
        for (half, monomials) in monomials(simd, &block.places).iter().enumerate() {
            for (lane, place) in field.places(simd, &interpolants, monomials).into_iter().enumerate() {
                let distance = field.shape.signed_distance(&place).distance;
                if distance <= least {
                    (least, found) = (distance, Some(Sample { place, block, half, lane }));
                }
            }
        }
    }
    found
}
