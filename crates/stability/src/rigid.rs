//! The rigid motion that fits best, and how far a shape is from another up to one.

use nalgebra::{Matrix3, Vector3};
use supple::reference;

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
    let (centre, drift) = (mean(masses, x), mean(masses, v));
    let (mut angular, mut inertia) = (Vector3::zeros(), Matrix3::zeros());
    for ((x, v), m) in x.iter().zip(v).zip(masses) {
        let arm = x - centre;
        angular += arm.cross(&(v - drift)) * *m;
        inertia += (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * *m;
    }
    let spin = inertia.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * angular);
    x.iter().zip(v).map(|(x, v)| v - drift - spin.cross(&(x - centre))).collect()
}
