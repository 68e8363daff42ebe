//! Computes how far a body is from its rest shape.

use nalgebra::{Matrix3, Vector3};
use supple::reference;

/// Returns the root mean square distance of positions from the rest shape, after the rest shape is moved by
/// the rigid motion that fits best (weighted by mass).
pub(crate) fn shape_distance(masses: &[f64], rest: &[Vector3<f64>], now: &[Vector3<f64>]) -> f64 {
    let (rest_center, center) = (mean(masses, rest), mean(masses, now));
    let moments = rest.iter().zip(now).zip(masses);
    let moments: Matrix3<f64> =
        moments.map(|((x0, x), m)| (x - center) * (x0 - rest_center).transpose() * *m).sum();
    let rotation = reference::rotation(&moments);
    let moved: Vec<_> = rest.iter().map(|x| rotation * (x - rest_center) + center).collect();
    distance(&moved, now)
}

/// Returns the root mean square distance of corresponding points.
pub(crate) fn distance(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>() / a.len() as f64).sqrt()
}

/// Returns the mean of the positions or velocities `x`, weighted by mass.
pub(crate) fn mean(masses: &[f64], x: &[Vector3<f64>]) -> Vector3<f64> {
    x.iter().zip(masses).map(|(x, m)| x * *m).sum::<Vector3<f64>>() / masses.iter().sum::<f64>()
}
