//! Physical quantities of a body: mass, momenta and energies, in f64 and scene units.
//!
//! The time integration is a leapfrog scheme: positions are those at the end of a step, and velocities the mean
//! velocities of the step, half a step earlier. So the sum of kinetic and potential energy of an undamped body
//! oscillates by the fraction h ω/2, with the step length h and the greatest angular frequency ω of the motion.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};

use super::parts::Pipeline;
use super::reference::BodyRef;
use super::soft_body::Body;
use crate::matching::{Purpose, rotations};

impl Body {
    /// Returns the mass: the sum of [`Body::masses`], or of a rigid body that of its mesh.
    pub fn mass(&self) -> f64 {
        if let Some(rigid) = &self.rigid {
            return rigid.mass() * self.cell_mass();
        }
        self.masses().iter().sum()
    }

    /// Returns the center of mass in world space.
    pub fn center_of_mass(&self) -> Point3<f64> {
        if let Some(pose) = &self.state.rigid {
            return self.state.frame.to_world(pose.center());
        }
        let origin = self.state.frame.to_world(Vector3::zeros());
        // Sums relative to the origin of the body keep the accuracy far from the world origin.
        let moment = self.sum(|mass, position, _| (position - origin) * mass);
        origin + moment / self.mass()
    }

    /// Returns the linear momentum Σ m v, in kg x length / s.
    pub fn linear_momentum(&self) -> Vector3<f64> {
        if let Some(pose) = &self.state.rigid {
            return pose.velocity() * (self.mass() * self.shape.lattice.cell_size());
        }
        self.sum(|mass, _, velocity| velocity * mass)
    }

    /// Returns the angular momentum about the center of mass, Σ m (x - x̄) × v, in kg x length^2 / s.
    pub fn angular_momentum(&self) -> Vector3<f64> {
        if let Some(pose) = &self.state.rigid {
            return pose.angular_momentum() * (self.impulse_unit() * self.shape.lattice.cell_size());
        }
        let (center, mean) = (self.center_of_mass(), self.linear_momentum() / self.mass());
        // Without the mean velocity, whose part is zero, the cross products are small.
        self.sum(|mass, position, velocity| (position - center).cross(&(velocity - mean)) * mass)
    }

    /// Returns the rigid motion that fits the body best, from the model's frame (after `scale`, before `rotate` and
    /// `translate`) to world space: the rotation R of Σ m (x - x̄)(x⁰ - x̄⁰)ᵀ over the lattice vertices, and the
    /// translation that moves the center of mass of the rest shape to that of the body. At frame 0 it is the placement. Of
    /// a rigid body it is its motion.
    pub fn pose(&self) -> Isometry3<f64> {
        if let (Some(rigid), Some(pose)) = (&self.rigid, self.state.rigid) {
            let rotation = pose.rotation();
            let rest_center = self.lattice().origin() + rigid.rest_center() * self.lattice().cell_size();
            let center = self.state.frame.to_world(pose.center());
            return Isometry3::from_parts(Translation3::from(center - rotation * rest_center), rotation);
        }
        let (center, origin) = (self.center_of_mass(), self.lattice().rest_position(0));
        let rest = |vertex: u32| self.lattice().rest_position(vertex);
        let vertices = || 0..self.lattice().len() as u32;
        let moment =
            vertices().map(|vertex| (rest(vertex) - origin) * self.mass_of(vertex)).sum::<Vector3<f64>>();
        let rest_center = origin + moment / self.mass();
        let covariance = vertices().map(|vertex| {
            (self.vertex_motion(vertex).0 - center)
                * (rest(vertex) - rest_center).transpose()
                * self.mass_of(vertex)
        });
        // In units of the mass and the size, so that f32 holds it.
        let covariance: Matrix3<f64> = covariance.sum::<Matrix3<f64>>() / (self.mass() * self.size().powi(2));
        let rotation = rotations(&[covariance])[0];
        let rotation = UnitQuaternion::from_matrix(&rotation);
        Isometry3::from_parts(Translation3::from(center - rotation * rest_center), rotation)
    }

    /// Returns the kinetic energy Σ m |v|²/2, in kg x length^2 / s^2.
    pub fn kinetic_energy(&self) -> f64 {
        if let (Some(rigid), Some(pose)) = (&self.rigid, &self.state.rigid) {
            return rigid.kinetic_energy(pose) * self.impulse_unit() * self.shape.lattice.cell_size();
        }
        self.sum(|mass, _, velocity| Vector3::new(velocity.norm_squared() * mass / 2.0, 0.0, 0.0)).x
    }

    /// Sums a quantity over the vertices, of their mass, position and velocity.
    fn sum(&self, quantity: impl Fn(f64, Point3<f64>, Vector3<f64>) -> Vector3<f64>) -> Vector3<f64> {
        let quantities = (0..self.lattice().len() as u32).map(|vertex| {
            let (position, velocity) = self.vertex_motion(vertex);
            quantity(self.mass_of(vertex), position, velocity)
        });
        quantities.sum()
    }
}

impl BodyRef<'_> {
    /// Returns the elastic energy, in kg x length^2 / s^2, or `None` outside a simulation.
    ///
    /// It is the potential of the accelerations towards the goal positions: alpha/(2 dt²) Σ s Σ m/n |R y + c - x|²,
    /// over the regions, with their stiffness factors s, and the vertices of each region. R y + c is the position to
    /// which the rigid motion of the region moves a vertex. In a region with a plastic shape S, it is R S y + c.
    /// Vertices that a pin or handle holds count with the mass that they have in the fits of the regions.
    pub fn elastic_energy(self) -> Option<f64> {
        let context = self.context()?;
        let body = self.get();
        if body.is_rigid() {
            return Some(0.0);
        }
        let Body { pipeline: Pipeline { matching, .. }, state, .. } = body;
        let (_, rotations) = body.fit_now(context.executor, Purpose::Regions);
        let misfit = matching.regions.misfit(
            &matching.layout,
            |slot| state.local(slot),
            |slot| rotations.get(slot),
            state.strains.as_ref(),
        );
        let rate = body.lattice().cell_size() / context.dt;
        // A body at rest may be below zero by rounding errors.
        Some((0.5 * body.alpha(context.dt) * rate * rate * body.cell_mass() * misfit).max(0.0))
    }

    /// Returns the energy in the gravity field, -m g·x̄ with the center of mass x̄, in kg x length^2 / s^2, or `None`
    /// outside a simulation. It is zero if the center of mass is the world origin.
    pub fn gravity_energy(self) -> Option<f64> {
        let gravity = self.context()?.gravity;
        Some(-self.mass() * gravity.dot(&self.center_of_mass().coords))
    }
}
