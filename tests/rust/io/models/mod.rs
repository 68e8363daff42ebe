//! Reading GLB, glTF, STL and PLY files.

mod faults;
mod files;
mod formats;
mod fuzz;
mod gltf;
mod images;
mod maps;
mod matrix;
mod packages;
mod runs;
