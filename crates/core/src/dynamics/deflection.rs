//! Deflections of the supports of a body: see [`elastic_damping`](super::elastic_damping).

use nalgebra::Vector3;

use crate::state::Deflection;

/// Least limit of a deflection: an angle in rad, or a length as a fraction of the size of the body. A body that sways
/// loses up to 4 c times the limit of its angular velocity between two reversals.
const LEAST_LIMIT: f64 = 5e-4;

/// Greatest limit of a deflection.
const GREATEST_LIMIT: f64 = 0.02;

/// Distance beyond the limit after which the limit is divided by e.
const MEMORY: f64 = 0.2;

/// Adds `change` to a deflection. Returns its direction if it is at the limit and grows.
pub(super) fn deflect(deflection: &mut Deflection, change: Vector3<f64>) -> Option<Vector3<f64>> {
    let Deflection { vector, limit, is_at_limit } = deflection;
    if *is_at_limit && change.dot(&Vector3::from(*vector)) < 0.0 {
        (*limit, *is_at_limit) = ((2.0 * *limit).min(GREATEST_LIMIT), false);
    }
    *limit = limit.max(LEAST_LIMIT);
    let moved = Vector3::from(*vector) + change;
    let length = moved.norm();
    if !length.is_finite() {
        *vector = [0.0; 3];
        return None;
    }
    if length < *limit {
        *vector = moved.into();
        return None;
    }
    let direction = moved / length;
    *limit = (*limit * libm::exp(-(length - *limit) / MEMORY)).max(LEAST_LIMIT);
    (*vector, *is_at_limit) = ((direction * *limit).into(), true);
    (change.dot(&direction) > 0.0).then_some(direction)
}

/// Returns three perpendicular unit vectors, or the two that are perpendicular to `free`, and the zero vector.
pub(super) fn axes_without(free: Option<Vector3<f64>>) -> [Vector3<f64>; 3] {
    match free {
        None => [Vector3::x(), Vector3::y(), Vector3::z()],
        Some(direction) => {
            let helper = Vector3::ith(direction.iamin(), 1.0);
            let first = direction.cross(&helper).normalize();
            [first, direction.cross(&first), Vector3::zeros()]
        }
    }
}
