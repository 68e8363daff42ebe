//! Pages: self-contained HTML files that show runs in a browser.
//!
//! A page contains a player (three.js and the files of `player/`) and the data of one or more runs: names, surfaces,
//! lattices and colliders, and for each frame the positions as 16-bit numbers, the volumes, the poses of colliders, and
//! the pieces of broken bodies.
//!
//! ```text
//! FrameBuilder -> bytes of a frame -> Packer: differences from predictions -> gzip -> TextWriter -> page
//! ```
//!
//! * `points`: positions as 16-bit numbers, and their prediction from earlier frames;
//! * `pieces`: the faces and links of broken bodies;
//! * `header`: the data that are the same in all frames;
//! * `frame`: the layout of a frame;
//! * `run`: the data of a run;
//! * `text`: bytes as text;
//! * `page`: writes a page;
//! * `read`: reads the runs of a page;
//! * `playback`: the frames of a run as surfaces, for films.

mod frame;
mod header;
mod page;
mod pieces;
mod playback;
mod points;
mod read;
mod run;
mod text;

pub(crate) use frame::{FrameBuilder, Layout};
pub(crate) use header::{Header, animated_positions};
pub(crate) use page::write_page;
pub(crate) use pieces::{BrokenBody, Topology};
pub(crate) use playback::Playback;
pub(crate) use read::read_page;
pub(crate) use run::{FrameSource, Run, decode_header, encode_header};
