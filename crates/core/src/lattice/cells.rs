//! The cells, vertices and links of a lattice.

use nalgebra::Point3;

use super::broken::Broken;
use super::charts::NO_NEIGHBOR;
use super::components::Components;
use super::options::LatticeReport;
use crate::voxel::{GridSet, beside};

/// Lattice vertices on the corners of cubic cells, linked along the edges of the cells.
///
/// Vertices and cells have integer grid indices `[x, y, z]` and are numbered in the order of (z, y, x), x
/// fastest. This is the *vertex order* of every array with one entry per lattice vertex. The rest position of
/// a vertex is `origin + cell_size * index`. The cell of index `c` extends from vertex `c` to vertex
/// `c + (1, 1, 1)`. Its corner k is at the offset `(k & 1, k >> 1 & 1, k >> 2 & 1)`:
///
/// ```text
///        6-------7        z
///       /|      /|        |  y
///      4-------5 |        | /
///      | 2-----|-3        |/
///      |/      |/         +----- x
///      0-------1
/// ```
///
/// A *link* joins two vertices that are one cell size apart along an axis iff the segment between them is an
/// edge of an occupied cell. Two vertices on opposite sides of a gap are not neighbors, however close they
/// are.
///
/// Where a body breaks, its lattice gets broken [joints](super::Joint). Several vertices can then have the same grid
/// index. They follow the others in the vertex order ([`Lattice::whole_len`]).
///
/// Rivers & James 2007 put the particles at the centers of the cells. Here the vertices are at the corners.
/// Each vertex is then a corner of at least one cell, so that every region spans three dimensions even where
/// the shape is one cell thick.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    pub(super) cell_size: f64,
    pub(super) origin: Point3<f64>,
    pub(super) indices: Vec<[i32; 3]>,
    pub(super) vertex_set: GridSet,
    pub(super) links: Vec<u8>,
    pub(super) occupied_cells: Vec<u8>,
    pub(super) cells: Vec<[i32; 3]>,
    pub(super) cell_set: GridSet,
    pub(super) components: Components,
    pub(super) report: LatticeReport,
    /// `None` if no joint is broken.
    pub(super) broken: Option<Box<Broken>>,
}

impl Lattice {
    /// Returns the number of lattice vertices, at least 8.
    pub fn len(&self) -> usize {
        self.indices.len()
    }

    /// Returns false: a lattice has at least one cell.
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// Returns the edge length of a cell, in the length unit of the scene.
    pub fn cell_size(&self) -> f64 {
        self.cell_size
    }

    /// Returns the position of the grid index `[0, 0, 0]` of vertices, in the model frame.
    pub fn origin(&self) -> Point3<f64> {
        self.origin
    }

    /// Returns the grid indices `[x, y, z]` of the vertices, shape `(n, 3)`, sorted by (z, y, x).
    pub fn indices(&self) -> &[[i32; 3]] {
        &self.indices
    }

    /// Returns the rest position of a vertex in the model frame: `origin + cell_size * index`.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    pub fn rest_position(&self, vertex: u32) -> Point3<f64> {
        let [x, y, z] = self.indices[vertex as usize].map(f64::from);
        self.origin + nalgebra::Vector3::new(x, y, z) * self.cell_size
    }

    /// Returns the grid indices `[x, y, z]` of the cells, shape `(m, 3)`, sorted by (z, y, x). The index of a
    /// cell is the index of its corner 0.
    pub fn cells(&self) -> &[[i32; 3]] {
        &self.cells
    }

    /// Returns the vertices at the eight corners of a cell, in the order of the drawing at [`Lattice`].
    ///
    /// # Panics
    ///
    /// If there is no such cell.
    pub fn cell_corners(&self, cell: u32) -> [u32; 8] {
        if let Some(broken) = &self.broken {
            return broken.corners[cell as usize];
        }
        let [x, y, z] = self.cells[cell as usize];
        let mut corners = [0; 8];
        for (pair, corner) in corners.chunks_exact_mut(2).enumerate() {
            let (dy, dz) = (pair as i32 & 1, pair as i32 >> 1);
            let first = self.vertex_set.find([x, y + dy, z + dz]).expect("each corner of a cell is a vertex");
            // The next vertex along x has the next number.
            corner.copy_from_slice(&[first, first + 1]);
        }
        corners
    }

    /// Returns the vertex at corner 0 of a cell.
    pub(crate) fn first_corner(&self, cell: u32) -> u32 {
        match &self.broken {
            Some(broken) => broken.corners[cell as usize][0],
            None => {
                self.vertex_set.find(self.cells[cell as usize]).expect("corner 0 of each cell is a vertex")
            }
        }
    }

    /// Returns the vertex at a grid index, if there is one; of several, the one with the lowest number.
    pub fn vertex_at(&self, index: [i32; 3]) -> Option<u32> {
        self.vertex_set.find(index)
    }

    /// Returns the occupied cell at a grid index, if there is one.
    pub fn cell_at(&self, index: [i32; 3]) -> Option<u32> {
        self.cell_set.find(index)
    }

    /// Returns the occupied cell in an octant around a grid index of vertices, if there is one. Octant `k` lies in the
    /// direction `(k & 1, k >> 1 & 1, k >> 2 & 1)`, where 0 is the negative side of an axis: a vertex at `index` is
    /// corner `7 - k` of the cell.
    pub(crate) fn cell_around(&self, index: [i32; 3], octant: usize) -> Option<u32> {
        self.cell_at(std::array::from_fn(|a| index[a] - 1 + (octant >> a & 1) as i32))
    }

    /// Returns the links of each vertex as a bit mask, shape `(n,)`. Bits 0 to 5 are set iff the vertex is
    /// linked to its neighbor at -x, +x, -y, +y, -z, +z.
    pub fn links(&self) -> &[u8] {
        &self.links
    }

    /// Returns the vertices to which a vertex is linked, in the order -x, +x, -y, +y, -z, +z.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    pub fn neighbors(&self, vertex: u32) -> [Option<u32>; 6] {
        if let Some(broken) = &self.broken {
            return broken.neighbors[vertex as usize].map(|other| (other != NO_NEIGHBOR).then_some(other));
        }
        let index = self.indices[vertex as usize];
        let links = self.links[vertex as usize];
        std::array::from_fn(|n| match n {
            _ if links >> n & 1 == 0 => None,
            0 => Some(vertex - 1),
            1 => Some(vertex + 1),
            _ => self.vertex_set.find(beside(index, n)),
        })
    }

    /// Returns the number of occupied cells that have each vertex as a corner, 1 to 8, shape `(n,)`.
    ///
    /// In a bare lattice, the mass of a vertex is `density * cell_size^3 * occupied_cells / 8`.
    pub fn occupied_cells(&self) -> &[u8] {
        &self.occupied_cells
    }

    /// Returns the connected components of the link graph.
    pub fn components(&self) -> &Components {
        &self.components
    }

    /// Returns the report on the construction: numbers of cells, floating parts, glued mesh components,
    /// openings of the mesh.
    pub fn report(&self) -> &LatticeReport {
        &self.report
    }

    /// Returns the memory of the lattice, in bytes.
    pub fn memory(&self) -> usize {
        let vertex = size_of::<[i32; 3]>() + 2 * size_of::<u8>() + size_of::<u32>();
        self.len() * vertex
            + self.cells.len() * size_of::<[i32; 3]>()
            + self.vertex_set.bytes()
            + self.cell_set.bytes()
            + self.broken.as_ref().map_or(0, |broken| broken.bytes())
            + size_of::<Self>()
    }
}
