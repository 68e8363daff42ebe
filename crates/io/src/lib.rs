//! Files of [`supple`]: what it reads, what it writes, and the job between the two.
//!
//! * [`obj`]: Wavefront OBJ models, read so that they can be written back byte for byte.
//! * [`frames`]: frame sequences as OBJ, PLY and PC2.
//! * [`scene`]: scenes in TOML.
//! * [`run`]: a scene stepped to frames, with statistics and checkpoints.
//!
//! Each module may use those before it in this list.

mod file;
pub mod frames;
pub mod obj;
pub mod run;
pub mod scene;

pub use file::write_whole;
