//! Tables of the neighbors of all vertices, of the corners of all cells, and of their faces.

use std::borrow::Cow;

use super::Lattice;
use super::charts::NO_NEIGHBOR;
use crate::voxel::step;

/// Corners of each face of a cell, counter-clockwise seen from outside; the faces are those at -x, +x, -y,
/// +y, -z, +z.
///
/// ```text
///        6-----7      corner k lies at (k & 1, k >> 1 & 1, k >> 2 & 1)
///       /|    /|
///      4-----5 |      z  y
///      | 2---|-3      | /
///      |/    |/       |/
///      0-----1        +--- x
/// ```
pub(crate) const FACE_CORNERS: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

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
                    let target = order(step(*index, axis, 1));
                    while order(self.indices[next]) < target {
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

    /// Returns the boundary faces: the faces of cells that belong to one cell only, by cell. Each has the index of its side
    /// of the cell, as in [`FACE_CORNERS`], and its corners, counter-clockwise seen from outside.
    pub(crate) fn boundary_faces(&self) -> impl Iterator<Item = (usize, [u32; 4])> {
        (0..self.cells().len() as u32).flat_map(move |cell| {
            let corners = self.cell_corners(cell);
            let outer = FACE_CORNERS
                .iter()
                .enumerate()
                .filter(move |(side, _)| self.joined_cell(cell, *side).is_none());
            outer.map(move |(side, face)| (side, face.map(|corner| corners[corner])))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(k: usize) -> [f64; 3] {
        [(k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2 & 1) as f64]
    }

    #[test]
    fn face_corners_are_counter_clockwise_from_outside() {
        for (side, corners) in FACE_CORNERS.iter().enumerate() {
            let [a, b, _, d] = corners.map(corner);
            let (u, v): ([f64; 3], [f64; 3]) =
                (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| d[k] - a[k]));
            let normal: [f64; 3] =
                std::array::from_fn(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
            let mut expected = [0.0; 3];
            expected[side / 2] = if side % 2 == 0 { -1.0 } else { 1.0 };
            assert_eq!(normal, expected, "side {side}");
        }
    }
}
