//! Errors of rigid bodies.

use thiserror::Error;

/// A setting or an action that a rigid body does not have, because it does not deform.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum RigidError {
    /// A setting.
    #[error(
        "rigid and {key} are mutually exclusive: a rigid body does not deform; leave out {key}, or rigid"
    )]
    Setting {
        /// Name of the setting.
        key: &'static str,
    },
    /// A change of a built body.
    #[error("the body is rigid, so that {change} is not possible; build it without rigid")]
    Change {
        /// The change.
        change: &'static str,
    },
    /// A setting or a change of a rigid body, of a soft body.
    #[error("the body is soft, so that {change} is not possible; build it with rigid")]
    NotRigid {
        /// The setting or the change.
        change: &'static str,
    },
}
