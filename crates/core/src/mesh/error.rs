//! Errors of the construction of a surface mesh.

use super::Scale;

/// An error of the construction of a mesh.
///
/// Unusual meshes (open, non-manifold, flipped, with degenerate faces, ...) are accepted and described by
/// [`Topology`](super::Topology).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A corner of a face refers to a vertex that does not exist.
    #[error("face {face} refers to vertex {vertex} of {count} (counted from 0)")]
    IndexOutOfRange {
        /// Index of the face, from 0.
        face: usize,
        /// Index of the vertex, from 0.
        vertex: u32,
        /// Number of vertices of the mesh.
        count: usize,
    },
    /// A coordinate is NaN, infinite, or outside the range of `f32`, in which surfaces are simulated and
    /// written.
    #[error(
        "vertex {vertex} (counted from 0) has {axis} = {value:?}: coordinates must be finite and within the range of f32"
    )]
    NotFinite {
        /// Index of the vertex, from 0.
        vertex: usize,
        /// The axis: `'x'`, `'y'` or `'z'`.
        axis: char,
        /// Value of the coordinate.
        value: f64,
    },
    /// No face has three distinct corners.
    #[error("no faces: {faces} given, none with three distinct corners (vertices: {vertices})")]
    NoFaces {
        /// Number of faces given.
        faces: usize,
        /// Number of vertices given.
        vertices: usize,
    },
    /// All vertices that faces use are at the same point.
    #[error("no extent: all {vertices} vertices of the faces lie at ({}, {}, {})", .at[0], .at[1], .at[2])]
    NoExtent {
        /// Number of vertices that the faces use.
        vertices: usize,
        /// The common position.
        at: [f64; 3],
    },
    /// There are more than 2^32 - 2 vertices or corners of faces, the maximum for 32-bit indices.
    #[error("the mesh has {count} {what}; 32-bit indices allow at most 4294967294")]
    TooLarge {
        /// Name of the items: vertices or corners of faces.
        what: &'static str,
        /// Number of items.
        count: usize,
    },
    /// A map has another number of values than the mesh has vertices.
    #[error(
        "the map {name:?} has {count} values, and the mesh {expected} vertices; give a value for each vertex"
    )]
    MapLength {
        /// Name of the map.
        name: String,
        /// Number of values.
        count: usize,
        /// Number of vertices.
        expected: usize,
    },
    /// A mesh with edges this short would have too many faces.
    #[error(
        "with edges of at most {edge:.4e} the mesh has more than {faces} faces; choose larger cells, or refine less"
    )]
    TooFine {
        /// Greatest length of an edge.
        edge: f64,
        /// Largest number of faces.
        faces: usize,
    },
    /// The scale of [`Mesh::scaled`](super::Mesh::scaled) is out of range.
    #[error(
        "the scale is {0}; one factor must be finite and greater than 0, and three factors finite and not 0"
    )]
    Scale(Scale),
}
