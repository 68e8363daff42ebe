//! Bounds of bodies and cells, against which colliders are tested before any sample is.

use nalgebra::{Point3, Vector3};

use super::quad::Quad;
use crate::contact::posed::PosedShape;

/// Whether anything in the bounds of some places may be nearer to the shape than `skin`; false for places that are
/// not numbers.
pub(super) fn may_touch<'a>(shape: &PosedShape, places: impl Iterator<Item = &'a Quad>, skin: f64) -> bool {
    let (centre, half) = bounds(places);
    shape.lower_bound(&centre, &half) <= skin
}

/// Centre and half extents of the bounds of some places, a little larger than they are.
fn bounds<'a>(places: impl Iterator<Item = &'a Quad>) -> (Point3<f64>, Vector3<f64>) {
    let (mut low, mut high) = ([f32::INFINITY; 4], [f32::NEG_INFINITY; 4]);
    for place in places {
        for c in 0..4 {
            // Comparisons, not `min` and `max`: one instruction for all.
            low[c] = if place[c] < low[c] { place[c] } else { low[c] };
            high[c] = if place[c] > high[c] { place[c] } else { high[c] };
        }
    }
    let (low, high) = (low.map(f64::from), high.map(f64::from));
    let centre = Point3::from(std::array::from_fn(|a| 0.5 * (low[a] + high[a])));
    // Room for places within the cell that are 1 and a rounding.
    let half = Vector3::from_fn(|a, _| 0.5 * (high[a] - low[a]) * (1.0 + 1e-5));
    (centre, half)
}
