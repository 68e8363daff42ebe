//! The correction beside colliders: how far lattice vertices may be moved before the surface that they carry meets one.

use fearless_simd::{Simd, dispatch};
use nalgebra::{Point3, Vector3};

use super::limits::Limit;
use crate::contact::{
    Colliders, Curved, Field, PosedShape, RowSet, SampleBlock, SampleCells, SignedDistance, Vec4, may_touch,
    monomials, wide,
};
use crate::simd::level;
use crate::state::BodyFrame;

/// A sample that is deeper by more than this, in cells, once it is corrected, is one that enters.
const TOLERANCE: f64 = 1e-3;

/// Finds the limits; its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Clearance {
    /// Place of the vertex in each row of the samples, local: without the correction, and with it.
    places: Vec<Vec4>,
    corrected: Vec<Vec4>,
    rows: RowSet,
    /// Of each numbered row.
    nearest: Vec<Nearest>,
    pub(super) limits: Vec<Limit>,
}

/// What a body may enter, as it is at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacles<'a> {
    pub(crate) colliders: &'a Colliders,
    /// In seconds.
    pub(crate) time: f64,
    /// Of the body.
    pub(crate) frame: BodyFrame,
}

/// Of the cells at a vertex the sample that has the least room.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    /// Its distance from the collider, or how much less deep it was before the correction, in cells.
    room: f64,
    /// Away from the collider.
    normal: Vector3<f64>,
}

impl Clearance {
    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        let places = size_of_val(&*self.places) + size_of_val(&*self.corrected);
        places + self.rows.bytes() + size_of_val(&*self.nearest) + size_of_val(&*self.limits)
    }

    /// Finds the limits of all vertices that may go as far as `reach`, in cells, and would then bring a sample to a
    /// collider; one for each vertex and collider. `positions`: one per lattice vertex, in cells of the body's frame.
    ///
    /// Samples lie between the corners of their cells: where none of these goes farther than the nearest of the cell's
    /// samples has room, none of the samples enters a plane. Other shapes turn away within a cell: see [`cut`](Self::cut).
    pub(super) fn find(
        &mut self,
        samples: &SampleCells,
        positions: &[[f32; 3]],
        obstacles: &Obstacles<'_>,
        reach: f64,
    ) {
        read(&mut self.places, samples, positions);
        self.rows.resize(samples.vertices.len());
        self.limits.clear();
        for shape in obstacles.shapes() {
            self.begin();
            let field = Curved { shape: &shape, places: &self.places };
            if may_touch(&shape, self.places.iter(), reach) {
                let (rows, nearest) = (&mut self.rows, &mut self.nearest);
                dispatch!(level(), simd => search(simd, &field, samples, reach, |cell, sample| {
                    let SignedDistance { distance: room, normal } = shape.signed_distance(&sample.place);
                    take(rows, nearest, &samples.corners[cell], Nearest { room, normal });
                }));
            }
            self.limits.extend(limits(samples, &self.rows, &self.nearest, |_| Vector3::zeros()));
        }
    }

    /// Adds limits where the corrected surface enters a collider all the same, so that each corner of such a cell goes as
    /// much less far as a sample of it goes too far against the normal where it was: no point of a convex collider lies
    /// before that. Says whether there is any.
    pub(super) fn cut(
        &mut self,
        samples: &SampleCells,
        positions: &[[f32; 3]],
        obstacles: &Obstacles<'_>,
    ) -> bool {
        let before = self.limits.len();
        read(&mut self.corrected, samples, positions);
        for shape in obstacles.shapes().filter(|shape| shape.plane().is_none()) {
            self.begin();
            let Self { places, corrected, rows, nearest, .. } = self;
            if may_touch(&shape, corrected.iter(), 0.0) {
                let entered = Curved { shape: &shape, places: corrected };
                let plain = Curved { shape: &shape, places };
                dispatch!(level(), simd => search(simd, &entered, samples, 0.0, |cell, sample| {
                    let place = sample.in_field(simd, &plain, &samples.corners[cell]);
                    let before = shape.signed_distance(&place);
                    let after = shape.signed_distance(&sample.place);
                    if after.distance < before.distance.min(0.0) - TOLERANCE {
                        let way = (sample.place - place).dot(&before.normal);
                        let (room, normal) = (way + before.distance.max(0.0), before.normal);
                        take(rows, nearest, &samples.corners[cell], Nearest { room, normal });
                    }
                }));
            }
            let way = |row: usize| wide(&(self.corrected[row] - self.places[row]));
            self.limits.extend(limits(samples, &self.rows, &self.nearest, way));
        }
        self.limits.len() > before
    }

    fn begin(&mut self) {
        self.rows.clear();
        self.nearest.clear();
    }
}

