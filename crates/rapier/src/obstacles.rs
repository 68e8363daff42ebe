//! Fixed and kinematic colliders of Rapier, as colliders of the soft bodies.

use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d::dynamics::{RigidBody, RigidBodyHandle, RigidBodySet};
use supple::{Collider, Key, Simulation, euler_degrees_near};

use crate::convert::{wide, wide_pose};
use crate::entries::{Entry, Role};
use crate::error::Error;
use crate::shapes::append_shapes;

/// Distance from the target at which a body has jumped, relative to its distance from the origin of the world: above
/// the rounding errors of Rapier's positions.
const LEAST_JUMP: f64 = 1e-5;

/// Angle to the target at which a body has jumped, in rad: above the rounding errors of Rapier's rotations.
const LEAST_TURN: f64 = 1e-4;

/// Part of the motion of a step by which a body can miss its target without a jump: Rapier's integration of a turn
/// differs from the prediction in the second order.
const MISSED: f64 = 0.5;

/// The colliders of the soft bodies.
pub(crate) struct Obstacles {
    /// Number of the colliders of the simulation that are none of Rapier. They come first.
    own: usize,
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
    /// Pose of the body at the beginning of the last step.
    before: Isometry3<f64>,
    /// The last target.
    target: Isometry3<f64>,
}

impl Obstacles {
    pub(crate) fn new(simulation: &Simulation) -> Self {
        Self { own: simulation.collider_count(), moving: Vec::new() }
    }

    /// Maps the colliders of fixed and kinematic bodies anew. Those of the simulation itself keep their settings and
    /// poses.
    pub(crate) fn map(
        &mut self,
        entries: &[Entry],
        bodies: &RigidBodySet,
        simulation: &mut Simulation,
    ) -> Result<(), Error> {
        let own = |index| simulation.collider(index);
        let mut colliders: Vec<Collider> =
            (0..self.own).map(|index| own(index).description().clone()).collect();
        let poses: Vec<_> =
            (0..self.own).map(|index| (own(index).translation(), own(index).rotation())).collect();
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
                    moving.push(Moving {
                        index,
                        body,
                        start,
                        angles: [0.0; 3],
                        before: start,
                        target: start,
                    });
                }
                colliders.push(Collider {
                    friction: entry.friction.into(),
                    restitution: f64::from(entry.restitution).clamp(0.0, 1.0),
                    ..Collider::new(shape)
                });
            }
        }
        simulation.set_colliders(&colliders)?;
        // A driven collider is now where its keyframes place it.
        let mut is_any_driven = false;
        for (index, &(translate, rotate)) in poses.iter().enumerate() {
            let now = simulation.collider(index);
            if (now.translation(), now.rotation()) != (translate, rotate) {
                colliders[index].keys = vec![Key { time: 0.0, translate, rotate }];
                is_any_driven = true;
            }
        }
        if is_any_driven {
            simulation.set_colliders(&colliders)?;
        }
        self.moving = moving;
        Ok(())
    }

    /// Returns whether a kinematic body is at another place than its motion in the last step ended at.
    pub(crate) fn any_jumped(&self, bodies: &RigidBodySet) -> bool {
        let jumped = |moving: &Moving| bodies.get(moving.body).is_some_and(|body| moving.has_jumped(body));
        self.moving.iter().any(jumped)
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
            moving.before = wide_pose(body.position());
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

impl Moving {
    /// Returns whether the body is farther from the last target than Rapier's arithmetic explains.
    fn has_jumped(&self, body: &RigidBody) -> bool {
        let now = wide_pose(body.position());
        let distances = |a: &Isometry3<f64>, b: &Isometry3<f64>| {
            ((a.translation.vector - b.translation.vector).norm(), a.rotation.angle_to(&b.rotation))
        };
        let (missed, turned) = distances(&now, &self.target);
        let (distance, angle) = distances(&self.before, &self.target);
        let norms = [now, self.before, self.target].map(|pose| pose.translation.vector.norm());
        let arm: Vector3<f64> = wide(body.center_of_mass()) - now.translation.vector;
        let size = norms.into_iter().fold(arm.norm(), f64::max);
        missed > LEAST_JUMP * size + MISSED * distance || turned > LEAST_TURN + MISSED * angle
    }
}

/// Returns the pose of a body that nothing can stop at the end of a step.
fn next_position(body: &RigidBody, dt: f32) -> rapier3d::math::Pose {
    match body.body_type() {
        rapier3d::dynamics::RigidBodyType::KinematicPositionBased => *body.next_position(),
        _ => body.predict_position_using_velocity(dt),
    }
}
