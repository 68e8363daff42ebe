//! What `inspect` says about a surface: found once, kept with the mesh.

use super::{Csr, Mesh, UnionFind, duplicates, is_degenerate};

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
    /// Enclosed volume in cubed units of length, about the center of the bounds; negative if flipped.
    pub signed_volume: f64,
}

/// A part of a surface that shares no (welded) vertex with the rest.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Component {
    /// Its first face, from 0.
    pub first_face: usize,
    /// How many faces it has.
    pub faces: usize,
    /// Whether it encloses a volume.
    pub closed: bool,
    /// Volume that it encloses, about the center of the whole mesh; negative if its faces look inwards.
    pub signed_volume: f64,
}

impl Topology {
    /// Whether most faces run clockwise seen from outside, so that the volume comes out negative.
    pub fn is_flipped(&self) -> bool {
        self.open_edges == 0 && self.signed_volume < 0.0
    }

    pub(super) fn of(mesh: &Mesh) -> Self {
        let weld = mesh.weld();
        let edges = EdgeTally::of(mesh);
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

/// How the edges of a welded surface are used.
#[derive(Debug, Default)]
struct EdgeTally {
    edges: usize,
    /// One of the two welded vertices of each edge whose directed uses do not cancel.
    open: Vec<u32>,
    boundary: usize,
    non_manifold: usize,
    misoriented: usize,
}

impl EdgeTally {
    /// Counts the uses of each edge of the polygons. (The diagonals of a fan cancel by themselves.)
    ///
    /// Edges are sorted into rows by their lower vertex, then each small row by the higher one: linear time for
    /// surfaces, and no hash order.
    fn of(mesh: &Mesh) -> Self {
        let weld = mesh.weld();
        let edges = mesh.faces().flat_map(|face| face.iter().zip(face.iter().cycle().skip(1)));
        let welded = edges.map(|(&from, &to)| (weld[from as usize], weld[to as usize]));
        // An edge between equal positions has no length and no direction.
        let uses = welded
            .filter(|(from, to)| from != to)
            .map(|(from, to)| (from.min(to), u64::from(from.max(to)) << 1 | u64::from(from < to)));
        let mut uses = Csr::sorted(weld.len(), uses);
        let mut tally = Self::default();
        for low in 0..uses.len() {
            let row = uses.row_mut(low);
            row.sort_unstable();
            for edge in row.chunk_by(|a, b| a >> 1 == b >> 1) {
                let forward = edge.iter().filter(|&use_| use_ & 1 == 1).count();
                tally.edges += 1;
                tally.boundary += usize::from(edge.len() == 1);
                tally.non_manifold += usize::from(edge.len() > 2);
                tally.misoriented += usize::from(edge.len() == 2 && forward != 1);
                if 2 * forward != edge.len() {
                    tally.open.push(low as u32);
                }
            }
        }
        tally
    }
}

/// The components, most faces first; `open` holds a vertex of each open edge.
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
    let component = |own: &[[u32; 3]]| Component {
        first_face: usize::MAX,
        faces: 0,
        closed: true,
        signed_volume: mesh.volume_of(own),
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
    // Vertices that no face uses are sets of their own.
    components.retain(|component| component.faces > 0);
    components.sort_by_key(|component| (usize::MAX - component.faces, component.first_face));
    components
}
