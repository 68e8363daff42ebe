//! The simulation: bodies, colliders and time. [`Simulation::step`] advances the bodies and the time.
//!
//! | file | contents |
//! |---|---|
//! | `clock` | time, step length and number of steps |
//! | `load`, `substeps` | the automatic number of steps per frame |
//! | `groups` | which bodies can touch; common rest and common damping of bodies that touch |
//! | `collider` | access to a collider |
//! | `world` | [`Simulation`] |
//! | `links` | links between bodies |
//! | `settings` | changes of settings between steps |
//! | `builder` | builds a simulation |
//! | `membership` | adds and removes bodies |
//! | `contact` | contact between bodies in a step |
//! | `step` | the step |
//! | `queries` | what a ray meets, and what is nearest to a point |
//! | `contact_point` | a contact of the last step |
//! | `contact_points` | reports of the contacts |
//! | `state` | saves and restores the state |
//! | `reset` | sets the bodies back to frame 0 |
//! | `adopt` | continues a restored state with other settings |

mod adopt;
mod builder;
mod clock;
mod collider;
mod contact;
mod contact_point;
mod contact_points;
mod groups;
mod links;
mod load;
mod membership;
mod queries;
mod reset;
mod settings;
mod state;
mod step;
mod substeps;
mod world;

pub use builder::SimulationBuilder;
pub use collider::{ColliderMut, ColliderRef};
pub use contact_point::{ContactPoint, Touched};
pub use links::LinkRef;
pub use queries::FoundPoint;
pub use state::SimulationState;
pub use substeps::{ChosenSubsteps, StepReason, Substeps};
pub use world::Simulation;
