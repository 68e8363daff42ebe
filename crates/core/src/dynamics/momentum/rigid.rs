//! A component as a rigid body: its centre, its momenta, and the velocity that it misses.

use nalgebra::{Matrix3, Vector3};

/// The momenta of one component: masses in full cells, lengths in cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Momentum {
    /// Σ m v, in cell masses times cells/s.
    pub(crate) linear: [f64; 3],
    /// Σ m (x - c) x v about the component's centre of mass.
    pub(crate) angular: [f64; 3],
}

/// A rigid velocity field v + ω x x, about the body's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RigidVelocity {
    pub(crate) linear: [f32; 3],
    pub(crate) angular: [f32; 3],
}

/// A component's mass, centre and momenta as its vertices have them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidState {
    pub(crate) mass: f64,
    pub(crate) centre: Vector3<f64>,
    pub(crate) momentum: Momentum,
    pub(super) inertia: Matrix3<f64>,
}

impl RigidState {
    /// The kinetic energy of a rigid body with these momenta.
    pub(super) fn rigid_energy(&self) -> f64 {
        let (linear, angular) = (Vector3::from(self.momentum.linear), Vector3::from(self.momentum.angular));
        0.5 * (linear.norm_squared() / self.mass + turn(&self.inertia, angular).dot(&angular))
    }

    /// The rigid velocity that brings the momenta to those of the book.
    pub(super) fn missing(&self, book: Momentum) -> RigidVelocity {
        let linear = (Vector3::from(book.linear) - Vector3::from(self.momentum.linear)) / self.mass;
        let angular = Vector3::from(book.angular) - Vector3::from(self.momentum.angular);
        let omega = turn(&self.inertia, angular);
        let at_origin = linear - omega.cross(&self.centre);
        let finite = at_origin.iter().chain(omega.iter()).all(|x| x.is_finite());
        if !finite {
            return RigidVelocity::default();
        }
        RigidVelocity { linear: narrow(at_origin), angular: narrow(omega) }
    }
}

/// ω with I ω = l, leaving out the axes about which the component has next to no inertia: points on a line, or on
/// one another, cannot carry spin about it.
fn turn(inertia: &Matrix3<f64>, angular: Vector3<f64>) -> Vector3<f64> {
    let scale = inertia.trace();
    if scale <= 0.0 || !scale.is_finite() {
        return Vector3::zeros();
    }
    let eigen = (inertia / scale).symmetric_eigen();
    let mut omega = Vector3::zeros();
    for (value, axis) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > 1e-9 {
            omega += axis * (axis.dot(&angular) / (value * scale));
        }
    }
    omega
}

fn narrow(v: Vector3<f64>) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
