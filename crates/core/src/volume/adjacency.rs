//! The links of a lattice as a table.

/// Steps along the axes in neighbour order.
pub(super) const DIRECTIONS: [[i32; 3]; 6] =
    [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];

/// Who is linked to whom, and which component each vertex is in.
#[derive(Clone, Debug)]
pub(super) struct Adjacency {
    /// Neighbours of each vertex in neighbour order; the vertex itself where one is missing.
    rows: Vec<[u32; 6]>,
    component: Vec<u32>,
    components: usize,
}

impl Adjacency {
    pub(super) fn new(rows: Vec<[u32; 6]>, component: Vec<u32>, components: usize) -> Self {
        Self { rows, component, components }
    }

    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.rows) + size_of_val(&*self.component)
    }

    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn rows(&self) -> &[[u32; 6]] {
        &self.rows
    }

    pub(super) fn components(&self) -> usize {
        self.components
    }

    pub(super) fn component(&self, i: usize) -> usize {
        self.component[i] as usize
    }

    /// The component of each vertex.
    pub(super) fn of_vertex(&self) -> &[u32] {
        &self.component
    }

    pub(super) fn has(&self, i: usize, side: usize) -> bool {
        self.rows[i][side] as usize != i
    }

    /// The neighbours that exist, in neighbour order.
    pub(super) fn linked(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.rows[i].iter().map(|&j| j as usize).filter(move |&j| j != i)
    }

    /// Links on the shortest way from each vertex to the nearest of `sources`; `u32::MAX` where there is no way.
    pub(super) fn distances(&self, sources: impl Iterator<Item = usize>) -> Vec<u32> {
        let mut distance = vec![u32::MAX; self.len()];
        let mut queue = Vec::new();
        for source in sources {
            if distance[source] != 0 {
                distance[source] = 0;
                queue.push(source);
            }
        }
        let mut next = 0;
        while let Some(&i) = queue.get(next) {
            next += 1;
            for j in self.linked(i) {
                if distance[j] == u32::MAX {
                    distance[j] = distance[i] + 1;
                    queue.push(j);
                }
            }
        }
        distance
    }
}
