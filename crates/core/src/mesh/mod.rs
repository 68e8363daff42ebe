//! The surface mesh: vertices, polygons, topology, volume.
//!
//! The files, in the order of the data flow:
//!
//! * `polygons`: [`Mesh`], the vertices and polygons; `build` makes and scales meshes.
//! * `named`: its groups of vertices, and maps, which have a number for each vertex.
//! * `scale`: factors by which a model is scaled; `refine` divides large faces.
//! * `weld`: finds vertices at equal positions.
//! * `triangles`: the triangles of the faces. `polygon` triangulates a polygon in a plane.
//! * `topology`: the `description` of a surface. `duplicates` finds repeated faces; `volume` and `measure` compute
//!   volume and area.
//! * `interior`: which points are inside; `winding_tree` computes winding numbers.
//! * `surface_tree`: closest points on a mesh.
//! * `animation`: positions of the vertices at several times.
//! * `csr`, `union_find`, `distinct`: rows, sets and sorted lists, also for the modules that depend on this module.
//! * `testing`: meshes and numbers for unit tests.

mod animation;
mod build;
mod csr;
mod description;
mod distinct;
mod duplicates;
mod error;
mod interior;
mod measure;
mod named;
mod needles;
mod polygon;
mod polygons;
mod refine;
mod scale;
mod surface_tree;
#[cfg(test)]
pub(crate) mod testing;
mod topology;
mod triangles;
mod union_find;
mod volume;
mod weld;
mod winding_tree;

pub(crate) use animation::mix;
pub use animation::{AnimationError, MeshAnimation};
pub(crate) use csr::Csr;
pub(crate) use description::OpenSurface;
pub use description::{Component, Topology};
pub(crate) use distinct::distinct;
pub use error::MeshError;
pub use interior::Interior;
pub(crate) use measure::RelativeMeasure;
pub(crate) use named::refined_map;
pub(crate) use needles::flip_needles;
pub(crate) use polygon::{Planar, distance_squared, planar_area, polygon_area, triangulate};
pub use polygons::Mesh;
pub use refine::{Refine, RefinedMesh};
pub use scale::Scale;
pub(crate) use surface_tree::{ClosestPoint, SurfaceTree};
pub(crate) use union_find::UnionFind;
pub(crate) use volume::signed_volume;
pub(crate) use winding_tree::WindingTree;
