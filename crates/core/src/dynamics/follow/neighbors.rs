//! Chooses the mesh vertices whose motion each lattice vertex of a handle follows.

use crate::lattice::{Embedding, Lattice};
use crate::mesh::{Csr, Mesh};

/// Number of mesh vertices that a lattice vertex follows, if its component has as many.
const NEAREST: usize = 16;

/// Returns, for each lattice vertex in `held`, the mesh vertices of `part` that it follows, the nearest first. Both are
/// in increasing order.
///
/// Of each eighth of a cell at most one mesh vertex is used, so that the neighbors of a lattice vertex surround it
/// however fine the mesh is. The neighbors are found along the links of the lattice, so that a lattice vertex does not
/// follow a part of the mesh beyond a gap.
pub(super) fn neighbors(
    lattice: &Lattice,
    mesh: &Mesh,
    embedding: &Embedding,
    part: &[u32],
    held: &[u32],
) -> Csr<u32> {
    let points = spaced_points(mesh, embedding, part);
    let found = points_by_links(lattice, embedding, &points, held);
    let (mut starts, mut items) = (vec![0], Vec::new());
    for &vertex in held {
        let position = lattice.rest_position(vertex);
        // A component without a vertex of the part follows the whole part.
        let list = Some(&found[vertex as usize]).filter(|list| !list.is_empty()).unwrap_or(&points);
        let distance = |&point: &u32| (mesh.vertices()[point as usize] - position).norm_squared();
        let mut list: Vec<(f64, u32)> = list.iter().map(|point| (distance(point), *point)).collect();
        list.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        items.extend(list.iter().take(NEAREST).map(|(_, point)| *point));
        starts.push(items.len() as u32);
    }
    Csr::from_parts(starts, items)
}

/// Returns the mesh vertex of `part` nearest to the center of each eighth of a cell, in increasing order. Vertices that
/// no face uses count only if there are no others.
fn spaced_points(mesh: &Mesh, embedding: &Embedding, part: &[u32]) -> Vec<u32> {
    let mut is_used = vec![false; mesh.vertices().len()];
    mesh.faces().flatten().for_each(|&vertex| is_used[vertex as usize] = true);
    let any_used = part.iter().any(|&vertex| is_used[vertex as usize]);
    let candidate = |&vertex: &u32| {
        let local = embedding.local(vertex as usize);
        let eighth = local.map(|x| x >= 0.5);
        let offsets = [0, 1, 2].map(|axis| local[axis] - if eighth[axis] { 0.75 } else { 0.25 });
        let distance: f32 = offsets.iter().map(|x| x * x).sum();
        (embedding.cell(vertex as usize), eighth, distance, vertex)
    };
    let used = part.iter().filter(|&&vertex| is_used[vertex as usize] || !any_used);
    let mut candidates: Vec<_> = used.map(candidate).collect();
    candidates
        .sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)).then(a.3.cmp(&b.3)));
    candidates.dedup_by_key(|&mut (cell, eighth, ..)| (cell, eighth));
    let mut points: Vec<u32> = candidates.into_iter().map(|(.., vertex)| vertex).collect();
    points.sort_unstable();
    points
}

/// Returns, for each lattice vertex, the points that reach it from the corners of their cells along the fewest links,
/// at least [`NEAREST`] for the vertices in `held` if their components have as many.
fn points_by_links(lattice: &Lattice, embedding: &Embedding, points: &[u32], held: &[u32]) -> Vec<Vec<u32>> {
    let mut found = vec![Vec::new(); lattice.len()];
    let corners = |&point: &u32| embedding.corners(point as usize).map(|vertex| (vertex, point));
    let mut wave: Vec<(u32, u32)> = points.iter().flat_map(corners).collect();
    let mut accepted: Vec<(u32, u32)> = Vec::new();
    while !wave.is_empty() && held.iter().any(|&vertex| found[vertex as usize].len() < NEAREST) {
        wave.sort_unstable();
        wave.dedup();
        accepted.clear();
        // A vertex that had too few points before this wave takes all points of the wave.
        for arrivals in wave.chunk_by(|a, b| a.0 == b.0) {
            let list: &mut Vec<u32> = &mut found[arrivals[0].0 as usize];
            if list.len() < NEAREST {
                let first = accepted.len();
                accepted.extend(arrivals.iter().filter(|(_, point)| !list.contains(point)));
                list.extend(accepted[first..].iter().map(|(_, point)| *point));
            }
        }
        wave.clear();
        for arrivals in accepted.chunk_by(|a, b| a.0 == b.0) {
            for next in lattice.neighbors(arrivals[0].0).into_iter().flatten() {
                if found[next as usize].len() < NEAREST {
                    wave.extend(arrivals.iter().map(|&(_, point)| (next, point)));
                }
            }
        }
    }
    found
}
