//! Contacts between the surface of a body and colliders: detection, contact constraints, impulses, friction.
//!
//! | file | content |
//! |---|---|
//! | `shape` | collider shapes and their signed distances, in world space and in the frame of a body |
//! | `collider` | colliders: shape, friction, restitution, motion; the validated set of a scene |
//! | `samples` | points of the body's surface on which contacts act, grouped by lattice cell |
//! | `field` | distances of the samples of a cell from a shape, and lower bounds of these distances |
//! | `patch` | the touching samples nearest to one lattice vertex, which act as one contact point |
//! | `detection` | the patches that touch a shape |
//! | `constraint` | contact constraints: normal, target velocity, Coulomb friction cone, impulse |
//! | `solver` | the impulses of all contact constraints, by projected Jacobi iteration |
//! | `stage` | [`Contacts`], the stage of a body: velocity before, detection, impulses, push-out |
//! | `vec4`, `rows` | three-component vectors padded to four; sparse sets of rows |
//!
//! # Energy
//!
//! A contact that changes a velocity also changes the position, by the velocity change times the step, so
//! that the step remains a step of Verlet's method. Contacts then add no energy, for any restitution. Let M
//! be the mass matrix and V a quadratic deformation energy, and let two steps of length h lead from x- to x
//! and from x to x+. The energy of the step is |x+ - x|^2 / 2h^2 in the norm of M, plus V between x and x+.
//! An impulse changes this energy by its product with (x+ - x-) / 2h, the mean of the velocities before and
//! after the step. A contact that pushes and separates no faster than it approached therefore does no
//! positive work. Friction against that mean velocity does no positive work either. (Paoli & Schatzman 1993
//! base their time-stepping of impacts on the same product.)
//!
//! There are small exceptions. A point that was separating and was turned back further than it may return
//! stops at the surface. The push-out lifts a body by changing positions alone. Impulses that are only solved
//! to a tolerance let a body sink slightly, which the push-out corrects: the tolerance determines the
//! residual motion of a resting body.

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
pub(crate) use self::field::{Field, ShapeField, may_touch, monomials};
pub(crate) use self::rows::RowSet;
pub(crate) use self::samples::SampleBlock;
pub use self::samples::SampleCells;
pub(crate) use self::shape::PosedShape;
pub use self::shape::{Shape, SignedDistance};
pub use self::stage::Contacts;
pub(crate) use self::vec4::{Vec4, wide};

/// Thickness of the contact skin: a sample outside a collider touches it up to this distance, in cells.
///
/// The skin keeps a body that rests and vibrates in contact. Samples in the skin get impulses and friction,
/// and are not pushed out.
const SKIN: f64 = 1e-3;
