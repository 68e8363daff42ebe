//! Finds the limits within which lattice vertices may move without the surface entering a collider.
//!
//! The surface is represented by its samples, which are grouped by lattice cell ([`SampleCells`]).

use std::borrow::Cow;

use nalgebra::Vector3;

use super::found::Found;
use crate::body::{BodyRef, DisplayContext};
use crate::contact::{Colliders, Contacts, MovedSamples, PosedShape, SampleCells};
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

    /// Returns the shapes that samples may enter within the limits of [`find`]: those other than planes,
    /// and with a smooth skin all, because its samples are not weighted means of the corners of their cells.
    fn curved(&self) -> impl Iterator<Item = PosedShape<'_>> {
        let is_smooth = self.samples.is_smooth();
        self.shapes().filter(move |shape| is_smooth || shape.plane().is_none())
    }

    /// Returns whether [`add_entered`] may add limits.
    pub(super) fn is_any_curved(&self) -> bool {
        self.curved().next().is_some()
    }

    /// Returns the greatest displacement of a sample, relative to the greatest displacement of a vertex.
    pub(super) fn greatest_factor(&self) -> f64 {
        self.samples.greatest_factor()
    }
}

/// Finds the limits of the vertices whose displacement by `distance` cells from `start` could move a sample into a
/// collider.
///
/// For each collider, a vertex gets a limit if a sample in the cells around the vertex is within
/// `distance` of the collider. The clearance of the limit is the least distance of these samples from the
/// collider, at least 0.
///
/// With a linear skin, a sample is a weighted mean of the corners of its cell. If no corner moves farther against
/// the normal of a plane than the least distance of the cell's samples, no sample of the cell enters the plane. For
/// other shapes, whose normal is not constant, and for a smooth skin, [`add_entered`] is needed too.
pub(super) fn find(
    surface: &mut MovedSamples,
    obstacles: &Obstacles<'_>,
    start: &[[f32; 3]],
    distance: f64,
    found: &mut Found,
) {
    let samples = &*obstacles.samples;
    surface.set_start(samples, start);
    for shape in obstacles.shapes() {
        found.begin(start.len());
        surface.for_each_near(samples, &shape, distance, |position, vertices| {
            let nearest = shape.signed_distance(&position);
            let (normal, clearance) = (nearest.normal, nearest.distance);
            for vertex in vertices {
                found.add(vertex, Limit { vertex, normal, clearance, is_soft: false });
            }
        });
        found.end();
    }
}

/// Adds limits for the cells in which a moved sample enters a collider other than a plane, or with a smooth
/// skin any collider. Returns whether any limit was added. Must be called after [`find`].
///
/// * `start`: the positions that were passed to [`find`].
/// * `moved`: the positions after the displacement, one per lattice vertex.
///
/// The corners of a cell get limits if the deepest sample of the cell has sunk into the collider by more
/// than [`TOLERANCE`]: from the surface of the collider, or from its start if this is already inside. Let `n` be the
/// normal of the collider at the start, and `P` the tangent plane of the collider with this normal (or the plane
/// through the start, if it is inside). The limits reduce the displacement of each corner against `n` by the distance
/// of the moved sample behind `P`, so that the sample does not pass `P`. A convex collider lies
/// entirely behind its tangent planes, so a sample that was outside does not enter the collider. A sample of a
/// smooth skin also depends on vertices around its cell, so that further rounds may be needed.
pub(super) fn add_entered(
    surface: &mut MovedSamples,
    obstacles: &Obstacles<'_>,
    [start, moved]: [&[[f32; 3]]; 2],
    found: &mut Found,
) -> bool {
    let samples = &*obstacles.samples;
    surface.set_moved(samples, moved);
    let mut has_added = false;
    for shape in obstacles.curved() {
        found.begin(moved.len());
        surface.for_each_entered(samples, &shape, |[before, after], vertices| {
            let nearest = shape.signed_distance(&before);
            if shape.signed_distance(&after).distance >= nearest.distance.min(0.0) - TOLERANCE {
                return;
            }
            let normal = nearest.normal;
            let room = (after - before).dot(&normal) + nearest.distance.max(0.0);
            for vertex in vertices {
                let [from, to] = [start, moved].map(|positions| positions[vertex as usize]);
                let displacement = Vector3::from_fn(|k, _| f64::from(to[k] - from[k]));
                let clearance = room - normal.dot(&displacement);
                found.add(vertex, Limit { vertex, normal, clearance, is_soft: false });
            }
        });
        has_added |= found.end();
    }
    has_added
}
