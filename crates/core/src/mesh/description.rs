//! Descriptions of a surface, which its mesh caches.

use super::winding_tree::WindingTree;

/// A description of a surface. Unusual properties are counted here and are not errors.
///
/// It describes the welded surface: vertices at equal positions ([`Mesh::weld`](super::Mesh::weld)) count as one
/// vertex. Edges and volumes are those of the surface in which a face that is there several times, in one direction
/// or in both, is there once. Where a component is closed only without its two-sided faces, it has none of them.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Topology {
    /// Number of distinct edges between the corners of faces.
    pub edges: usize,
    /// Number of edges that faces do not use equally often in both directions. The surface is closed iff this
    /// is 0.
    pub open_edges: usize,
    /// Number of edges that exactly one face uses.
    pub boundary_edges: usize,
    /// Number of edges that more than two faces use.
    pub non_manifold_edges: usize,
    /// Number of edges that exactly two faces use in the same direction. The two faces have opposite
    /// orientation.
    pub misoriented_edges: usize,
    /// Connected components, in descending order of their number of faces. Components share no vertex.
    pub components: Vec<Component>,
    /// Number of faces with fewer than three distinct corners.
    pub degenerate_faces: usize,
    /// Number of faces that repeat an earlier face: the same corners in the same direction.
    pub duplicate_faces: usize,
    /// Number of faces that repeat an earlier face reversed: the same corners in the opposite direction.
    pub two_sided_faces: usize,
    /// Number of vertices that no face uses.
    pub unused_vertices: usize,
    /// Number of used vertices minus the number of their distinct positions. Such additional vertices occur
    /// at UV seams and hard edges. Vertices at the same position have the same motion.
    pub seam_vertices: usize,
    /// Number of vertices on open edges that nearly meet another one: they are within 1e-5 of the longest side of the
    /// bounding box, but not welded.
    pub near_misses: usize,
    /// Greatest distance of such vertices, in units of length.
    pub near_miss_distance: f64,
    /// Enclosed volume in cubed units of length, about the center of the bounding box. Negative if the faces
    /// are clockwise seen from outside.
    pub signed_volume: f64,
    /// The triangles of the surface; `None` if no face is repeated.
    pub(super) surface: Option<Vec<[u32; 3]>>,
}

/// A connected component of a surface. It shares no welded vertex with other components.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Component {
    /// Index of the first face of the component, from 0.
    pub first_face: usize,
    /// Number of faces.
    pub faces: usize,
    /// Whether the component is closed and therefore encloses a volume.
    pub closed: bool,
    /// Enclosed volume in cubed units of length, about the center of the bounding box of the whole mesh.
    /// Negative if the normals of the faces point inwards.
    pub signed_volume: f64,
}

impl Topology {
    /// Returns whether the surface is closed and its faces are clockwise seen from outside, so that its
    /// signed volume is negative.
    pub fn is_flipped(&self) -> bool {
        self.open_edges == 0 && self.signed_volume < 0.0
    }
}

/// The parts of a surface that is not closed.
#[derive(Clone, Debug)]
pub(crate) struct OpenSurface {
    /// Triangles of the components that enclose a space; `None` if there are none.
    pub solid: Option<WindingTree>,
    /// Triangles of the other components.
    pub sheets: Vec<[u32; 3]>,
}
