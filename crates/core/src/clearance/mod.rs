//! How far a displayed vertex may move: one answer, from colliders and bodies.
//!
//! Positions and distances are in cells of the body's frame. [`Clearance::move_clear`] moves the vertices of a body, finds
//! the limits of their displacements, and moves them again within these limits.
//!
//! | file | contents |
//! |---|---|
//! | `found` | the list of limits that are found |
//! | `colliders` | limits at colliders |
//! | `bodies` | limits at other bodies, and of the body at itself |
//! | `rounds` | finds limits and moves vertices, in turns |

mod bodies;
mod colliders;
mod found;
mod rounds;

pub(crate) use rounds::{Clearance, Mover};
