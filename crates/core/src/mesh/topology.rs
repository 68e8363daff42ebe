//! Describes a surface: edges, components, repeated faces, volume. The mesh caches the description.

use super::{Csr, Mesh, UnionFind, duplicates, is_degenerate};

/// A description of a surface. Unusual properties are counted here and are not errors.
///
/// It describes the welded surface: vertices at exactly equal positions count as one vertex.
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
    /// Enclosed volume in cubed units of length, about the center of the bounding box. Negative if the faces
    /// are clockwise seen from outside.
    pub signed_volume: f64,
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

    /// Computes the description of a mesh.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let weld = mesh.weld();
        let edges = EdgeCounts::new(mesh);
        let repeated = duplicates::count(mesh);
        let (unused_vertices, seam_vertices) = count_vertices(mesh);
        Self {
            edges: edges.edges,
            open_edges: edges.open.len(),
            boundary_edges: edges.boundary,
            non_manifold_edges: edges.non_manifold,
            misoriented_edges: edges.misoriented,
            components: components(mesh, &edges.open),
            degenerate_faces: mesh.faces().filter(|face| is_degenerate(face, weld)).count(),
            duplicate_faces: repeated.duplicate,
            two_sided_faces: repeated.two_sided,
            unused_vertices,
            seam_vertices,
            signed_volume: mesh.volume_of(mesh.triangles()),
        }
    }
}

/// Returns [`Topology::unused_vertices`] and [`Topology::seam_vertices`].
fn count_vertices(mesh: &Mesh) -> (usize, usize) {
    let weld = mesh.weld();
    let mut used = vec![false; weld.len()];
    let mut position_used = vec![false; weld.len()];
    for &corner in mesh.corners() {
        used[corner as usize] = true;
        position_used[weld[corner as usize] as usize] = true;
    }
    let count = |flags: &[bool]| flags.iter().filter(|&&flag| flag).count();
    (weld.len() - count(&used), count(&used) - count(&position_used))
}

/// Numbers of edges of a welded surface, by the way faces use them; see [`Topology`].
#[derive(Debug, Default)]
struct EdgeCounts {
    edges: usize,
    /// One of the two welded vertices of each open edge: an edge that faces do not use equally often in both
    /// directions.
    open: Vec<u32>,
    boundary: usize,
    non_manifold: usize,
    misoriented: usize,
}

impl EdgeCounts {
    /// Counts the edges of the polygons. The diagonals of the fans of triangles are not counted, because each
    /// is used once in both directions.
    ///
    /// Edges are sorted into rows by the lower of their two vertices. Each row is short and is sorted by the
    /// higher vertex. This takes linear time for surfaces, and the order is deterministic.
    fn new(mesh: &Mesh) -> Self {
        let weld = mesh.weld();
        let edges = mesh.faces().flat_map(|face| face.iter().zip(face.iter().cycle().skip(1)));
        let welded = edges.map(|(&from, &to)| (weld[from as usize], weld[to as usize]));
        // Ignores edges between equal positions, which have no direction. A use is packed as the higher
        // vertex, then one bit that is set if the edge is directed to the higher vertex.
        let uses = welded
            .filter(|(from, to)| from != to)
            .map(|(from, to)| (from.min(to), u64::from(from.max(to)) << 1 | u64::from(from < to)));
        let mut uses = Csr::sorted(weld.len(), uses);
        let mut counts = Self::default();
        for low in 0..uses.len() {
            let row = uses.row_mut(low);
            row.sort_unstable();
            for edge in row.chunk_by(|a, b| a >> 1 == b >> 1) {
                let forward = edge.iter().filter(|&use_| use_ & 1 == 1).count();
                counts.edges += 1;
                counts.boundary += usize::from(edge.len() == 1);
                counts.non_manifold += usize::from(edge.len() > 2);
                counts.misoriented += usize::from(edge.len() == 2 && forward != 1);
                if 2 * forward != edge.len() {
                    counts.open.push(low as u32);
                }
            }
        }
        counts
    }
}

/// Finds the components, in descending order of their number of faces. `open`: a vertex of each open edge.
fn components(mesh: &Mesh, open: &[u32]) -> Vec<Component> {
    let weld = mesh.weld();
    let mut sets = UnionFind::new(weld.len());
    for edge in mesh.faces().flat_map(|face| face.windows(2)) {
        sets.unite(weld[edge[0] as usize], weld[edge[1] as usize]);
    }
    let (count, labels) = sets.labels();
    let label = |corner: u32| labels[weld[corner as usize] as usize];
    let triangles =
        Csr::sorted(count, mesh.triangles().iter().map(|triangle| (label(triangle[0]), *triangle)));
    let component = |members: &[[u32; 3]]| Component {
        first_face: usize::MAX,
        faces: 0,
        closed: true,
        signed_volume: mesh.volume_of(members),
    };
    let mut components: Vec<_> = triangles.rows().map(component).collect();
    for (index, face) in mesh.faces().enumerate() {
        let Some(&corner) = face.first() else { continue };
        let component = &mut components[label(corner) as usize];
        component.first_face = component.first_face.min(index);
        component.faces += 1;
    }
    for &vertex in open {
        components[label(vertex) as usize].closed = false;
    }
    // Removes the sets that consist of one vertex that no face uses.
    components.retain(|component| component.faces > 0);
    components.sort_by_key(|component| (usize::MAX - component.faces, component.first_face));
    components
}
