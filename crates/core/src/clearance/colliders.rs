//! Finds the limits within which lattice vertices may move without the surface entering a collider.
//!
//! The surface is represented by its samples, which are grouped by lattice cell ([`SampleCells`]). A *row* is
//! an index into `SampleCells::vertices`.

use std::borrow::Cow;

use fearless_simd::{Simd, dispatch};
use nalgebra::Point3;

use super::found::Found;
use crate::body::{BodyRef, DisplayContext};
use crate::contact::{
    Colliders, Contacts, Field, PosedShape, SMOOTH_DISPLACEMENT, SampleBlock, SampleCells, ShapeField,
    SmoothRows, Vec4, monomials, wide,
};
use crate::simd::level;
use crate::state::BodyFrame;
use crate::volume::Limit;

/// Tolerated increase of the depth of a sample in a collider by a displacement, in cells.
const TOLERANCE: f64 = 1e-3;

/// Colliders around a body at one time, and the samples of its surface.
pub(super) struct Obstacles<'a> {
    colliders: &'a Colliders,
    /// Time in seconds, at which moving colliders are evaluated.
    time: f64,
    frame: BodyFrame,
    /// Thickness of the body in scene units.
    thickness: f64,
    samples: Cow<'a, SampleCells>,
}

/// The search for the limits at colliders.
#[derive(Debug, Default)]
pub(super) struct ColliderSearch {
    start: Posed,
    moved: Posed,
}

/// Positions of the vertices of all rows.
#[derive(Debug, Default)]
struct Posed {
    positions: Vec<Vec4>,
    /// Slopes of the positions, if the skin is smooth, and of `ColliderSearch::start` their weights.
    slopes: SmoothRows,
}

impl<'a> Obstacles<'a> {
    /// Returns the colliders around a body; `None` if none is enabled, or if the body touches none.
    pub(super) fn around(body: BodyRef<'a>) -> Option<Self> {
        let DisplayContext { colliders, time, .. } = body.context()?;
        let body = body.get();
        (colliders.any_enabled() && !body.touching().soft_only).then(|| {
            // A body that has not yet been stepped in this simulation has no samples.
            let samples = body.contacts().map(Contacts::samples).map(Cow::Borrowed);
            let samples = samples.unwrap_or_else(|| Cow::Owned(body.create_samples(1.0)));
            let thickness = body.touching().thickness;
            Self { colliders, time, frame: body.frame(), thickness, samples }
        })
    }

    /// Returns the shapes of the enabled colliders in the body's frame.
    fn shapes(&self) -> impl Iterator<Item = PosedShape<'_>> {
        self.colliders.at(self.time, self.frame, self.thickness)
    }

    /// Returns the shapes that samples may enter within the limits of [`ColliderSearch::find`]: those other than planes,
    /// and with a smooth skin all, because its samples are not weighted means of the corners of their cells.
    fn curved(&self) -> impl Iterator<Item = PosedShape<'_>> {
        let is_smooth = self.samples.stencils().is_some();
        self.shapes().filter(move |shape| is_smooth || shape.plane().is_none())
    }

    /// Returns whether [`ColliderSearch::add_entered`] may add limits.
    pub(super) fn is_any_curved(&self) -> bool {
        self.curved().next().is_some()
    }

    /// Returns the greatest displacement of a sample, relative to the greatest displacement of a vertex.
    pub(super) fn greatest_factor(&self) -> f64 {
        if self.samples.stencils().is_some() { SMOOTH_DISPLACEMENT } else { 1.0 }
    }
}

impl ColliderSearch {
    /// Finds the limits of the vertices whose displacement by `distance` cells from `start` could move a sample into a
    /// collider.
    ///
    /// For each collider, a vertex gets a limit if a sample in the cells around the vertex is within
    /// `distance` of the collider. The clearance of the limit is the least distance of these samples from the
    /// collider, at least 0.
    ///
    /// With a linear skin, a sample is a weighted mean of the corners of its cell. If no corner moves farther against
    /// the normal of a plane than the least distance of the cell's samples, no sample of the cell enters the plane. For
    /// other shapes, whose normal is not constant, and for a smooth skin, [`add_entered`](Self::add_entered) is needed as
    /// well.
    pub(super) fn find(
        &mut self,
        obstacles: &Obstacles<'_>,
        start: &[[f32; 3]],
        distance: f64,
        found: &mut Found,
    ) {
        let samples = &*obstacles.samples;
        self.start.set(samples, start);
        if let Some(stencils) = samples.stencils() {
            self.start.slopes.update_slope_weights(stencils, &self.start.positions);
        }
        for shape in obstacles.shapes() {
            found.begin(start.len());
            let field = self.field(&self.start, samples, &shape);
            if field.any_may_touch(distance) {
                dispatch!(level(), simd => search(simd, &field, samples, distance, |cell, sample| {
                    let nearest = shape.signed_distance(&sample.position);
                    for &row in &samples.corners[cell] {
                        let vertex = samples.vertices[row as usize];
                        let (normal, clearance) = (nearest.normal, nearest.distance);
                        found.add(vertex, Limit { vertex, normal, clearance, is_soft: false });
                    }
                }));
            }
            found.end();
        }
    }

    /// Adds limits for the cells in which a moved sample enters a collider other than a plane, or with a smooth
    /// skin any collider. Returns whether any limit was added. Must be called after [`find`](Self::find).
    ///
    /// * `moved`: moved positions, one per lattice vertex.
    ///
    /// The corners of a cell get limits if the deepest sample of the cell has sunk into the collider by more
    /// than [`TOLERANCE`]: from the surface of the collider, or from its start if this is already inside. Let `n` be the
    /// normal of the collider at the start, and `P` the tangent plane of the collider with this normal (or the plane
    /// through the start, if it is inside). The limits reduce the displacement of each corner against `n` by the distance
    /// of the moved sample behind `P`, so that the sample does not pass `P`. A convex collider lies
    /// entirely behind its tangent planes, so a sample that was outside does not enter the collider. A sample of a
    /// smooth skin also depends on vertices around its cell, so that further rounds may be needed.
    pub(super) fn add_entered(
        &mut self,
        obstacles: &Obstacles<'_>,
        moved: &[[f32; 3]],
        found: &mut Found,
    ) -> bool {
        let samples = &*obstacles.samples;
        self.moved.set(samples, moved);
        let mut has_added = false;
        for shape in obstacles.curved() {
            found.begin(moved.len());
            let [start, entered] = [&self.start, &self.moved].map(|posed| self.field(posed, samples, &shape));
            if entered.any_may_touch(0.0) {
                dispatch!(level(), simd => search(simd, &entered, samples, 0.0, |cell, sample| {
                    let position = sample.position_in(simd, &start, &samples.corners[cell]);
                    let before = shape.signed_distance(&position);
                    if shape.signed_distance(&sample.position).distance >= before.distance.min(0.0) - TOLERANCE {
                        return;
                    }
                    let normal = before.normal;
                    let room = (sample.position - position).dot(&normal) + before.distance.max(0.0);
                    for &row in &samples.corners[cell] {
                        let vertex = samples.vertices[row as usize];
                        let moved = entered.positions[row as usize] - start.positions[row as usize];
                        let clearance = room - normal.dot(&wide(&moved));
                        found.add(vertex, Limit { vertex, normal, clearance, is_soft: false });
                    }
                }));
            }
            has_added |= found.end();
        }
        has_added
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
    pub(super) fn bytes(&self) -> usize {
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