impl Obstacles<'_> {
    /// Whether any of them turns away within a cell, so that [`Clearance::cut`] has something to do.
    pub(super) fn are_curved(&self) -> bool {
        self.shapes().any(|shape| shape.plane().is_none())
    }

    fn shapes(&self) -> impl Iterator<Item = PosedShape> {
        self.colliders.at(self.time, self.frame)
    }
}

/// Reads the places of the samples' vertices.
fn read(places: &mut Vec<Vec4>, samples: &SampleCells, positions: &[[f32; 3]]) {
    places.clear();
    places.extend(samples.vertices.iter().map(|&vertex| {
        let [x, y, z] = positions[vertex as usize];
        Vec4::new(x, y, z, 0.0)
    }));
}

/// The limits of the vertices in some rows, each of which has gone some way already.
fn limits(
    samples: &SampleCells,
    rows: &RowSet,
    nearest: &[Nearest],
    way: impl Fn(usize) -> Vector3<f64>,
) -> impl Iterator<Item = Limit> {
    rows.list().iter().zip(nearest).map(move |(&row, nearest)| Limit {
        vertex: samples.vertices[row as usize],
        normal: nearest.normal,
        room: (nearest.room - nearest.normal.dot(&way(row as usize))).max(0.0),
    })
}

/// Each corner of a cell keeps the sample that has the least room.
fn take(rows: &mut RowSet, nearest: &mut Vec<Nearest>, corners: &[u32; 8], sample: Nearest) {
    for &row in corners {
        let number = rows.number(row) as usize;
        if number == nearest.len() {
            nearest.push(sample);
        } else if sample.room < nearest[number].room {
            nearest[number] = sample;
        }
    }
}

/// A sample of a cell: where it is, and what it is in its block.
struct Sample<'a> {
    place: Point3<f64>,
    block: &'a SampleBlock,
    half: usize,
    lane: usize,
}

impl Sample<'_> {
    /// Where it is among other places of the vertices at the corners of its cell.
    #[inline(always)]
    fn in_field<S: Simd>(&self, simd: S, field: &Curved<'_>, corners: &[u32; 8]) -> Point3<f64> {
        let monomials = &monomials(simd, &self.block.places)[self.half];
        field.places(simd, &field.cell(corners), monomials)[self.lane]
    }
}

/// The cells with a sample within `reach` of a shape, each with the nearest one.
#[inline(always)]
fn search<S: Simd>(
    simd: S,
    field: &Curved<'_>,
    samples: &SampleCells,
    reach: f64,
    mut found: impl FnMut(usize, Sample<'_>),
) {
    for (strip, cells) in samples.strips() {
        if !field.may_touch(strip, reach) {
            continue;
        }
        for cell in cells {
            if !field.may_touch(&samples.corners[cell], reach) {
                continue;
            }
            if let Some(sample) = nearest_sample(simd, field, samples, cell, reach) {
                found(cell, sample);
            }
        }
    }
}

/// The sample of a cell that is nearest to a shape, if any is within `reach`.
#[inline(always)]
fn nearest_sample<'a, S: Simd>(
    simd: S,
    field: &Curved<'_>,
    samples: &'a SampleCells,
    cell: usize,
    reach: f64,
) -> Option<Sample<'a>> {
    let known = field.cell(&samples.corners[cell]);
    let (mut least, mut found) = (reach, None);
    for block in samples.of_cell(cell) {
        for (half, monomials) in monomials(simd, &block.places).iter().enumerate() {
            for (lane, place) in field.places(simd, &known, monomials).into_iter().enumerate() {
                let distance = field.shape.signed_distance(&place).distance;
                if distance <= least {
                    (least, found) = (distance, Some(Sample { place, block, half, lane }));
                }
            }
        }
    }
    found
}
