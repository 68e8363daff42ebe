//! Fixed and kinematic colliders of Rapier, as colliders of the soft bodies.

use nalgebra::{Isometry3, Point3};
use rapier3d::dynamics::{RigidBody, RigidBodyHandle, RigidBodySet};
use supple::{Collider, Simulation, euler_degrees_near};

use crate::convert::wide_pose;
use crate::entries::{Entry, Role};
use crate::error::Error;
use crate::shapes::append_shapes;

/// The colliders of the soft bodies.
#[derive(Default)]
pub(crate) struct Obstacles {
    /// Colliders of the simulation that are none of Rapier. They come first.
    own: Vec<Collider>,
    moving: Vec<Moving>,
}

/// A collider that moves with a kinematic body.
struct Moving {
    /// Index in the simulation.
    index: usize,
    body: RigidBodyHandle,
    /// Pose of the body with which the collider was mapped.
    start: Isometry3<f64>,
    /// Euler angles of the last target, in degrees.
    angles: [f64; 3],
    /// The last target.
    target: Isometry3<f64>,
}

impl Obstacles {
    pub(crate) fn new(simulation: &Simulation) -> Self {
        let own =
            (0..simulation.collider_count()).map(|index| simulation.collider(index).description().clone());
        Self { own: own.collect(), moving: Vec::new() }
    }

    /// Maps the colliders of fixed and kinematic bodies anew.
    pub(crate) fn map(
        &mut self,
        entries: &[Entry],
        bodies: &RigidBodySet,
        simulation: &mut Simulation,
    ) -> Result<(), Error> {
        let mut colliders = self.own.clone();
        let mut moving = Vec::new();
        let mut shapes = Vec::new();
        for entry in entries.iter().filter(|entry| entry.is_obstacle()) {
            let parent = entry.parent.and_then(|handle| Some((handle, bodies.get(handle)?)));
            let kinematic = parent.filter(|_| entry.role == Role::Kinematic);
            let start = kinematic.map_or_else(Isometry3::identity, |(_, body)| wide_pose(body.position()));
            append_shapes(&*entry.shape.0, &(start * wide_pose(&entry.pose)), &mut shapes)
                .map_err(|fault| entry.error(fault))?;
            for shape in shapes.drain(..) {
                if let Some((body, _)) = kinematic {
                    let index = colliders.len();
                    moving.push(Moving { index, body, start, angles: [0.0; 3], target: start });
                }
                colliders.push(Collider {
                    friction: entry.friction.into(),
                    restitution: f64::from(entry.restitution).clamp(0.0, 1.0),
                    ..Collider::new(shape)
                });
            }
        }
        simulation.set_colliders(&colliders)?;
        self.moving = moving;
        Ok(())
    }

    /// Lets the colliders of kinematic bodies move in the next step of `dt` seconds as their bodies will.
    pub(crate) fn drive(
        &mut self,
        bodies: &RigidBodySet,
        simulation: &mut Simulation,
        dt: f32,
    ) -> Result<(), Error> {
        for moving in &mut self.moving {
            let Some(body) = bodies.get(moving.body) else { continue };
            let target = wide_pose(&next_position(body, dt));
            if target == moving.target {
                continue;
            }
            let motion = target * moving.start.inverse();
            let center = simulation.collider(moving.index).description().shape.center();
            let angles = euler_degrees_near(motion.rotation.to_rotation_matrix().matrix(), moving.angles);
            let translate = motion * center - Point3::from(center.coords);
            simulation.collider_mut(moving.index).move_to(translate.into(), angles)?;
            (moving.target, moving.angles) = (target, angles);
        }
        Ok(())
    }
}

/// Returns the pose of a body that nothing can stop at the end of a step.
fn next_position(body: &RigidBody, dt: f32) -> rapier3d::math::Pose {
    match body.body_type() {
        rapier3d::dynamics::RigidBodyType::KinematicPositionBased => *body.next_position(),
        _ => body.predict_position_using_velocity(dt),
    }
}
