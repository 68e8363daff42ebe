//! The motion of a rigid body, in place of damping, shape matching and integration.

use super::stage::{BodyStep, Stage, check_owner};
use crate::body::snapshot::BodySnapshot;
use crate::body::soft_body::Body;
use crate::dynamics::RigidBody;
use crate::error::StateError;

/// Advances the pose of a rigid body, and writes its lattice vertices.
pub(super) struct MoveRigidly;

impl Stage for MoveRigidly {
    fn name(&self) -> &'static str {
        "rigid motion"
    }

    fn is_main(&self) -> bool {
        false
    }

    fn exists(&self, body: &Body) -> bool {
        body.is_rigid()
    }

    fn run(&self, body: &mut Body, step: &BodyStep<'_>) {
        body.move_rigidly(step.context);
    }

    fn describe(&self, body: &Body) -> (String, usize) {
        let bytes = body.rigid.as_deref().map_or(0, RigidBody::bytes);
        (format!("pose and momenta in f64, {} lattice vertices", body.shape.lattice.len()), bytes)
    }

    fn check(&self, body: &Body, snapshot: &BodySnapshot, _vertices: usize) -> Result<(), StateError> {
        check_owner(body, "the motion", snapshot.state.rigid.is_some() == body.is_rigid())
    }

    fn restore(&self, body: &mut Body, _snapshot: &BodySnapshot) {
        body.write_pose();
    }
}
