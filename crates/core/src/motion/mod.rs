//! Motions given in advance: poses, numbers and switches along keyframes, and drives to a target pose, for handles and
//! colliders.
//!
//! | file | contents |
//! |---|---|
//! | `angles` | rotation matrices from Euler angles in degrees, bit-identical on every machine; unit vectors |
//! | `interpolation` | interpolation between keyframes |
//! | `keyframes` | keyframed rigid motion, and its poses |
//! | `curve` | keyframed numbers |
//! | `switch` | what is on or off along keyframes |
//! | `drive` | motion from the current pose to a target pose |

mod angles;
mod curve;
mod drive;
mod interpolation;
mod keyframes;
mod switch;

pub(crate) use angles::{direction, sin_cos_degrees};
pub use angles::{euler_degrees, euler_degrees_near, quaternion_rotation};
pub use curve::{Curve, CurveKey, CurveValue};
pub(crate) use drive::Drive;
pub use interpolation::Interpolation;
pub(crate) use keyframes::{EulerPose, Pose};
pub use keyframes::{Key, Motion, MotionError};
pub use switch::{Switch, SwitchKey};
