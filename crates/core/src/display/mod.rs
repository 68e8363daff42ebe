//! The displayed surface of a body: P^ of the dynamics, untangled and corrected, and the mesh in its cells.
//!
//! | file | contents |
//! |---|---|
//! | `untangle` | untangles a lattice |
//! | `untangling` | untangles the displayed lattice within the limits |
//! | `stages` | the stages of the display, in order, their plan and their input |
//! | `lattice` | the positions of the lattice before and after the correction |
//! | `correcting` | the volume correction |
//! | `buffers` | [`Display`]: the buffers of an evaluation |
//! | `displayed` | [`Displayed`]: the lattice, the mesh, the normals and the volumes after an evaluation |
//! | `evaluate` | runs the stages |

mod buffers;
mod correcting;
mod displayed;
mod evaluate;
mod lattice;
mod stages;
mod untangle;
mod untangling;

pub use buffers::{Display, DisplayTimes};
pub use displayed::{Displayed, DisplayedSurface};
pub use untangle::UntanglingReport;
