//! Finds the one-ring of a vertex: the neighbors of the vertex in order around it.

use crate::mesh::Csr;

/// Computes the one-rings of the vertices of a surface from the edges opposite to each vertex.
///
/// The *one-ring* of a vertex v lists, for each triangle at v, the two other corners in order. A corner
/// shared by two consecutive triangles is listed once. Between triangles that do not share an edge, v itself
/// is listed:
///
/// ```text
///       c---b
///      / \ / \            closed: a b c d e f a
///     d---v---a           without the triangles v c d and v f a: a b c v d e f
///      \ / \ /
///       e---f
/// ```
///
/// Each pair of consecutive entries that does not contain v forms a triangle with v.
pub(super) struct OneRings {
    /// For each vertex, the opposite edge of each triangle at the vertex.
    edges: Csr<[u32; 2]>,
    /// Scratch of [`OneRings::append`]: the sorted end vertices of the edges.
    ends: Vec<u32>,
    /// Scratch of [`OneRings::append`]: the number of edges with the same start vertex that were used so far,
    /// at the index of the first such edge.
    used: Vec<u32>,
}

impl OneRings {
    /// Prepares the one-rings of the vertices `0..count`. Triangles with two equal corners are ignored.
    pub(super) fn new(triangles: impl Iterator<Item = [u32; 3]> + Clone, count: usize) -> Self {
        let edges = triangles
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .flat_map(|[a, b, c]| [(a, [b, c]), (b, [c, a]), (c, [a, b])]);
        Self { edges: Csr::sorted(count, edges), ends: Vec::new(), used: Vec::new() }
    }

    /// Appends the one-ring of a vertex to `ring`.
    pub(super) fn append(&mut self, vertex: u32, ring: &mut Vec<u32>) {
        let Self { edges, ends, used } = self;
        let edges = edges.row_mut(vertex as usize);
        edges.sort_unstable();
        ends.clear();
        ends.extend(edges.iter().map(|edge| edge[1]));
        ends.sort_unstable();
        used.clear();
        used.resize(edges.len(), 0);

        let first = ring.len();
        // Returns the end of the next unused edge that starts at a vertex.
        let mut follow = |start: u32| {
            let group = edges.partition_point(|edge| edge[0] < start);
            let edge = edges.get(group + *used.get(group)? as usize).filter(|edge| edge[0] == start)?;
            used[group] += 1;
            Some(edge[1])
        };
        // Open fans come first. They start at vertices where no edge ends. The remaining edges form closed
        // rings.
        let open = edges.iter().map(|edge| edge[0]).filter(|start| ends.binary_search(start).is_err());
        for start in open.chain(edges.iter().map(|edge| edge[0])) {
            let Some(mut at) = follow(start) else { continue };
            if ring.len() > first {
                ring.push(vertex);
            }
            ring.extend([start, at]);
            while let Some(next) = follow(at) {
                ring.push(next);
                at = next;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(triangles: &[[u32; 3]]) -> Vec<u32> {
        let mut ring = Vec::new();
        OneRings::new(triangles.iter().copied(), 20).append(0, &mut ring);
        ring
    }

    #[test]
    fn append_lists_closed_open_and_separate_fans() {
        assert_eq!(ring(&[[0, 3, 1], [1, 2, 0], [2, 3, 0]]), [1, 2, 3, 1]);
        assert_eq!(ring(&[[0, 2, 3], [0, 1, 2]]), [1, 2, 3]);
        assert_eq!(ring(&[[0, 5, 6], [0, 2, 3], [0, 1, 2]]), [1, 2, 3, 0, 5, 6]);
        assert_eq!(ring(&[[0, 1, 2], [0, 2, 1], [0, 5, 5], [7, 8, 9]]), [1, 2, 1]);
        // Two closed rings through one vertex, and a repeated triangle.
        assert_eq!(ring(&[[0, 1, 2], [0, 2, 1], [0, 1, 3], [0, 3, 1]]), [1, 2, 1, 3, 1]);
        assert_eq!(ring(&[[0, 1, 2], [0, 1, 2]]), [1, 2, 0, 1, 2]);
        assert_eq!(ring(&[]), [0; 0]);
    }
}
