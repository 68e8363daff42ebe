//! Frame sequences: the displayed surfaces as files that other programs read.
//!
//! | format | files | contents |
//! |---|---|---|
//! | [`Format::Obj`] | `NAME_0000.obj`, ... | the input, byte for byte, with new positions and normals |
//! | [`Format::Ply`] | `NAME_0000.ply`, ... | binary little endian: positions, vertex normals, faces |
//! | [`Format::Pc2`] | `NAME.pc2` | Point Cache 2: the positions of all frames, in the input's vertex order |
//!
//! A [`Sequence`] names the files and a [`FrameWriter`] writes them:
//! [`Source`] and positions -> obj (with normal_transform and library_path), plain, ply or pc2.
//!
//! Every file is written under a temporary name (with `.part` appended) and renamed when it is complete. A
//! file with a final name is therefore always complete.

mod error;
mod library_path;
mod normal_transform;
mod number;
mod obj;
mod pc2;
mod plain;
mod ply;
mod sequence;
mod writer;

pub use error::OutputError;
pub use normal_transform::count_shared_normals;
pub use sequence::{Format, Sequence, UnknownFormat};
pub use writer::{FrameWriter, Source};
