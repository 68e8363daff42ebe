//! Tables of the cells of a lattice.

use super::determinants::{Corners, least_determinant};
use crate::lattice::{Joint, Lattice};
use crate::mesh::Csr;
use crate::simd::vector::wide;

/// The corners of the cells of a lattice, and the cells around its vertices.
#[derive(Debug, Default)]
pub(super) struct Cells {
    /// Grid indices of the cells of the lattice for which the tables were built.
    indices: Vec<[i32; 3]>,
    /// Its broken joints.
    broken: Vec<Joint>,
    /// Vertices at the corners of each cell.
    vertices: Vec<[u32; 8]>,
    /// The corners of cells at each vertex: 8 times the cell, plus the number of the corner.
    around: Csr<u32>,
}

impl Cells {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let cells = size_of_val(&*self.indices) + size_of_val(&*self.vertices);
        cells + size_of_val(&*self.broken) + self.around.bytes()
    }

    /// Builds the tables of a lattice, if they are of another lattice.
    pub(super) fn prepare(&mut self, lattice: &Lattice) {
        if self.indices == lattice.cells() && self.broken == lattice.broken_joints() {
            return;
        }
        self.broken.clear();
        self.broken.extend_from_slice(lattice.broken_joints());
        self.indices.clear();
        self.indices.extend_from_slice(lattice.cells());
        self.vertices.clear();
        self.vertices.extend(lattice.corner_table().iter());
        let corners = (0..).zip(self.vertices.as_flattened()).map(|(corner, &vertex)| (vertex, corner));
        self.around = Csr::sorted(lattice.len(), corners);
    }

    /// Returns the number of cells.
    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Returns the number of vertices.
    pub(super) fn vertex_count(&self) -> usize {
        self.around.len()
    }

    /// Returns the vertices at the corners of a cell.
    pub(super) fn vertices(&self, cell: u32) -> &[u32; 8] {
        &self.vertices[cell as usize]
    }

    /// Returns the positions of the corners of a cell.
    pub(super) fn corners(&self, cell: u32, positions: &[[f32; 3]]) -> Corners {
        self.vertices(cell).map(|vertex| wide(positions[vertex as usize]))
    }

    /// Returns the least determinant of a cell.
    pub(super) fn least_determinant(&self, cell: u32, positions: &[[f32; 3]]) -> f64 {
        least_determinant(&self.corners(cell, positions))
    }

    /// Iterates over the cells around a vertex, with the number of the corner that the vertex is in each cell.
    pub(super) fn around(&self, vertex: u32) -> impl ExactSizeIterator<Item = (u32, usize)> + '_ {
        self.around.row(vertex as usize).iter().map(|corner| (corner / 8, (corner % 8) as usize))
    }
}
