//! Contacts between the surface of a body and colliders: detection, contact constraints, impulses, friction.
//!
//! Contacts act on samples: points of the surface of the body's mesh, or the surface vertices of the lattice
//! for a bare lattice (a body without a mesh). The impulses remove overlaps of up to 0.01 cells over the next steps.
//! Deeper samples are pushed out of the collider by a change of the positions alone.
//!
//! | file | content |
//! |---|---|
//! | `deformation` | the surface of an animated mesh during a step, and its velocity |
//! | `distance` | the signed distance from a shape |
//! | `fault` | errors of colliders |
//! | `collision_mesh` | meshes as shapes: solids if they are closed, shells if they are open |
//! | `shape` | collider shapes and their signed distances, in world space and in the frame of a body |
//! | `collider` | description of a collider: shape, friction, restitution, keyframes |
//! | `collider_motion` | the motion of a collider |
//! | `colliders` | the validated colliders of a simulation, at rest, along keyframes or driven |
//! | `posed_collider` | a collider during a step: its shapes, and the motion of its surface |
//! | `parts` | the parts of a body that touch: a whole body, or the pieces of a broken one |
//! | `surface_points` | points of a surface that are samples |
//! | `sampler` | samples the surface of a body part by part: a mesh or a bare lattice |
//! | `samples` | the samples, grouped by lattice cell |
//! | `field` | distances of the samples of a cell from a shape, and lower bounds of these distances |
//! | `sides` | the side of a shape from which a sample came, and its contact there |
//! | `swept` | the paths of the samples in a step, and the search for those that touch |
//! | `patch` | contact patches: the touching samples nearest to one vertex act as one contact point |
//! | `detection` | finds the patches that touch a shape |
//! | `constraint` | contact constraints: normal, target velocity, Coulomb friction cone, impulse |
//! | `solver` | the contact problem: its constraints and impulses |
//! | `jacobi` | the solution of the problem by projected Jacobi iteration |
//! | `nearest` | the samples nearest to a shape, at displayed positions |
//! | `ray` | where a ray meets a shape |
//! | `rigid` | the rigid bodies of a problem |
//! | `pressure` | a contact of the last step |
//! | `stage` | [`Contacts`], the contact stage of a body: detection |
//! | `finish` | the second part of the stage: impulses, and the push-out of samples that are still inside a collider |
//! | `rigid_stage` | how the stage moves rigid bodies |
//! | `continuation` | the data of the stage for snapshots and for a body that breaks |
//! | `escape` | the translation by which a body that begins inside colliders leaves them |
//! | `vec4` | three-component vectors padded to four components |
//! | `smooth_rows` | slopes of the lattice at the rows, for a smooth skin |
//! | `memory` | the memory of buffers |
//!
//! # Energy
//!
//! An impulse changes a velocity and also the position, by the velocity change times the step, so that the
//! step remains a step of Verlet's method. Contacts then add no energy, for any restitution. Let M be the
//! mass matrix and V(x) = x^T K x / 2 a quadratic deformation energy (K is the stiffness matrix and ^T the
//! transpose), and let two steps of length h lead from x- to x and from x to x+. Verlet's method conserves
//! the sum of (x+ - x)^T M (x+ - x) / 2h^2 and x^T K x+ / 2. An impulse changes this sum by its product with
//! (x+ - x-) / 2h, the mean of the velocities before and after the step. A contact therefore does no positive
//! work if its impulse points away from the collider and the point separates no faster than it approached.
//! Friction opposite to the tangential part of this mean velocity does no positive work either. (Paoli &
//! Schatzman 1993 base their time-stepping of impacts on the same product.)
//!
//! There are four small exceptions:
//!
//! * A point that moved away before the step may approach as fast as it moved away. Where it would then enter
//!   the collider, it stops at the surface instead, and the impulse adds energy.
//! * A contact that overlaps separates by a part of the overlap in a step, at most 12 times the overlap in a second.
//! * The push-out of deeper samples changes positions alone, and so lifts the body.
//! * Impulses are computed up to a tolerance, so that a resting body sinks slightly until the overlap is removed. The
//!   tolerance therefore determines the residual motion of a resting body.

pub(crate) mod bodies;
mod collider;
mod collider_motion;
mod colliders;
mod collision_mesh;
mod constraint;
mod continuation;
mod deformation;
mod detection;
mod distance;
mod escape;
mod fault;
mod field;
mod finish;
mod interpolant;
mod jacobi;
mod memory;
mod nearest;
mod parts;
mod patch;
mod posed_collider;
mod pressure;
mod ray;
mod rigid;
mod rigid_stage;
mod sampler;
mod samples;
mod shape;
mod sides;
mod smooth_rows;
mod solver;
mod stage;
mod surface_points;
mod swept;
mod vec4;

pub use self::collider::Collider;
pub use self::colliders::Colliders;
pub(crate) use self::colliders::DrivenCollider;
pub use self::collision_mesh::CollisionMesh;
#[cfg(feature = "internals")]
pub use self::detection::ContactReport;
pub use self::distance::SignedDistance;
pub(crate) use self::escape::BodyPoints;
pub use self::fault::{ColliderError, ColliderFault};
pub(crate) use self::nearest::MovedSamples;
pub(crate) use self::parts::Parts;
pub(crate) use self::pressure::Pressure;
pub(crate) use self::rigid_stage::RigidMover;
pub(crate) use self::sampler::RestSurface;
pub use self::samples::SampleCells;
pub(crate) use self::shape::PosedShape;
pub use self::shape::Shape;
pub(crate) use self::sides::Side;
pub use self::stage::Contacts;

/// Thickness of the contact skin, in cells. A sample touches a collider if it is inside the collider, or
/// outside at a distance of at most this thickness.
///
/// The skin keeps a resting body in contact while it vibrates. Samples in the skin get impulses and friction,
/// and are not pushed out.
const SKIN: f64 = 1e-3;
