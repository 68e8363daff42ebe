//! A soft body: lattice, state, stages and mesh. Module `display` evaluates its displayed surface.
//!
//! | file | contents |
//! |---|---|
//! | `touching` | options of the contact with other bodies |
//! | `surface`, `piece_mesh` | the displayed mesh; the map from the mesh of the whole body to the pieces |
//! | `parts` | shape, settings, pipeline, contacts, fracture and display data of a body |
//! | `soft_body` | [`Body`]: its parts |
//! | `values` | positions, velocities and other values of the vertices |
//! | `samples` | the contact stage, and the samples of the surface |
//! | `pieces` | the mesh and the volume correction, which exist when they are needed |
//! | `proportions` | the size of a body, and how long and how wide it is |
//! | `elasticity` | the material in force |
//! | `material` | changes of the material between steps |
//! | `zones` | stiffness factors |
//! | `inflation` | ratios of rest volumes |
//! | `plasticity` | plastic shapes |
//! | `select` | the vertices of a selection |
//! | `settings` | changes settings between steps: volume correction, pins, handles, forces |
//! | `builder`, `builder_contact`, `build` | the settings of a new body; builds it |
//! | `rigid` | rigid bodies: step and contacts |
//! | `rigid_values` | the mass and the motion of a rigid body, as users set and read them |
//! | `reference` | a body with the data of its simulation |
//! | `context` | the inputs of a step |
//! | `transfer` | the state after joints broke |
//! | `breaking` | fracture and cuts |
//! | `body_contact` | contact with other bodies |
//! | `island` | the part of a body in a step of bodies that touch each other |
//! | `escape` | moves components that begin inside colliders out of them |
//! | `sleep` | decides whether a body at rest is stepped |
//! | `stages` | the stages of a step, in order |
//! | `step` | runs them |
//! | `plan` | describes the stages and their memory |
//! | `linked` | points of a body to which links tie |
//! | `applying` | applies forces and impulses |
//! | `hold_force` | the forces that pins and handles exert |
//! | `quantities` | sums mass, momenta and energies |
//! | `snapshot` | the saved state |
//! | `saving` | saves and restores it |
//! | `initial` | the state that a body was built with |
//! | `adopt` | takes settings of another body that was built alike |

mod adopt;
mod applying;
mod body_contact;
mod breaking;
mod build;
mod builder;
mod builder_contact;
mod context;
mod elasticity;
mod escape;
mod hold_force;
mod inflation;
mod initial;
mod island;
mod keyed;
mod linked;
mod material;
mod parts;
mod piece_mesh;
mod pieces;
mod plan;
mod plasticity;
mod proportions;
mod quantities;
mod reference;
mod rigid;
mod rigid_values;
mod samples;
mod saving;
mod select;
mod settings;
mod sleep;
mod snapshot;
mod soft_body;
mod stages;
mod step;
mod surface;
mod touching;
mod transfer;
mod values;
mod zones;

pub use adopt::AdoptedSettings;
pub use builder::BodyBuilder;
pub(crate) use context::StepContext;
pub use elasticity::Softened;
pub use hold_force::HoldForce;
pub(crate) use linked::Anchor;
pub use piece_mesh::PieceMesh;
pub use reference::BodyRef;
pub(crate) use reference::{DisplayContext, NearBodies};
pub use rigid_values::MassProperties;
pub(crate) use sleep::RestVote;
pub use snapshot::BodySnapshot;
pub use soft_body::Body;
pub(crate) use surface::Surface;
pub use touching::TouchingOptions;
#[cfg(feature = "internals")]
pub use values::constraint_factors;
