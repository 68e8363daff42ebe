//! Tables of the neighbors of all vertices, and of the corners of all cells.

use std::borrow::Cow;

use super::Lattice;
use super::charts::NO_NEIGHBOR;

impl Lattice {
    /// Returns the neighbors of each vertex at -x, +x, -y, +y, -z, +z; a missing neighbor is replaced by the vertex
    /// itself.
    pub(crate) fn neighbor_table(&self) -> Vec<[u32; 6]> {
        let mut table: Vec<[u32; 6]> = (0..self.len() as u32).map(|vertex| [vertex; 6]).collect();
        if let Some(broken) = &self.broken {
            for (row, neighbors) in table.iter_mut().zip(&broken.neighbors) {
                for (entry, &other) in
                    row.iter_mut().zip(neighbors).filter(|(_, other)| **other != NO_NEIGHBOR)
                {
                    *entry = other;
                }
            }
            return table;
        }
        // The vertices are sorted by (z, y, x), and so are their neighbors along an axis.
        let order = |[x, y, z]: [i32; 3]| (z, y, x);
        for axis in 0..3 {
            let mut next = 0;
            for (vertex, (index, links)) in self.indices.iter().zip(&self.links).enumerate() {
                if links >> (2 * axis + 1) & 1 != 0 {
                    let mut target = *index;
                    target[axis] += 1;
                    while order(self.indices[next]) < order(target) {
                        next += 1;
                    }
                    table[vertex][2 * axis + 1] = next as u32;
                    table[next][2 * axis] = vertex as u32;
                }
            }
        }
        table
    }

    /// Returns the vertices at the corners of each cell: [`Lattice::cell_corners`] of all cells, without searches.
    pub(crate) fn corner_table(&self) -> Cow<'_, [[u32; 8]]> {
        if let Some(broken) = &self.broken {
            return Cow::Borrowed(&broken.corners);
        }
        Cow::Owned(self.corners_by(&self.neighbor_table()))
    }

    /// Returns the [`Lattice::corner_table`] of a lattice without broken joints, given its [`Lattice::neighbor_table`].
    pub(super) fn corners_by(&self, neighbors: &[[u32; 6]]) -> Vec<[u32; 8]> {
        self.first_corners().map(|first| corners_from(first, neighbors)).collect()
    }

    /// Iterates over corner 0 of each cell of a lattice without broken joints.
    pub(crate) fn first_corners(&self) -> impl Iterator<Item = u32> {
        // Cells are sorted as the vertices are, and corner 0 has the index of the cell.
        let mut vertices = (0..).zip(&self.indices);
        self.cells.iter().map(move |cell| {
            vertices.find(|(_, index)| *index == cell).expect("corner 0 of each cell is a vertex").0
        })
    }
}

/// Returns the corners of a cell of a lattice without broken joints, given its corner 0 and the
/// [`Lattice::neighbor_table`].
pub(crate) fn corners_from(first: u32, neighbors: &[[u32; 6]]) -> [u32; 8] {
    let next = |vertex: u32, axis: usize| neighbors[vertex as usize][2 * axis + 1];
    let (along_y, along_z) = (next(first, 1), next(first, 2));
    let rows = [first, along_y, along_z, next(along_y, 2)];
    // The next vertex along x has the next number.
    std::array::from_fn(|corner| rows[corner / 2] + (corner % 2) as u32)
}
