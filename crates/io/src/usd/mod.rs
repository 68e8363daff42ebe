//! USD stages: binary crate files that show runs in programs for animation and effects.
//!
//! ```text
//! Stage: bodies, materials, colliders -> bytes of frames, at once into the file
//!                                     -> prims -> structure of the file, after the frames
//! ```
//!
//! * `coding`: integers and bytes of the structure;
//! * `name`: names of prims;
//! * `prim`: prims, properties and values;
//! * `kind`, `section`: values and tables of the structure;
//! * `layer`: writes the structure;
//! * `layout`: the layout of a frame;
//! * `pieces`: the pieces of broken bodies in the frames; `surface_pieces`: their attributes;
//! * `material`, `surface`, `collider`: the prims of each;
//! * `stage`: the stage;
//! * `package`: packages of a stage and its images.

mod coding;
mod collider;
mod kind;
mod layer;
mod layout;
mod material;
mod name;
mod package;
mod pieces;
mod prim;
mod section;
mod stage;
mod surface;
mod surface_pieces;

pub(crate) use kind::{FRAMES, head};
pub(crate) use package::{Packed, STAGE as PACKAGED_STAGE};
pub(crate) use pieces::{PiecesBuilder, Places, Topology};
pub(crate) use section::CONTENTS;
pub(crate) use stage::{Stage, StageDescription};
pub(crate) use surface::{BodyInput, Surface};
