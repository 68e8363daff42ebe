//! What makes a surface mesh unusable.

/// Why a mesh is refused.
///
/// Whatever is merely unusual (open, non-manifold, flipped, degenerate faces, ...) is not refused but described by
/// [`Topology`](super::Topology).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A corner of a face names a vertex that does not exist. Faces and vertices are counted from 0.
    #[error("face {face} refers to vertex {vertex} of {count} (counted from 0)")]
    IndexOutOfRange {
        /// The face, from 0.
        face: usize,
        /// The vertex it names, from 0.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// A coordinate is NaN, infinite, or beyond the range of `f32`, in which surfaces are simulated and written.
    #[error(
        "vertex {vertex} (counted from 0) has {axis} = {value:?}: coordinates must be finite and within the range of f32"
    )]
    NotFinite {
        /// The vertex, from 0.
        vertex: usize,
        /// `'x'`, `'y'` or `'z'`.
        axis: char,
        /// The coordinate.
        value: f64,
    },
    /// No face has three distinct corners.
    #[error("no faces: {faces} given, none with three distinct corners (vertices: {vertices})")]
    NoFaces {
        /// How many faces were given.
        faces: usize,
        /// How many vertices were given.
        vertices: usize,
    },
    /// All vertices that faces use lie in one point.
    #[error("no extent: all {vertices} vertices of the faces lie at ({}, {}, {})", .at[0], .at[1], .at[2])]
    NoExtent {
        /// How many vertices the faces use.
        vertices: usize,
        /// Where they all lie.
        at: [f64; 3],
    },
    /// More vertices, faces or corners than 32-bit indices can count.
    #[error("{count} {what} are more than 32-bit indices can count")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How much there is.
        count: usize,
    },
    /// The factor of [`Mesh::scaled`](super::Mesh::scaled) is not a finite number above 0.
    #[error("a scale of {0} is not possible: it must be finite and greater than 0")]
    Scale(f64),
}
