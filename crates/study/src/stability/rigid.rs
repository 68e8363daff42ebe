//! The rigid motion that fits best, and how far a shape is from another up to one.

use nalgebra::{Matrix3, Vector3};
use supple::reference::{self, Mass, Momenta};

/// x ≈ rotation (x0 - from) + to.
pub(crate) struct RigidMotion {
    rotation: Matrix3<f64>,
    from: Vector3<f64>,
    to: Vector3<f64>,
}

impl RigidMotion {
    /// The best one from `rest` to `now`, by masses.
    pub(crate) fn fit(masses: &[f64], rest: &[Vector3<f64>], now: &[Vector3<f64>]) -> Self {
        let (from, to) = (mean(masses, rest), mean(masses, now));
        let moments = rest.iter().zip(now).zip(masses);
        let moments: Matrix3<f64> = moments.map(|((x0, x), m)| (x - to) * (x0 - from).transpose() * *m).sum();
        Self { rotation: reference::rotation(&moments), from, to }
    }

    fn apply(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.rotation * (x - self.from) + self.to
    }

    /// Root mean square distance of `now` from where the motion puts `rest`.
    pub(crate) fn distance(&self, rest: &[Vector3<f64>], now: &[Vector3<f64>]) -> f64 {
        let moved: Vec<_> = rest.iter().map(|x| self.apply(x)).collect();
        distance(&moved, now)
    }
}

/// Root mean square distance.
pub(crate) fn distance(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).norm_squared()).sum::<f64>() / a.len() as f64).sqrt()
}

/// Mean by masses.
pub(crate) fn mean(masses: &[f64], x: &[Vector3<f64>]) -> Vector3<f64> {
    x.iter().zip(masses).map(|(x, m)| x * *m).sum::<Vector3<f64>>() / masses.iter().sum::<f64>()
}

/// Velocities without the rigid part that carries their momenta.
pub(crate) fn without_momenta(masses: &[f64], x: &[Vector3<f64>], v: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let points = masses.iter().zip(x).zip(v);
    let points = points.map(|((&mass, &position), &velocity)| Mass { mass, position, velocity });
    let momenta = Momenta::of(points.clone());
    let (drift, spin) = momenta.missing(&Momenta::default(), points);
    x.iter().zip(v).map(|(x, v)| v + drift + spin.cross(&(x - momenta.centre))).collect()
}
