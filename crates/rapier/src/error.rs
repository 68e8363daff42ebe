//! Errors of the bridge.

use rapier3d::dynamics::RigidBodyHandle;
use rapier3d::geometry::ColliderHandle;

/// An error of the bridge.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A collider with a shape that soft bodies cannot touch.
    #[error(
        "collider {} of Rapier, of a {role} body, has the shape {shape}, which soft bodies cannot touch; use a ball, \
         cuboid, capsule, cylinder, cone, convex polyhedron, triangle mesh, height field or a compound of them (half \
         spaces: of fixed and kinematic bodies), or exclude the collider by its collision groups",
        .collider.into_raw_parts().0
    )]
    Shape {
        /// The collider.
        collider: ColliderHandle,
        /// `dynamic`, or `fixed or kinematic`.
        role: &'static str,
        /// Name of the shape.
        shape: String,
    },
    /// An error of the soft bodies, for example a collider with a number out of its range.
    #[error(transparent)]
    Soft(#[from] supple::Error),
    /// A collider whose surface supple does not take, for example because no triangle has an area.
    #[error("collider {} of Rapier: {source}", .collider.into_raw_parts().0)]
    Mesh {
        /// The collider.
        collider: ColliderHandle,
        /// The reason.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A dynamic body that supple does not take, for example because the friction of its first collider is below 0.
    #[error(
        "body {} of Rapier, with the friction and the restitution of its first collider: {source}",
        .body.into_raw_parts().0
    )]
    Body {
        /// The body.
        body: RigidBodyHandle,
        /// The reason.
        source: Box<supple::Error>,
    },
}
