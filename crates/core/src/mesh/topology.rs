//! What `inspect` says about a surface: found once, kept with the mesh.

use super::components::{self, Component};
use super::{Mesh, duplicates, edges, measure};

/// What is usual and unusual about a surface. Nothing in it is an error.
///
/// All of it is about the welded surface: vertices at exactly equal positions count as one.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Topology {
    /// Different edges between the corners of faces.
    pub edges: usize,
    /// Edges whose directed uses do not cancel. The surface is closed iff there are none.
    pub open_edges: usize,
    /// Edges of one face alone.
    pub boundary_edges: usize,
    /// Edges of more than two faces.
    pub non_manifold_edges: usize,
    /// Edges that exactly two faces use in the same direction: neighbours that face opposite ways.
    pub misoriented_edges: usize,
    /// Parts that share no vertex, largest number of faces first.
    pub components: Vec<Component>,
    /// Faces with fewer than three distinct corners.
    pub degenerate_faces: usize,
    /// Faces that repeat an earlier one: the same corners in the same direction.
    pub duplicate_faces: usize,
    /// Faces that repeat an earlier one turned over: the same corners in the opposite direction.
    pub two_sided_faces: usize,
    /// Vertices that no face uses.
    pub unused_vertices: usize,
    /// Used vertices beyond the first at their position, as UV seams and hard edges leave them. They move alike.
    pub seam_vertices: usize,
    /// Enclosed volume in cubed units of length, about the centre of the bounds; negative if flipped.
    pub signed_volume: f64,
}

impl Topology {
    /// Whether most faces run clockwise seen from outside, so that the volume comes out negative.
    pub fn is_flipped(&self) -> bool {
        self.open_edges == 0 && self.signed_volume < 0.0
    }

    pub(super) fn of(mesh: &Mesh) -> Self {
        let weld = mesh.weld();
        let edges = edges::tally(mesh);
        let repeated = duplicates::count(mesh);
        let (unused_vertices, seam_vertices) = count_vertices(mesh);
        Self {
            edges: edges.edges,
            open_edges: edges.open.len(),
            boundary_edges: edges.boundary,
            non_manifold_edges: edges.non_manifold,
            misoriented_edges: edges.misoriented,
            components: components::find(mesh, &edges.open),
            degenerate_faces: mesh.faces().filter(|face| is_degenerate(face, weld)).count(),
            duplicate_faces: repeated.duplicate,
            two_sided_faces: repeated.two_sided,
            unused_vertices,
            seam_vertices,
            signed_volume: measure::signed_volume(mesh.vertices(), mesh.triangles(), mesh.centre()),
        }
    }
}

/// Whether a face has fewer than three distinct corners.
pub(super) fn is_degenerate(face: &[u32], weld: &[u32]) -> bool {
    let Some(&first) = face.first() else { return true };
    let first = weld[first as usize];
    let mut others = face.iter().map(|&corner| weld[corner as usize]).filter(|&corner| corner != first);
    let Some(second) = others.next() else { return true };
    others.all(|corner| corner == second)
}

/// Vertices that no face uses, and used ones beyond the first at their position.
fn count_vertices(mesh: &Mesh) -> (usize, usize) {
    let weld = mesh.weld();
    let mut used = vec![false; weld.len()];
    let mut place = vec![false; weld.len()];
    for &corner in mesh.corners() {
        used[corner as usize] = true;
        place[weld[corner as usize] as usize] = true;
    }
    let count = |flags: &[bool]| flags.iter().filter(|&&flag| flag).count();
    (weld.len() - count(&used), count(&used) - count(&place))
}
