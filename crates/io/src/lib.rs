//! File input and output for [`supple`]: reads models and scenes, runs simulations, writes frames.
//!
//! * [`memory_limit`] asks for the memory of the machine.
//! * `space` converts the coordinates of scenes to those of files.
//! * `collider` has the places of colliders, for the files that show them.
//! * [`obj`] reads Wavefront OBJ models, and keeps the bytes so that they can be written back unchanged.
//! * [`model`] reads OBJ, GLB, glTF, STL and PLY models, as OBJ documents.
//! * `usd` writes USD stages.
//! * `glb` writes runs as animated GLB files.
//! * `vat` writes vertex animation textures.
//! * `vtk` writes grids of VTK.
//! * [`film`] renders moving pictures.
//! * `html` writes and reads pages that show runs in a browser.
//! * [`frames`] writes frame sequences in all formats.
//! * [`scene`] reads and writes scenes in TOML.
//! * [`run`] runs a scene and writes its frames, statistics and checkpoints.
//! * [`pages`] joins the pages of several runs.
//! * [`films`] writes films of runs on disk.
//! * [`saved_state`] converts the state of a simulation to bytes.
//!
//! Each module may use only the modules above it in this list.

mod collider;
mod count;
mod escape;
mod file;
pub mod film;
pub mod films;
pub mod frames;
mod glb;
mod html;
mod memory;
pub mod model;
pub mod obj;
pub mod pages;
mod path;
pub mod run;
pub mod saved_state;
pub mod scene;
mod space;
mod usd;
mod vat;
mod vtk;

pub use count::counted;
pub use escape::Escaped;
pub use file::write_atomically;
pub use memory::memory_limit;
