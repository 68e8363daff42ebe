//! The mass and the motion of a rigid body, as users set and read them.

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::parts::Shape;
use super::soft_body::{Body, MAX_CELLS};
use crate::dynamics::{RigidError, RigidMass};
use crate::error::Error;
use crate::range::{Range, in_range};
use crate::state::{Placement, Twist};

/// Mass, center of mass and inertia of a rigid body, in place of those of its mesh: see
/// [`BodyBuilder::mass_properties`](crate::BodyBuilder::mass_properties). Another density, set later, changes them in
/// proportion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Mass in kilograms, > 0.
    pub mass: f64,
    /// Center of mass in the model's frame: after `scale`, before `rotate` and `translate`.
    pub center: [f64; 3],
    /// Inertia tensor about the center of mass along the axes of the model's frame, in kg x length^2: symmetric, with
    /// no negative principal moment. The body does not turn about a principal axis with the moment 0.
    pub inertia: Matrix3<f64>,
}

impl MassProperties {
    /// Checks the numbers.
    pub(super) fn validate(&self) -> Result<(), Error> {
        let Self { mass, center, inertia } = self;
        Range::POSITIVE.check("mass", *mass)?;
        for value in center {
            in_range("center of mass", *value, true, "finite")?;
        }
        for value in inertia {
            in_range("inertia", *value, true, "finite")?;
        }
        let (size, asymmetry) = (inertia.norm(), (inertia - inertia.transpose()).norm());
        in_range(
            "asymmetry of the inertia",
            asymmetry,
            asymmetry <= 1e-6 * size,
            "0: the tensor is symmetric",
        )?;
        let least = inertia.symmetric_eigenvalues().min();
        in_range("least principal moment of inertia", least, least >= -1e-6 * size, "0 and above")?;
        Ok(())
    }
}

impl Body {
    /// Sets the motion of a rigid body that another program moves, before a step: its pose from the model's frame to
    /// world space, as [`Body::pose`], the velocity of its center of mass, and its angular velocity in rad/s.
    ///
    /// Contacts keep what they know of the last step, so that the pose should be near the one before. Call it before
    /// each step in which the body may touch another one: it wakes the body up. The step adds gravity and the impulses
    /// of the contacts: see [`Body::linear_momentum`] and [`Body::angular_momentum`].
    ///
    /// # Errors
    ///
    /// A soft body, or a number that is not finite or exceeds 10^15 cells. The body is then unchanged.
    pub fn set_rigid_motion(
        &mut self,
        pose: &Isometry3<f64>,
        velocity: Vector3<f64>,
        spin: Vector3<f64>,
    ) -> Result<(), Error> {
        let Some(rigid) = self.rigid.as_deref() else {
            return Err(RigidError::NotRigid { change: "a rigid motion" }.into());
        };
        let (rotation, cell_size) = (pose.rotation, self.shape.lattice.cell_size());
        for value in rotation.coords.iter().chain(spin.iter()) {
            in_range("rotation", *value, true, "finite")?;
        }
        let translate = pose.translation.vector.into();
        let placement = Placement { translate, velocity: velocity.into(), ..Placement::default() };
        placement.validate()?;
        placement.check_limit(MAX_CELLS * cell_size)?;
        let rest_center = self.shape.lattice.origin() + rigid.rest_center() * cell_size;
        let center = self.state.frame.to_local(pose * rest_center);
        self.change_pose(|rigid, pose| {
            pose.set_center(center);
            pose.set_rotation(rotation);
            rigid.set_motion(pose, Twist { linear: velocity / cell_size, angular: spin });
        });
        self.measure_contact_bounds();
        self.wake();
        Ok(())
    }

    /// Returns the angular velocity of a rigid body in rad/s; `None` of a soft body.
    pub fn spin(&self) -> Option<Vector3<f64>> {
        Some(self.rigid.as_deref()?.angular_velocity(self.state.rigid.as_ref()?))
    }

    /// Returns the mass of a new rigid body: the given one, or that of its mesh or lattice.
    pub(super) fn rigid_mass(&self, properties: Option<&MassProperties>) -> RigidMass {
        let Shape { lattice, masses, .. } = &self.shape;
        let Some(MassProperties { mass, center, inertia }) = properties else {
            return RigidMass::new(lattice, self.mesh(), masses);
        };
        let (cell_mass, cell_size) = (self.cell_mass(), lattice.cell_size());
        RigidMass {
            mass: mass / cell_mass,
            center: (Vector3::from(*center) - lattice.origin().coords) / cell_size,
            inertia: inertia / (cell_mass * cell_size * cell_size),
        }
    }
}
