//! The colliders of a Rapier world that soft bodies touch, as they were when they were last mapped.

use rapier3d::dynamics::{RigidBody, RigidBodyHandle, RigidBodySet};
use rapier3d::geometry::{Collider, ColliderHandle, ColliderSet, InteractionGroups, SharedShape};
use rapier3d::math::Pose;

use crate::error::Error;
use crate::shapes::Fault;

/// The motion of a collider, as soft bodies meet it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// It does not move.
    Fixed,
    /// It moves with its body, which soft bodies do not move.
    Kinematic,
    /// A part of a dynamic body, which soft bodies move.
    Dynamic,
}

impl Role {
    /// The name in messages.
    fn name(self) -> &'static str {
        match self {
            Self::Fixed | Self::Kinematic => "fixed or kinematic",
            Self::Dynamic => "dynamic",
        }
    }
}

/// A collider of Rapier, as it was mapped. The shape is shared, so that a shape that Rapier changes is another one.
pub(crate) struct Entry {
    pub(crate) collider: ColliderHandle,
    pub(crate) parent: Option<RigidBodyHandle>,
    pub(crate) role: Role,
    pub(crate) shape: SharedShape,
    /// Pose relative to the parent; of a fixed collider in the world.
    pub(crate) pose: Pose,
    pub(crate) friction: f32,
    pub(crate) restitution: f32,
}

/// A collider of Rapier that soft bodies touch.
#[derive(Clone, Copy)]
pub(crate) struct Found<'a> {
    handle: ColliderHandle,
    collider: &'a Collider,
    role: Role,
    pose: Pose,
}

/// Returns the colliders that soft bodies with the collision groups `groups` touch, in the order of Rapier. Sensors,
/// disabled colliders and colliders of disabled bodies are no obstacles.
pub(crate) fn found<'a>(
    bodies: &'a RigidBodySet,
    colliders: &'a ColliderSet,
    groups: InteractionGroups,
) -> impl Iterator<Item = Found<'a>> {
    colliders.iter().filter_map(move |(handle, collider)| {
        let takes_part = collider.is_enabled()
            && !collider.is_sensor()
            && collider.deformable_mesh_ref().is_none()
            && collider.collision_groups().test(groups);
        if !takes_part {
            return None;
        }
        let Some(parent) = collider.parent() else {
            return Some(Found { handle, collider, role: Role::Fixed, pose: *collider.position() });
        };
        let body = bodies.get(parent).filter(|body| body.is_enabled() && !body.is_soft_frame())?;
        let local = collider.position_wrt_parent().copied().unwrap_or(Pose::IDENTITY);
        let role = role(body);
        let pose = if role == Role::Fixed { *body.position() * local } else { local };
        Some(Found { handle, collider, role, pose })
    })
}

/// Returns the role of the colliders of a body. A dynamic body without a mass moves by its velocity alone.
fn role(body: &RigidBody) -> Role {
    match () {
        _ if body.is_fixed() => Role::Fixed,
        _ if body.is_dynamic() && body.mass() > 0.0 => Role::Dynamic,
        _ => Role::Kinematic,
    }
}

impl Found<'_> {
    /// Returns whether the collider is as it was when it was mapped.
    pub(crate) fn is_like(&self, entry: &Entry) -> bool {
        self.entry().is_same(entry)
    }

    pub(crate) fn entry(&self) -> Entry {
        Entry {
            collider: self.handle,
            parent: self.collider.parent(),
            role: self.role,
            shape: self.collider.shared_shape().clone(),
            pose: self.pose,
            friction: self.collider.friction(),
            restitution: self.collider.restitution(),
        }
    }
}

impl Entry {
    /// Returns whether the collider is one of a fixed or kinematic body.
    pub(crate) fn is_obstacle(&self) -> bool {
        self.role != Role::Dynamic
    }

    /// Returns whether two colliders are the same one without a change.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.collider == other.collider
            && self.parent == other.parent
            && self.role == other.role
            && std::sync::Arc::ptr_eq(&self.shape.0, &other.shape.0)
            && self.pose == other.pose
            && self.friction == other.friction
            && self.restitution == other.restitution
    }

    /// Returns the error of a shape that cannot be mapped.
    pub(crate) fn error(&self, fault: Fault) -> Error {
        match fault {
            Fault::Unsupported(shape) => {
                Error::Shape { collider: self.collider, role: self.role.name(), shape }
            }
            Fault::Mesh(source) => Error::Mesh { collider: self.collider, source },
        }
    }
}
