//! The stages of a step, in order: [`stages`]. Each comment in the lists gives the module that implements a stage,
//! and its formula.
//!
//! | symbol | meaning |
//! |---|---|
//! | h, a | length of the step, gravity |
//! | x, v, m, f | position, velocity and mass of a vertex, and the external force on it |
//! | n | number of regions that contain the vertex |
//! | v̄ | mean of the rigid velocities of these n regions at the vertex |
//! | g | goal position of the vertex |
//! | c, R | center of mass of a region, and the rotation of the region from the rest pose |
//! | x̄, P, L | center of mass, linear momentum and angular momentum of a connected component |
//! | r, r* | rigid motion of a component, without and with its supports (`dynamics::elastic_damping`) |
//! | c | decay rate of the modes of the body |
//! | J | impulse of a contact on a vertex |
//! | alpha, d | stiffness and region damping per step |
//! | superscript 0 | value in the rest pose, such as x⁰ |
//! | × | cross product |
//!
//! A *free component* is a connected component of the lattice without a constrained vertex. Its momenta are
//! tracked. A *free body* has no active constraint and no contact stage. The origin of its frame, from which
//! the f32 positions and velocities are measured, moves with the body. The crate page has the citations.
//!
//! | file | stages |
//! |---|---|
//! | `stage` | [`Stage`]: the trait of the stages |
//! | `constraints` | pins and handles |
//! | `keyed` | numbers of the material with keyframes |
//! | `inflation` | ratios of rest volumes |
//! | `momentum` | the momenta of free components |
//! | `damping` | region damping and the damping of the elastic modes |
//! | `matching` | shape matching |
//! | `rigid` | the motion of a rigid body, in place of the stages from `momentum` to `integration` |
//! | `recovery` | the return of a tangled body to its rest shape |
//! | `fracture` | the joints that break |
//! | `integration` | the advance of the positions |
//! | `forces` | external forces |
//! | `contacts` | contacts with colliders and bodies |
//! | `supports` | the part of the damping that supports take |

mod constraints;
mod contacts;
mod damping;
mod forces;
mod fracture;
mod inflation;
mod integration;
mod keyed;
mod matching;
mod momentum;
mod recovery;
mod rigid;
mod stage;
mod supports;

use self::constraints::{ApplyConstraints, BeginConstraints, PullToGoals};
use self::contacts::{BeginContacts, TouchBodies, TouchColliders};
pub(super) use self::damping::{DampModes, DampRegions};
use self::forces::ApplyForces;
use self::fracture::FindBreaking;
use self::inflation::UpdateInflation;
use self::integration::Integrate;
use self::keyed::KeyMaterial;
use self::matching::MatchShapes;
use self::momentum::TrackMomentum;
use self::recovery::Recover;
use self::rigid::MoveRigidly;
pub(super) use self::stage::{BodyStep, Stage};
use self::supports::{DampOnSupports, MeetSupports};

/// The stages up to the contacts, which bodies that touch have in common.
pub(super) const ADVANCE: &[&dyn Stage] = &[
    // dynamics::constraints: pins and handles that become active capture the positions of their vertices.
    // dynamics::follow: targets of handles that follow an animated mesh.
    &BeginConstraints,
    // dynamics::keyed: E, Poisson's ratio, damping ratio and friction at the end of the step.
    &KeyMaterial,
    // dynamics::inflation: s, the ratios of the rest volumes of the regions, at the end of the step.
    &UpdateInflation,
    // dynamics::momentum: P = Σ m v and L = Σ m (x - x̄) × v, in f64, of each free component whose momenta are not
    // known.
    &TrackMomentum,
    // dynamics::damping: v += d (v̄ - v).
    &DampRegions,
    // dynamics::elastic_damping: r, the rigid motion of each component. Before the acceleration, v becomes
    // r + exp(-2 c h) (v - r).
    &DampModes,
    // body::escape: finds the components inside colliders. contact: stores v as the velocity before the impacts of this
    // step.
    &BeginContacts,
    // matching: R = rotation of Σ m/n (x - c)(x⁰ - c⁰)ᵀ; g = mean of R (x⁰ - c⁰) + c over the regions that contain the
    // vertex. matching::plastic: with plasticity, S (x⁰ - c⁰) takes the place of x⁰ - c⁰, and then the plastic shapes S
    // flow. dynamics::integration: v += alpha (g - x)/h + h a.
    &MatchShapes,
    // dynamics::recovery: v = r + beta (g - x)/h of a tangled body, with its rigid motion r and its goals g as a whole.
    &Recover,
    // fracture: strains of the joints by the deformation gradients F = A C⁻¹ of the regions, which the matching measured.
    // The joints that exceed their limits break at the end of the step.
    &FindBreaking,
    // dynamics::integration: x += h v, after v is corrected such that the momenta are P and L.
    &Integrate,
    // dynamics::rigid, of a rigid body, in place of the stages that need the regions: V += h a; c += h V; R turns at
    // constant angular momentum; x = c + R r.
    &MoveRigidly,
    // dynamics::forces: v += h f/m and x += h² f/m. After the damping, so that a steady force acts whole.
    &ApplyForces,
    // dynamics::goal: v += h a and x += h² a, with the acceleration a = -ω² (x - t) - 2 ζ ω (v - t') by a soft pin or handle.
    &PullToGoals,
];

/// The stages of the contacts.
pub(super) const FINISH: &[&dyn Stage] = &[
    // contact::bodies: v += J/m and x += h J/m where the samples of bodies touch each other, and, together with them,
    // where they touch colliders.
    &TouchBodies,
    // body::escape: components inside colliders are translated. contact: v += J/m and x += h J/m where surface samples
    // touch a collider. Samples that are then more than 0.01 cells inside a collider are pushed out by a change of x
    // alone.
    &TouchColliders,
    // dynamics::constraints: x and v become the target position and velocity of the pin or handle.
    &ApplyConstraints,
    // dynamics::reaction: r*, the rigid motion of each component that also meets the conditions of its supports. Bodies
    // that press on each other have their conditions in common.
    &MeetSupports,
];

/// The stages after the contacts of all bodies.
pub(super) const END: &[&dyn Stage] = &[
    // dynamics::elastic_damping: v += (1 - exp(-2 c h)) (r* - r).
    &DampOnSupports,
];

/// Returns the stages in execution order. A step runs them, the plan prints them with their memory, and
/// changes of the lattice and of the regions go through them.
pub(super) fn stages() -> impl Iterator<Item = &'static dyn Stage> {
    ADVANCE.iter().chain(FINISH).chain(END).copied()
}
