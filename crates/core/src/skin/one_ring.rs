//! The one-ring of a vertex: the vertices around it, in order.

use crate::mesh::Csr;

/// The edges opposite to each vertex, from which its one-ring is found. The *one-ring* of a vertex lists, for each triangle at it,
/// the two other corners in order; a corner that one triangle shares with the next is listed once. Where triangles at a vertex
/// have no edge in common, the vertex itself stands between them:
///
/// ```text
///       c---b
///      / \ / \            closed: a b c d e f a
///     d---v---a           without the triangles v c d and v f a: a b c v d e f
///      \ / \ /
///       e---f
/// ```
///
/// So the triangles of a one-ring are `v` and two entries that follow each other, those that `v` is one of left out.
pub(super) struct OneRings {
    /// The edges of each vertex.
    edges: Csr<[u32; 2]>,
    /// Scratch of [`OneRings::append`]: ends of the vertex's edges, sorted, and of edges that begin alike how many were walked.
    ends: Vec<u32>,
    walked: Vec<u32>,
}

impl OneRings {
    /// The one-rings of vertices with numbers below `count`. Triangles with a corner twice have no area and are left out.
    pub(super) fn new(triangles: impl Iterator<Item = [u32; 3]> + Clone, count: usize) -> Self {
        let edges = triangles
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .flat_map(|[a, b, c]| [(a, [b, c]), (b, [c, a]), (c, [a, b])]);
        Self { edges: Csr::sorted(count, edges), ends: Vec::new(), walked: Vec::new() }
    }

    /// Appends the one-ring of a vertex to `ring`.
    pub(super) fn append(&mut self, vertex: u32, ring: &mut Vec<u32>) {
        let Self { edges, ends, walked } = self;
        let edges = edges.row_mut(vertex as usize);
        edges.sort_unstable();
        ends.clear();
        ends.extend(edges.iter().map(|edge| edge[1]));
        ends.sort_unstable();
        walked.clear();
        walked.resize(edges.len(), 0);

        let first = ring.len();
        // The next edge from a vertex that was not walked along yet.
        let mut follow = |from: u32| {
            let group = edges.partition_point(|edge| edge[0] < from);
            let edge = edges.get(group + *walked.get(group)? as usize).filter(|edge| edge[0] == from)?;
            walked[group] += 1;
            Some(edge[1])
        };
        // Walks that nothing leads into come first; what is left are closed ones.
        let open = edges.iter().map(|edge| edge[0]).filter(|from| ends.binary_search(from).is_err());
        for from in open.chain(edges.iter().map(|edge| edge[0])) {
            let Some(mut at) = follow(from) else { continue };
            if ring.len() > first {
                ring.push(vertex);
            }
            ring.extend([from, at]);
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
    fn closed_open_and_apart() {
        assert_eq!(ring(&[[0, 3, 1], [1, 2, 0], [2, 3, 0]]), [1, 2, 3, 1]);
        assert_eq!(ring(&[[0, 2, 3], [0, 1, 2]]), [1, 2, 3]);
        assert_eq!(ring(&[[0, 5, 6], [0, 2, 3], [0, 1, 2]]), [1, 2, 3, 0, 5, 6]);
        assert_eq!(ring(&[[0, 1, 2], [0, 2, 1], [0, 5, 5], [7, 8, 9]]), [1, 2, 1]);
        // Two closed rings through one vertex, and a triangle that is there twice.
        assert_eq!(ring(&[[0, 1, 2], [0, 2, 1], [0, 1, 3], [0, 3, 1]]), [1, 2, 1, 3, 1]);
        assert_eq!(ring(&[[0, 1, 2], [0, 1, 2]]), [1, 2, 0, 1, 2]);
        assert_eq!(ring(&[]), [0; 0]);
    }
}
