//! A dynamic body of Rapier, as a rigid body among the soft ones.
//!
//! In a step of the length h, the rigid body begins with the pose and the velocity v of the Rapier body, and with the
//! change d of the velocity that Rapier will make by gravity, the forces of the user, joints and contacts. The contacts
//! with soft bodies give it an impulse J, which the Rapier body then has in its own step. With v + d + J/m the contact
//! solver has the velocity at the end of the step of both programs, so that a body at rest stays at rest.
//!
//! * The change r by joints and contacts in a step is taken to be that of the last step. An impact lasts one step only:
//!   of the changes of the last two steps, only the part that they have in common counts ([`common`]).
//! * Rapier divides its step into parts, in which forces act in equal shares and an impulse acts at once. The part of J
//!   that is opposite to d acts as a force, so that both cancel in each part; the rest acts as an impulse.
//! * A body that nothing holds is also moved out of soft bodies, as they are moved out of it.
//! * Rapier computes in f32. The rounding error of an impulse is added to the impulse of the next step.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use rapier3d::dynamics::{LockedAxes, RigidBody, RigidBodyHandle};
use rapier3d::math::Vector;
use rapier3d::parry::mass_properties::MassProperties as RapierMass;
use supple::{Body, MassProperties, TouchingOptions};

use crate::convert::{Mass, Twist, narrow, wide, wide_pose};
use crate::entries::Entry;
use crate::error::Error;
use crate::shapes::Surface;

/// Impulse below which nothing touched a body, relative to its momentum: above the rounding errors of f64.
const LEAST_IMPULSE: f64 = 1e-12;

/// Push below which a body is not moved, relative to its radius: the rounding errors of Rapier's positions.
const LEAST_PUSH: f64 = 1e-7;

/// Change of the velocity by joints and contacts, relative to the velocity, below which nothing held a body: above the
/// rounding errors of Rapier's velocities.
const LEAST_CHANGE: f64 = 1e-5;

/// The place of the rigid body: in the simulation, or beside it.
pub(crate) enum Place {
    /// No soft body is near. The rigid body exists if one has been near before.
    Away(Option<Box<Body>>),
    /// In the simulation, with this index.
    Near(usize),
}

/// A dynamic body of Rapier.
pub(crate) struct CoupledBody {
    pub(crate) handle: RigidBodyHandle,
    pub(crate) place: Place,
    /// The mass as Rapier has it, and the locked axes, when the body was mapped.
    properties: (RapierMass, LockedAxes),
    mass: Mass,
    /// Radius of a ball about the origin of the body with all of its colliders.
    radius: f64,
    /// Impulse and angular impulse of the last step, about the center of mass.
    pub(crate) impulse: Twist,
    /// Changes of the velocities by joints and contacts of Rapier in the last two steps.
    others: [Twist; 2],
    /// Rounding error of the impulses so far.
    rest: Twist,
    step: Step,
}

/// The data of a step.
#[derive(Default)]
struct Step {
    /// Velocities before the step of the soft bodies.
    velocity: Twist,
    /// Changes of the velocities by gravity and by the forces of the user.
    known: Twist,
    /// Changes of the velocities that the step of the soft bodies assumed.
    assumed: Twist,
    /// Inertia tensor in world space.
    inertia: Matrix3<f64>,
    /// Momenta with which the step of the soft bodies began.
    before: Twist,
    /// Velocities at the beginning of Rapier's step.
    begin: Twist,
    /// Changes of the velocities by the part of the impulse that acts as a force.
    forced: Twist,
    /// The force and torque of the user, if Rapier's body has others during its step.
    user: Option<(Vector, Vector)>,
}

