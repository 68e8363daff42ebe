//! Bounds of bodies and cells, against which colliders are tested before any sample is.

use nalgebra::{Point3, Vector3};

use super::SKIN;
use crate::Lanes;
use crate::dynamics::colliders::PosedCollider;

/// Whether anything in the box `centre ± half` may be within the skin of the collider; false for bounds that
/// are not numbers.
pub(super) fn may_touch(collider: &PosedCollider, centre: &Point3<f64>, half: &Vector3<f64>) -> bool {
    collider.shape.lower_bound(centre, half) <= SKIN
}

/// Bounds of all slots: centre, half extents. Slots without a vertex can but make them larger.
pub(super) fn bounds_of_slots(positions: &Lanes<3>) -> (Point3<f64>, Vector3<f64>) {
    let (mut low, mut high) = ([[f32::INFINITY; 8]; 3], [[f32::NEG_INFINITY; 8]; 3]);
    for block in positions.blocks() {
        for ((low, high), row) in low.iter_mut().zip(&mut high).zip(block) {
            for ((low, high), &x) in low.iter_mut().zip(high).zip(row.iter()) {
                // Comparisons, not `min` and `max`: one instruction for the eight lanes.
                *low = if x < *low { x } else { *low };
                *high = if x > *high { x } else { *high };
            }
        }
    }
    let corner = |rows: &[[f32; 8]; 3], lane: usize| rows.map(|row| row[lane]);
    let corners: [[f32; 3]; 16] =
        std::array::from_fn(|k| if k < 8 { corner(&low, k) } else { corner(&high, k - 8) });
    bounds(corners.iter())
}

/// Centre and half extents of the bounds of some points, a little larger than they are.
pub(super) fn bounds<'a>(places: impl Iterator<Item = &'a [f32; 3]>) -> (Point3<f64>, Vector3<f64>) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for place in places {
        for ((low, high), &x) in low.iter_mut().zip(&mut high).zip(place) {
            *low = if x < *low { x } else { *low };
            *high = if x > *high { x } else { *high };
        }
    }
    let (low, high) = (low.map(f64::from), high.map(f64::from));
    let centre = Point3::from(std::array::from_fn(|a| 0.5 * (low[a] + high[a])));
    // Room for places within the cell that are 1 and a rounding.
    let half = Vector3::from_fn(|a, _| 0.5 * (high[a] - low[a]) * (1.0 + 1e-5));
    (centre, half)
}
