//! Access to a collider of a simulation: its pose and velocity, and the motion that drives it.

use nalgebra::{Rotation3, Vector3};

use super::contact_point::Touched;
use super::world::Simulation;
use crate::contact::Collider;
use crate::error::Error;
use crate::motion::{EulerPose, Switch};

impl Simulation {
    /// Returns a collider: its description, current pose and velocity.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a collider.
    pub fn collider(&self, index: usize) -> ColliderRef<'_> {
        ColliderRef::new(self, index)
    }

    /// Returns a collider to drive, enable or disable it: [`ColliderMut::move_to`], [`ColliderMut::set_enabled`].
    ///
    /// # Panics
    ///
    /// Panics if `index` is not the index of a collider.
    pub fn collider_mut(&mut self, index: usize) -> ColliderMut<'_> {
        ColliderMut::new(self, index)
    }
}

/// A collider of a simulation, with its current pose: see [`Simulation::collider`].
#[derive(Clone, Copy, Debug)]
pub struct ColliderRef<'a> {
    simulation: &'a Simulation,
    index: usize,
    /// Poses before and after the next step.
    poses: [EulerPose; 2],
    dt: f64,
}

impl<'a> ColliderRef<'a> {
    pub(super) fn new(simulation: &'a Simulation, index: usize) -> Self {
        let next_step = simulation.clock.interval();
        let poses = simulation.colliders.poses(index, next_step);
        Self { simulation, index, poses, dt: next_step.dt }
    }

    /// Returns the collider that was given. Its keyframes have no effect if the collider has been driven.
    pub fn description(&self) -> &'a Collider {
        self.simulation.colliders.description(self.index)
    }

    /// Returns whether the collider is enabled now, by [`Collider::enabled`].
    pub fn is_enabled(&self) -> bool {
        self.simulation.colliders.is_enabled(self.index as u32)
    }

    /// Returns the current displacement from the given position, in scene units.
    pub fn translation(&self) -> [f64; 3] {
        self.poses[0].translate
    }

    /// Returns the current rotation relative to the given orientation: Euler angles in degrees about the fixed
    /// axes x, then y, then z through the center.
    pub fn rotation(&self) -> [f64; 3] {
        self.poses[0].rotate
    }

    /// Returns the velocity of the center in the next step, in scene units per second. It is zero if the
    /// collider is at rest.
    pub fn velocity(&self) -> [f64; 3] {
        let [before, after] = self.poses.map(|pose| Vector3::from(pose.translate));
        ((after - before) / self.dt).into()
    }

    /// Returns the force of the bodies on the collider in the last step, in mass x length/s²: the opposite of the sum of
    /// the forces of its [contacts](Simulation::contacts).
    pub fn force(&self) -> [f64; 3] {
        let contacts = self.simulation.contacts().into_iter();
        let own = contacts.filter(|contact| contact.other == Touched::Collider(self.index));
        own.fold(Vector3::zeros(), |sum, contact| sum - contact.force).into()
    }

    /// Returns the angular velocity in the next step, in rad/s: the axis and angle, less than half a turn, of
    /// the rotation during the step, divided by `dt`.
    pub fn spin(&self) -> [f64; 3] {
        let [before, after] = self.poses.map(|pose| pose.pose().rotation);
        let turn = Rotation3::from_matrix_unchecked(after * before.transpose());
        if self.poses[0].rotate == self.poses[1].rotate {
            [0.0; 3]
        } else {
            (turn.scaled_axis() / self.dt).into()
        }
    }
}

/// A collider of a simulation that can be driven, enabled and disabled: see
/// [`Simulation::collider_mut`].
///
/// A driven collider moves linearly from its current pose to the target, and bodies in contact feel the
/// velocity and the spin of this motion. At the target it stays at rest until it is driven again. Driving
/// replaces the keyframes of the collider for good. A later call replaces a motion that has not ended: of
/// several calls before one step, the last one counts.
///
/// A target is relative to the given pose of the collider, as keyframes are: a displacement in scene units, and
/// Euler angles in degrees about the fixed axes x, then y, then z through the center. Each component may have a
/// magnitude of at most 1e15. The angles are interpolated, not the rotations: the motion from 350 to 10 degrees
/// turns back by 340 degrees, and the motion from 350 to 370 degrees forward by 20. In each step, contacts see
/// the displacement of a point during the step divided by `dt`. A turn of half a turn or more in one step
/// therefore acts like a smaller one.
///
/// The motion counts steps of `dt`, so [`Simulation::set_time`] does not change
/// it. It is part of [`SimulationState`](super::SimulationState).
#[derive(Debug)]
pub struct ColliderMut<'a> {
    simulation: &'a mut Simulation,
    index: usize,
}

impl<'a> ColliderMut<'a> {
    pub(super) fn new(simulation: &'a mut Simulation, index: usize) -> Self {
        assert!(index < simulation.colliders.len(), "collider {index} of {}", simulation.colliders.len());
        Self { simulation, index }
    }

    /// Moves the collider to a pose during the next step.
    ///
    /// # Errors
    ///
    /// A number out of range. The collider is then unchanged.
    pub fn move_to(&mut self, translate: [f64; 3], rotate: [f64; 3]) -> Result<(), Error> {
        self.drive(translate, rotate, None)
    }

    /// Moves the collider to a pose in `duration` seconds, > 0, from the next step on. If this is not a whole
    /// number of steps, the motion ends with the step in which the duration ends, and is slower in this step.
    /// Less than a step counts as one step.
    ///
    /// # Errors
    ///
    /// A number out of range. The collider is then unchanged.
    pub fn move_to_in(&mut self, translate: [f64; 3], rotate: [f64; 3], duration: f64) -> Result<(), Error> {
        self.drive(translate, rotate, Some(duration))
    }

    fn drive(&mut self, translate: [f64; 3], rotate: [f64; 3], duration: Option<f64>) -> Result<(), Error> {
        let target = EulerPose { translate, rotate };
        let Simulation { colliders, clock, .. } = &mut *self.simulation;
        Ok(colliders.drive(self.index, clock.time(), target, duration)?)
    }

    /// Enables or disables the collider from now on, `true` or `false`, or along keyframes: see [`Collider::enabled`]. It
    /// is a setting, as the friction is, and no part of a state: a restored state has the colliders that the time gives.
    pub fn set_enabled(&mut self, enabled: impl Into<Switch>) {
        self.simulation.colliders.set_enabled(self.index, enabled.into());
        self.simulation.switch_colliders();
    }
}
