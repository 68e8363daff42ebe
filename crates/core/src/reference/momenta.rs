//! Computes the momenta of points with masses.

use nalgebra::{Matrix3, Vector3};

/// Linear and angular momentum of points with masses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Momenta {
    /// Total mass.
    pub mass: f64,
    /// Center of mass.
    pub center: Vector3<f64>,
    /// Linear momentum.
    pub linear: Vector3<f64>,
    /// Angular momentum about the center of mass.
    pub angular: Vector3<f64>,
}

/// A point with a mass and a velocity.
#[derive(Clone, Copy, Debug)]
pub struct Mass {
    /// Mass of the point.
    pub mass: f64,
    /// Position of the point.
    pub position: Vector3<f64>,
    /// Velocity of the point.
    pub velocity: Vector3<f64>,
}

impl Momenta {
    /// Computes the momenta of points.
    pub fn of(points: impl Iterator<Item = Mass> + Clone) -> Self {
        let mass: f64 = points.clone().map(|point| point.mass).sum();
        let center: Vector3<f64> = points.clone().map(|point| point.position * (point.mass / mass)).sum();
        let linear = points.clone().map(|point| point.velocity * point.mass).sum();
        let angular = points.map(|point| (point.position - center).cross(&point.velocity) * point.mass).sum();
        Self { mass, center, linear, angular }
    }

    /// Returns the rigid velocity that changes the momenta of `points` from `self` to `to` if it is added to
    /// the velocities.
    ///
    /// The result is the velocity of the center of mass and the angular velocity about the center of mass.
    /// The angular velocity is zero if the points are collinear.
    pub fn missing(&self, to: &Self, points: impl Iterator<Item = Mass>) -> (Vector3<f64>, Vector3<f64>) {
        let inertia: Matrix3<f64> = points
            .map(|point| {
                let d = point.position - self.center;
                (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * point.mass
            })
            .sum();
        // The inertia of collinear points is singular.
        let spin =
            inertia.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * (to.angular - self.angular));
        ((to.linear - self.linear) / self.mass, spin)
    }
}
