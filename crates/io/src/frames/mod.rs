//! Frames: a moving surface as files that other programs read.
//!
//! | format | files | holds |
//! |---|---|---|
//! | [`Format::Obj`] | `NAME_0000.obj`, ... | the input, byte for byte, with new positions and normals |
//! | [`Format::Ply`] | `NAME_0000.ply`, ... | binary little endian: positions, vertex normals, faces |
//! | [`Format::Pc2`] | `NAME.pc2` | Point Cache 2: the positions of all frames, for the input's vertex order |
//!
//! A [`Sequence`] names the files, a [`FrameWriter`] writes them: [`Source`] and positions -> obj (with turned_normals and
//! library_path), plain, ply or pc2.
//!
//! Every file is written under another name (`.part` at its end) and renamed when it is whole, so that a final name
//! never stands for half a file.

mod error;
mod library_path;
mod number;
mod obj;
mod pc2;
mod plain;
mod ply;
mod sequence;
mod turned_normals;
mod writer;

pub use error::OutputError;
pub use sequence::{Format, Sequence, UnknownFormat};
pub use turned_normals::shared_normals;
pub use writer::{FrameWriter, Source};
