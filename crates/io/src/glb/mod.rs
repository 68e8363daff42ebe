//! Writes a run as a GLB file: glTF 2.0 (Khronos 2017, ISO/IEC 12113:2022) with one animation.
//!
//! ```text
//! input -> surface: vertices of glTF, materials
//! frames -> motion: a rigid motion of each body, and components of its deformation
//! both -> scene: the JSON and the binary chunk of the file
//! ```
//!
//! A body is a node with a mesh. The node moves rigidly; what remains of the motion are morph targets, one per component,
//! with a weight in each frame. Colliders are children of a node of their own, and move rigidly. In frames in which a collider is
//! disabled the scale of its node is 0, by which glTF animates visibility (section 3.5.3 of the specification).

mod arrays;
mod colliders;
mod layout;
mod materials;
mod motion;
mod scene;
mod shown;
mod surface;

pub(crate) use colliders::ColliderSurface;
pub(crate) use materials::Materials;
pub(crate) use motion::Samples;
pub(crate) use scene::{SceneDescription, read_extras, write_scene, write_still};
pub(crate) use surface::{BodyPoints, SplitSurface};