impl CoupledBody {
    /// Creates a coupled body that is away. An unsupported shape is an error although its surface is not used yet.
    pub(crate) fn new<'a>(
        handle: RigidBodyHandle,
        body: &RigidBody,
        entries: impl Iterator<Item = &'a Entry>,
    ) -> Result<Self, Error> {
        let mut radius = 0.0_f64;
        for entry in entries {
            Surface::default()
                .append(&*entry.shape.0, &Isometry3::identity())
                .map_err(|fault| entry.error(fault))?;
            let ball = entry.shape.compute_bounding_sphere(&entry.pose);
            radius = radius.max(f64::from(ball.center.length() + ball.radius));
        }
        Ok(Self {
            handle,
            place: Place::Away(None),
            properties: (body.mass_properties().local_mprops, body.locked_axes()),
            mass: Mass::new(&body.mass_properties().local_mprops),
            radius,
            impulse: Twist::default(),
            others: [Twist::default(); 2],
            rest: Twist::default(),
            step: Step::default(),
        })
    }

    /// Returns a ball with the body during a step of `dt` seconds.
    pub(crate) fn ball(&self, body: &RigidBody, dt: f64) -> (Vector3<f64>, f64) {
        (wide(body.translation()), self.radius + wide(body.linvel()).norm() * dt)
    }

    /// Creates the rigid body, in the pose of the Rapier body.
    pub(crate) fn create<'a>(
        &self,
        body: &RigidBody,
        entries: impl Iterator<Item = &'a Entry>,
    ) -> Result<Body, Error> {
        let mut surface = Surface::default();
        let mut first = None;
        for entry in entries {
            surface.append(&*entry.shape.0, &wide_pose(&entry.pose)).map_err(|fault| entry.error(fault))?;
            first = first.or(Some(entry));
        }
        let failed = |source: supple::Error| Error::Body { body: self.handle, source: Box::new(source) };
        let mesh = surface.mesh().map_err(|error| failed(error.into()))?;
        let inertia = match body.locked_axes().contains(LockedAxes::ROTATION_LOCKED) {
            true => Matrix3::zeros(),
            false => self.mass.inertia,
        };
        let Mass { mass, center, .. } = self.mass;
        let mut touching =
            TouchingOptions { soft_only: true, rolling_resistance: Some(0.0), ..TouchingOptions::default() };
        if let Some(entry) = first {
            touching.friction = entry.friction.into();
            touching.restitution = f64::from(entry.restitution).clamp(0.0, 1.0);
        }
        let builder = Body::builder(mesh).rigid(true).touching(touching);
        let builder = builder.name(format!("Rapier body {}", self.handle.into_raw_parts().0));
        let builder = builder.mass_properties(MassProperties { mass, center: center.into(), inertia });
        builder.build().map_err(failed)
    }

    /// Gives the rigid body the pose and the velocities of the Rapier body before a step of `dt` seconds. The step of
    /// the simulation adds `gravity`.
    pub(crate) fn begin(
        &mut self,
        body: &RigidBody,
        soft: &mut Body,
        (gravity, dt): (Vector3<f64>, f64),
    ) -> Result<(), Error> {
        let pose = wide_pose(body.position());
        let inertia = self.mass.inertia_at(&pose.rotation);
        let known = self.known_change(body, &inertia, (gravity, dt));
        if body.is_sleeping() {
            // Something holds a body that sleeps.
            self.others = [Twist::default() - known; 2];
        }
        let [last, before] = self.others;
        let others = Twist {
            linear: common(last.linear, before.linear),
            angular: common(last.angular, before.angular),
        };
        let assumed = known + others;
        let velocity = Twist { linear: wide(body.linvel()), angular: wide(body.angvel()) };
        let begin = velocity + assumed;
        soft.set_rigid_motion(&pose, begin.linear - gravity * dt, begin.angular)?;
        let before = Twist { linear: begin.linear * soft.mass(), angular: soft.angular_momentum() };
        self.step = Step { velocity, known, assumed, inertia, before, ..Step::default() };
        Ok(())
    }

    /// Returns the change of the velocities in a step of `dt` seconds by gravity and by the forces of the user.
    fn known_change(
        &self,
        body: &RigidBody,
        inertia: &Matrix3<f64>,
        (gravity, dt): (Vector3<f64>, f64),
    ) -> Twist {
        let linear = gravity * f64::from(body.gravity_scale()) + wide(body.user_force()) / self.mass.mass;
        let linear = without_locked(linear, body.locked_axes());
        let angular = inertia.try_inverse().unwrap_or_default() * wide(body.user_torque());
        Twist { linear: linear * dt, angular: angular * dt }
    }

    /// Gives the Rapier body the impulses of a step of `dt` seconds. All of the impulse of a link of a multibody acts
    /// as a force, because the velocities of links follow from those of the joints.
    pub(crate) fn apply(&mut self, body: &mut RigidBody, soft: &Body, (is_link, dt): (bool, f64)) {
        let Step { before, assumed, inertia, velocity, .. } = self.step;
        let mass = self.mass.mass;
        let change = Twist { linear: soft.linear_momentum(), angular: soft.angular_momentum() } - before;
        let scale = mass * (velocity.linear.norm() + assumed.linear.norm());
        let angular_scale = (inertia * velocity.angular).norm() + (inertia * assumed.angular).norm();
        let is_touched = change.linear.norm() > LEAST_IMPULSE * scale
            || change.angular.norm() > LEAST_IMPULSE * angular_scale;
        let is_touched = is_touched && change.fits(dt);
        self.impulse = if is_touched { change } else { Twist::default() };
        self.step.begin = velocity;
        if !is_touched {
            return;
        }
        let forced = match is_link {
            true => change,
            false => Twist {
                linear: opposite(change.linear, assumed.linear * mass),
                angular: opposite(change.angular, inertia * assumed.angular),
            },
        };
        let wanted = change - forced + self.rest;
        body.apply_impulse(narrow(wanted.linear), true);
        body.apply_torque_impulse(narrow(wanted.angular), true);
        let begin = Twist { linear: wide(body.linvel()), angular: wide(body.angvel()) };
        let given = begin - velocity;
        let given = Twist { linear: given.linear * mass, angular: inertia * given.angular };
        let locked = body.locked_axes();
        self.rest = wanted - given;
        if is_link || locked.intersects(LockedAxes::TRANSLATION_LOCKED) {
            self.rest.linear = Vector3::zeros();
        }
        if is_link || locked.intersects(LockedAxes::ROTATION_LOCKED) || inertia.try_inverse().is_none() {
            self.rest.angular = Vector3::zeros();
        }
        if forced != Twist::default() {
            self.step.user = Some((body.user_force(), body.user_torque()));
            body.add_force(narrow(forced.linear / dt), true);
            body.add_torque(narrow(forced.angular / dt), true);
        }
        if !is_link {
            self.push(body, soft, dt);
        }
        let inverse = inertia.try_inverse().unwrap_or_default();
        self.step.forced = Twist { linear: forced.linear / mass, angular: inverse * forced.angular };
        self.step.begin = begin;
    }

    /// Moves the Rapier body by the push out of soft bodies: the displacement of the center of mass beside that by
    /// the velocity, without the locked axes. The angular momenta of the soft bodies count on it. A body that
    /// joints or contacts of Rapier held in the last step stays where it is, because they would push it back.
    fn push(&self, body: &mut RigidBody, soft: &Body, dt: f64) {
        let Step { velocity, known, .. } = &self.step;
        if self.others[0].linear.norm() > LEAST_CHANGE * (velocity.linear.norm() + known.linear.norm()) {
            return;
        }
        let pose = wide_pose(body.position());
        let begin = pose * Point3::from(self.mass.center);
        let push = soft.center_of_mass() - begin - soft.linear_momentum() * (dt / soft.mass());
        let push = without_locked(push, body.locked_axes());
        if push.norm() > LEAST_PUSH * self.radius && narrow(push).is_finite() {
            body.set_translation(narrow(pose.translation.vector + push), true);
        }
    }

    /// Takes the forces back after Rapier's step, and reads the changes of the velocities by Rapier's joints and
    /// contacts.
    pub(crate) fn end(&mut self, body: &mut RigidBody) {
        self.restore_forces(body);
        let Step { begin, known, forced, .. } = &self.step;
        let end = Twist { linear: wide(body.linvel()), angular: wide(body.angvel()) };
        self.others = [end - *begin - *known - *forced, self.others[0]];
    }

    /// Returns whether the Rapier body has forces of the step beside those of the user.
    pub(crate) fn has_forces(&self) -> bool {
        self.step.user.is_some()
    }

    /// Gives the Rapier body the forces of the user alone.
    pub(crate) fn restore_forces(&mut self, body: &mut RigidBody) {
        if let Some((force, torque)) = self.step.user.take() {
            body.reset_forces(false);
            body.reset_torques(false);
            body.add_force(force, false);
            body.add_torque(torque, false);
        }
    }

    /// Forgets the last steps: no soft body is near.
    pub(crate) fn leave(&mut self) {
        (self.others, self.impulse, self.rest) = Default::default();
    }

    /// Returns whether the mass and the locked axes of the body are as they were when it was mapped.
    pub(crate) fn is_like(&self, body: &RigidBody) -> bool {
        self.properties == (body.mass_properties().local_mprops, body.locked_axes())
    }
}

/// Returns a displacement or a change of a velocity with zero along the locked axes.
fn without_locked(mut vector: Vector3<f64>, locked: LockedAxes) -> Vector3<f64> {
    let axes = [
        LockedAxes::TRANSLATION_LOCKED_X,
        LockedAxes::TRANSLATION_LOCKED_Y,
        LockedAxes::TRANSLATION_LOCKED_Z,
    ];
    for (axis, flag) in axes.into_iter().enumerate() {
        if locked.contains(flag) {
            vector[axis] = 0.0;
        }
    }
    vector
}

/// Returns the part of `last` that `before` has as well: the component of `before` along `last`, from 0 to all of
/// `last`.
fn common(last: Vector3<f64>, before: Vector3<f64>) -> Vector3<f64> {
    let squared = last.norm_squared();
    if squared == 0.0 { last } else { last * (last.dot(&before) / squared).clamp(0.0, 1.0) }
}

/// Returns the part of an impulse that cancels at most all of `assumed`.
fn opposite(impulse: Vector3<f64>, assumed: Vector3<f64>) -> Vector3<f64> {
    let squared = assumed.norm_squared();
    if squared == 0.0 { assumed } else { assumed * (impulse.dot(&assumed) / squared).clamp(-1.0, 0.0) }
}
