//! Walks around the vertices of a surface.

/// The edges opposite to each vertex, to be walked along: the *ring* of a vertex lists, for each triangle at it, the
/// two other corners in order; what one triangle shares with the next is listed once. Where triangles at a vertex have
/// no edge in common, the vertex itself stands between them:
///
/// ```text
///       c---b
///      / \ / \            closed: a b c d e f a
///     d---v---a           without the triangles v c d and v f a: a b c v d e f
///      \ / \ /
///       e---f
/// ```
///
/// So the triangles of a ring are `v` and two entries that follow each other, those that `v` is one of left out.
pub(super) struct Walks {
    /// Edges of vertex `v`: `edges[starts[v]..starts[v + 1]]`.
    starts: Vec<u32>,
    edges: Vec<[u32; 2]>,
    /// Of the vertex at hand: ends of its edges, sorted, and of those edges that begin alike how many were walked.
    ends: Vec<u32>,
    walked: Vec<u32>,
}

impl Walks {
    /// The walks of vertices with numbers below `count`. Triangles with a corner twice have no area and are left out.
    pub(super) fn new(triangles: impl Iterator<Item = [u32; 3]> + Clone, count: usize) -> Self {
        let corners = triangles
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .flat_map(|[a, b, c]| [(a, [b, c]), (b, [c, a]), (c, [a, b])]);
        let mut starts = vec![0_u32; count + 1];
        for (vertex, _) in corners.clone() {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..count {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut edges = vec![[0; 2]; starts[count] as usize];
        for (vertex, edge) in corners {
            let at = &mut next[vertex as usize];
            edges[*at as usize] = edge;
            *at += 1;
        }
        Self { starts, edges, ends: Vec::new(), walked: Vec::new() }
    }

    /// Appends the ring of a vertex to `ring`.
    pub(super) fn walk(&mut self, vertex: u32, ring: &mut Vec<u32>) {
        let Self { starts, edges, ends, walked } = self;
        let edges = &mut edges[starts[vertex as usize] as usize..starts[vertex as usize + 1] as usize];
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
        Walks::new(triangles.iter().copied(), 20).walk(0, &mut ring);
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
