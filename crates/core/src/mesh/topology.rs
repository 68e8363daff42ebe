//! Describes a surface: edges, components, repeated faces, volume. The mesh caches the description.

use super::csr::Csr;
use super::description::{Component, Topology};
use super::distinct::distinct;
use super::duplicates::{self, Repeated, Use};
use super::polygons::Mesh;
use super::weld;
use super::weld::is_degenerate;

/// Greatest distance of near misses along an axis, relative to the longest side of the bounding box.
const NEAR: f64 = 1e-5;

impl Mesh {
    /// Returns the triangles of the surface: [`Mesh::triangles`], with each repeated face once; see
    /// [`Topology`].
    pub(crate) fn surface(&self) -> &[[u32; 3]] {
        self.topology().surface.as_deref().unwrap_or(self.triangles())
    }

    /// Returns the description of the surface. It is computed at the first call and cached.
    pub fn topology(&self) -> &Topology {
        self.topology.get_or_init(|| Topology::new(self))
    }

    /// Returns whether the surface is closed. It is closed if, with equal positions welded, the faces use
    /// each edge equally often in both directions.
    pub fn is_closed(&self) -> bool {
        self.topology().open_edges == 0
    }

    /// Returns the enclosed volume, in cubed units of length. It is never negative.
    ///
    /// For an open mesh this is the magnitude of the sum of the signed volumes of the tetrahedra from the
    /// center of the bounding box to the triangles, which has little meaning.
    pub fn volume(&self) -> f64 {
        self.signed_volume().abs()
    }

    /// Returns the volume as [`Mesh::volume`] does, but negative if the faces are clockwise seen from
    /// outside.
    pub fn signed_volume(&self) -> f64 {
        self.topology().signed_volume
    }
}

impl Topology {
    /// Computes the description of a mesh.
    fn new(mesh: &Mesh) -> Self {
        let weld = mesh.weld();
        let repeated = duplicates::find(mesh);
        let edges = EdgeCounts::new(mesh, &repeated);
        let surface = (!repeated.uses.is_empty()).then(|| surface(mesh, &repeated));
        let triangles = surface.as_deref().unwrap_or(mesh.triangles());
        let (unused_vertices, seam_vertices) = count_vertices(mesh);
        let (near_misses, near_miss_distance) = near_misses(mesh, &edges.open);
        Self {
            edges: edges.edges,
            open_edges: edges.open.len() / 2,
            boundary_edges: edges.boundary,
            non_manifold_edges: edges.non_manifold,
            misoriented_edges: edges.misoriented,
            components: components(mesh, triangles, &edges.open),
            degenerate_faces: mesh.faces().filter(|face| is_degenerate(face, weld)).count(),
            duplicate_faces: repeated.duplicate,
            two_sided_faces: repeated.two_sided,
            unused_vertices,
            seam_vertices,
            near_misses,
            near_miss_distance,
            signed_volume: mesh.volume_of(triangles),
            surface,
        }
    }
}

/// Returns the triangles of the faces that the surface has.
fn surface(mesh: &Mesh, repeated: &Repeated) -> Vec<[u32; 3]> {
    let mut triangles = mesh.triangles();
    let mut surface = Vec::with_capacity(triangles.len());
    for (index, face) in mesh.faces().enumerate() {
        let (own, others) = triangles.split_at(face.len().saturating_sub(2));
        triangles = others;
        match repeated.of(index) {
            Use::Kept => surface.extend(own),
            Use::Flipped => surface.extend(own.iter().map(|&[a, b, c]| [a, c, b])),
            Use::Left => {}
        }
    }
    surface
}

/// Returns [`Topology::near_misses`] and [`Topology::near_miss_distance`]. `open`: the vertices of open edges.
fn near_misses(mesh: &Mesh, open: &[u32]) -> (usize, f64) {
    let points: Vec<_> = distinct(open).into_iter().map(|&vertex| mesh.vertices()[vertex as usize]).collect();
    let nearest = weld::weld(&points, NEAR * (mesh.bounds().1 - mesh.bounds().0).amax());
    let missed = nearest.iter().enumerate().filter(|(point, first)| *point != **first as usize);
    let distances = missed.map(|(point, &first)| (points[point] - points[first as usize]).norm());
    distances.fold((0, 0.0), |(count, greatest), distance| (count + 1, distance.max(greatest)))
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

/// Numbers of edges of a welded surface, by how faces use them; see [`Topology`].
#[derive(Debug, Default)]
struct EdgeCounts {
    edges: usize,
    /// The two welded vertices of each open edge: an edge that faces do not use equally often in both directions.
    open: Vec<u32>,
    boundary: usize,
    non_manifold: usize,
    misoriented: usize,
}

impl EdgeCounts {
    /// Counts the edges of the polygons of the surface. The diagonals of the polygons are not counted, because each
    /// is used once in both directions.
    ///
    /// Edges are sorted into rows by the lower of their two vertices. Each row is short and is sorted by the
    /// higher vertex. This takes linear time for surfaces, and the order is deterministic.
    fn new(mesh: &Mesh, repeated: &Repeated) -> Self {
        let weld = mesh.weld();
        let faces = mesh.faces().enumerate().map(|(index, face)| (repeated.of(index), face));
        let faces = faces.filter(|(use_, _)| *use_ != Use::Left);
        let edges = faces.flat_map(|(use_, face)| {
            let edges = face.iter().zip(face.iter().cycle().skip(1));
            edges.map(move |(&from, &to)| if use_ == Use::Flipped { (to, from) } else { (from, to) })
        });
        let welded = edges.map(|(from, to)| (weld[from as usize], weld[to as usize]));
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
                    counts.open.extend([low as u32, (edge[0] >> 1) as u32]);
                }
            }
        }
        counts
    }
}

/// Finds the components, in descending order of their number of faces. `triangles`: of the surface. `open`: the
/// vertices of open edges.
fn components(mesh: &Mesh, triangles: &[[u32; 3]], open: &[u32]) -> Vec<Component> {
    let weld = mesh.weld();
    let (count, labels) = mesh.face_components();
    let label = |corner: u32| labels[weld[corner as usize] as usize];
    let triangles = Csr::sorted(count, triangles.iter().map(|triangle| (label(triangle[0]), *triangle)));
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
