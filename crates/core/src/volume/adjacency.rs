//! Builds tables of a lattice: links, corners of its cells, occupied cells around each vertex.
//!
//! A link is an edge of the lattice: it connects a vertex with a neighbor along an axis.

use crate::lattice::{Lattice, corners_from};

/// Unit steps along the axes, in *neighbor order*: -x, +x, -y, +y, -z, +z.
pub(super) const DIRECTIONS: [[i32; 3]; 6] =
    [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];

/// Links of a lattice, and the component of each vertex.
#[derive(Clone, Debug)]
pub(super) struct Adjacency {
    /// Neighbors of each vertex in neighbor order; a missing neighbor is replaced by the vertex itself.
    pub(super) neighbors: Vec<[u32; 6]>,
    /// Component of each vertex.
    pub(super) component_of_vertex: Vec<u32>,
    /// Number of components.
    pub(super) component_count: usize,
}

impl Adjacency {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let components = lattice.components();
        let neighbors = lattice.neighbor_table();
        Self {
            neighbors,
            component_of_vertex: components.of_vertex.clone(),
            component_count: components.count,
        }
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.neighbors) + size_of_val(&*self.component_of_vertex)
    }

    /// Returns the number of vertices.
    pub(super) fn len(&self) -> usize {
        self.neighbors.len()
    }

    /// Returns the component of vertex `i`.
    pub(super) fn component(&self, i: usize) -> usize {
        self.component_of_vertex[i] as usize
    }

    /// Returns the components of consecutive vertices, in runs of vertices of one component.
    pub(super) fn runs(&self) -> impl Iterator<Item = &[u32]> {
        self.component_of_vertex.chunk_by(|a, b| a == b)
    }

    /// Returns whether vertex `i` has a neighbor on `side`, an index in neighbor order.
    pub(super) fn has_neighbor(&self, i: usize, side: usize) -> bool {
        self.neighbors[i][side] as usize != i
    }

    /// Returns the existing neighbors of vertex `i`, in neighbor order.
    pub(super) fn linked(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        self.neighbors[i].iter().map(|&j| j as usize).filter(move |&j| j != i)
    }

    /// Returns, for each vertex, the number of links on the shortest path to a source; `u32::MAX` if there is
    /// no path.
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

/// The corners of the cells of a lattice.
pub(super) enum Corners<'a> {
    /// Corner 0 of each cell; the others follow from the links.
    First(Vec<u32>, &'a Adjacency),
    /// Joints of the lattice are broken, so that a link can lead to another copy of a vertex.
    Broken(&'a Lattice),
}

impl<'a> Corners<'a> {
    pub(super) fn new(lattice: &'a Lattice, adjacency: &'a Adjacency) -> Self {
        if !lattice.broken_joints().is_empty() {
            return Self::Broken(lattice);
        }
        Self::First(lattice.first_corners().collect(), adjacency)
    }

    /// Returns the vertices at the corners of a cell.
    pub(super) fn of_cell(&self, cell: u32) -> [u32; 8] {
        match self {
            Self::First(first, adjacency) => corners_from(first[cell as usize], &adjacency.neighbors),
            Self::Broken(lattice) => lattice.cell_corners(cell),
        }
    }

    /// Iterates over the corners of all cells.
    pub(super) fn iter(&self) -> impl Iterator<Item = [u32; 8]> + '_ {
        let cells = match self {
            Self::First(first, _) => first.len(),
            Self::Broken(lattice) => lattice.cells().len(),
        };
        (0..cells as u32).map(|cell| self.of_cell(cell))
    }
}

/// Returns a bit mask of the occupied cells around each vertex: bit `k` is set iff the cell in octant `k`
/// exists.
///
/// Octant `k` around a vertex lies in the direction `(k & 1, k >> 1 & 1, k >> 2 & 1)`, where 0 is the
/// negative side of an axis and 1 the positive side. `vertices`: number of vertices.
pub(super) fn octants(vertices: usize, corners: &Corners) -> Vec<u8> {
    let mut octants = vec![0; vertices];
    for cell in corners.iter() {
        for (corner, vertex) in cell.into_iter().enumerate() {
            // Seen from corner `k` of a cell, the cell lies in the octant of the opposite corner, `7 - k`.
            octants[vertex as usize] |= 1 << (7 - corner);
        }
    }
    octants
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn tables_agree_with_the_lattice() {
        // A box with a slit, whose two sides are not linked, and a separate cell.
        let mut cells: Vec<[i32; 3]> = (0..60).map(|i| [i % 5, i / 5 % 4, i / 20]).collect();
        cells.retain(|cell| *cell != [2, 1, 1] && *cell != [4, 3, 0]);
        cells.push([9, 0, 2]);
        let lattice = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
        let adjacency = Adjacency::new(&lattice);
        for vertex in 0..lattice.len() as u32 {
            let expected = lattice.neighbors(vertex).map(|other| other.unwrap_or(vertex));
            assert_eq!(adjacency.neighbors[vertex as usize], expected);
        }
        for (cell, first) in (0..).zip(lattice.first_corners()) {
            assert_eq!(corners_from(first, &adjacency.neighbors), lattice.cell_corners(cell));
        }
    }
}
