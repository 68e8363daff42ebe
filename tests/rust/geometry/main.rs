//! Meshes, cells, lattices and the embedding of a mesh in them.

mod embedding;
mod lattice;
mod mesh;
mod random_triangles;
mod real_meshes;
mod resolution;
mod voxels;
