//! The motion of rigid bodies: six degrees of freedom, in place of shape matching and integration.
//!
//! | file | contents |
//! |---|---|
//! | `mass` | mass, center of mass and inertia tensor |
//! | `rotation` | the rotation of a body whose angular momentum is constant |
//! | `holds` | the vertices that pins and handles hold, as joints |
//! | `error` | errors |
//! | `body` | [`RigidBody`]: advances a pose, applies impulses, and writes the lattice vertices |

mod body;
mod error;
mod holds;
mod mass;
mod rotation;

pub(crate) use body::RigidBody;
pub use error::RigidError;
pub(crate) use holds::HeldVertex;
pub(crate) use mass::{RigidMass, vertex_moments};
