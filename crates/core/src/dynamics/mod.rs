//! What moves a body: integration, damping, pins, handles, colliders and contacts.
//!
//! | file | what |
//! |---|---|
//! | `frame` | the body-local frame, and the interval of a step |
//! | `angles` | Euler angles in degrees |
//! | `selection` | which part of a body a pin, a handle or a force takes |
//! | `motion` | keyed rigid motion of handles and colliders |
//! | `hold` | pins and handles: what they hold, when, and how it moves |
//! | `kinematics` | pins and handles: the stage that overrides positions |
//! | `shape`, `collider` | what a body can touch |
//! | `colliders`, `posed` | what a body sees of it during a step |
//! | `samples` | points of the visible surface on which contacts act |
//! | `contact` | contacts: the stage that pushes out, clamps and rubs |
//! | `damping` | region damping, by the moment cascade |
//! | `momentum` | the books of free bodies, in f64 |
//! | `energy` | what such a body must not have more of than it began with |
//! | `integrate` | velocities corrected to the books, positions moved |

mod angles;
pub(crate) mod damping;
pub(crate) mod energy;
mod hold;
pub(crate) mod integrate;
mod kinematics;
pub(crate) mod momentum;
mod motion;
mod selection;

pub use angles::{euler_degrees, sin_cos_degrees};
pub use hold::{Handle, Hold, Pin, Window};
pub use kinematics::{Kinematics, KinematicsError};
pub use motion::{Key, Motion, MotionError, Pose};
pub(crate) use selection::direction;
pub use selection::{Selection, SelectionError};
