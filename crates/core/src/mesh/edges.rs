//! Which edges are open, on a boundary, or shared by too many faces.

use super::Mesh;

/// How the edges of a welded surface are used.
#[derive(Debug, Default)]
pub(super) struct EdgeTally {
    pub(super) edges: usize,
    /// One of the two welded vertices of each edge whose directed uses do not cancel.
    pub(super) open: Vec<u32>,
    pub(super) boundary: usize,
    pub(super) non_manifold: usize,
    pub(super) misoriented: usize,
}

/// Counts the uses of each edge of the polygons. (The diagonals of a fan cancel by themselves.)
///
/// Edges are sorted into buckets by their lower vertex, then each small bucket by the higher one: linear time for
/// surfaces, and no hash order.
pub(super) fn tally(mesh: &Mesh) -> EdgeTally {
    let mut starts = vec![0_u32; mesh.vertices().len() + 1];
    for_each_edge(mesh, |low, _, _| starts[low as usize + 1] += 1);
    for vertex in 1..starts.len() {
        starts[vertex] += starts[vertex - 1];
    }
    let mut next = starts.clone();
    let mut uses = vec![0_u64; starts[starts.len() - 1] as usize];
    for_each_edge(mesh, |low, high, forward| {
        let at = &mut next[low as usize];
        uses[*at as usize] = u64::from(high) << 1 | u64::from(forward);
        *at += 1;
    });

    let mut tally = EdgeTally::default();
    for low in 0..starts.len() - 1 {
        let bucket = &mut uses[starts[low] as usize..starts[low + 1] as usize];
        bucket.sort_unstable();
        for edge in bucket.chunk_by(|a, b| a >> 1 == b >> 1) {
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

/// Calls `visit(lower vertex, higher vertex, whether it runs from lower to higher)` for each edge of each face.
fn for_each_edge(mesh: &Mesh, mut visit: impl FnMut(u32, u32, bool)) {
    let weld = mesh.weld();
    for face in mesh.faces() {
        let Some(&last) = face.last() else { continue };
        let mut from = weld[last as usize];
        for &corner in face {
            let to = weld[corner as usize];
            // An edge between equal positions has no length and no direction.
            if from != to {
                visit(from.min(to), from.max(to), from < to);
            }
            from = to;
        }
    }
}
