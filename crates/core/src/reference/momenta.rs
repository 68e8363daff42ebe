//! Momenta of points with masses.

use nalgebra::{Matrix3, Vector3};

/// Momenta of points with masses, and the center that the angular one is about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Momenta {
    /// All masses.
    pub mass: f64,
    /// Their center.
    pub center: Vector3<f64>,
    /// The linear momentum.
    pub linear: Vector3<f64>,
    /// The angular momentum about the center.
    pub angular: Vector3<f64>,
}

/// A point in motion.
#[derive(Clone, Copy, Debug)]
pub struct Mass {
    /// Its mass.
    pub mass: f64,
    /// Where it is.
    pub position: Vector3<f64>,
    /// How fast it moves.
    pub velocity: Vector3<f64>,
}

impl Momenta {
    /// Those of some points.
    pub fn of(points: impl Iterator<Item = Mass> + Clone) -> Self {
        let mass: f64 = points.clone().map(|point| point.mass).sum();
        let center: Vector3<f64> = points.clone().map(|point| point.position * (point.mass / mass)).sum();
        let linear = points.clone().map(|point| point.velocity * point.mass).sum();
        let angular = points.map(|point| (point.position - center).cross(&point.velocity) * point.mass).sum();
        Self { mass, center, linear, angular }
    }

    /// The rigid velocity that gives points with these momenta those of `aim`: of the center, and the spin about it.
    pub fn missing(&self, aim: &Self, points: impl Iterator<Item = Mass>) -> (Vector3<f64>, Vector3<f64>) {
        let inertia: Matrix3<f64> = points
            .map(|point| {
                let d = point.position - self.center;
                (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * point.mass
            })
            .sum();
        // Points on a line have no spin about it to be given.
        let spin =
            inertia.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * (aim.angular - self.angular));
        ((aim.linear - self.linear) / self.mass, spin)
    }
}
