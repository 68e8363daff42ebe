//! Contacts between the visible surface of a body and colliders.
//!
//! | file | content |
//! |---|---|
//! | `shape` | shapes of colliders and their signed distance, in the world and in the frame of a body |
//! | `collider` | colliders: shape, friction, restitution, motion; the checked set of a scene |
//! | `samples` | points of the visible surface on which contacts act, by lattice cell |
//! | `field` | distances of the samples of a cell from a shape, and bounds of them |
//! | `patch` | the touching samples about one lattice vertex, which act as one point |
//! | `detection` | the patches that touch a shape |
//! | `constraint` | contact constraints: normal, target velocity and friction of a patch, and its impulse |
//! | `solver` | the impulses of all constraints together |
//! | `stage` | [`Contacts`], the stage of a body: velocities before the step, detection, impulses, push-out |
//! | `vec4`, `rows` | padded vectors; sets of rows |
//!
//! # Energy
//!
//! A contact that changes a velocity also changes the position, by this change times the step, so that the step stays a
//! step of Verlet's method. Contacts then add no energy, whatever the restitution. Let M be the masses, V a quadratic
//! energy of deformation, and let a step h lead from x- by x to x+. The energy of the step is |x+ - x|^2 / 2h^2 in the norm
//! of M, plus V between x and x+. An impulse changes it by its product with (x+ - x-) / 2h, the mean of the velocities
//! before and after the step. So a contact that pushes and separates no faster than it approached does no positive work,
//! nor does friction against that mean velocity. (The time-stepping of impacts by Paoli & Schatzman, 1993, rests on the
//! same product.)
//!
//! There are small exceptions. A point that was leaving and was turned back further than it may return stops at the
//! surface, and the push-out lifts by positions. Impulses within their tolerance let a body sink by a little, which the
//! push-out corrects: the tolerance decides how still a body rests.

mod collider;
mod constraint;
mod detection;
mod field;
mod patch;
mod rows;
mod samples;
mod shape;
mod solver;
mod stage;
mod vec4;

pub use self::collider::{Collider, ColliderError, ColliderFault, Colliders};
#[cfg(feature = "internals")]
pub use self::detection::ContactReport;
pub(crate) use self::field::{Curved, Field, may_touch, monomials};
pub(crate) use self::rows::RowSet;
pub(crate) use self::samples::SampleBlock;
pub use self::samples::SampleCells;
pub(crate) use self::shape::PosedShape;
pub use self::shape::{Shape, SignedDistance};
pub use self::stage::Contacts;
pub(crate) use self::vec4::{Vec4, wide};

/// Distance in cells up to which a sample outside a collider still counts as touching it: a body that rests and vibrates
/// stays in contact. Such samples get impulses and friction, and are not pushed out.
const SKIN: f64 = 1e-3;
