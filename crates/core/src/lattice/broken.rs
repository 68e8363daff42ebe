//! The lattice data that broken joints change.

use super::charts::Chart;
use super::components::Components;

/// Corners of a cell on its upper face along each axis.
const FACES: [[usize; 4]; 3] = [[1, 3, 5, 7], [2, 3, 6, 7], [4, 5, 6, 7]];

/// The common face of two occupied cells: a cell and the next cell along an axis. Joints are ordered by cell, then
/// axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Joint {
    /// The cell on the lower side of the face.
    pub cell: u32,
    /// The axis along which the other cell is the next one: 0, 1 or 2.
    pub axis: u8,
}

impl Joint {
    /// Returns the vertices of the face. `corners`: the vertices at the corners of the cell on its lower side.
    pub(super) fn corners(self, corners: [u32; 8]) -> [u32; 4] {
        FACES[usize::from(self.axis)].map(|corner| corners[corner])
    }
}

/// The lattice data that broken joints change.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Broken {
    /// The broken joints, sorted.
    pub(super) joints: Vec<Joint>,
    pub(super) whole: Whole,
    /// Number of vertices of the lattice without broken joints. Further vertices are copies.
    pub(super) whole_len: usize,
    /// For each copy, the vertex of the lattice without broken joints at its grid index.
    pub(super) sources: Vec<u32>,
    /// Vertices at the corners of each cell.
    pub(super) corners: Vec<[u32; 8]>,
    /// Neighbors of each vertex at -x, +x, -y, +y, -z, +z; [`NO_NEIGHBOR`](super::charts::NO_NEIGHBOR) if there is
    /// none.
    pub(super) neighbors: Vec<[u32; 6]>,
    /// The storage of the vertices in blocks.
    pub(super) chart: Chart,
}

/// The arrays of the lattice without broken joints that broken joints change.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Whole {
    pub(super) links: Vec<u8>,
    pub(super) occupied_cells: Vec<u8>,
    pub(super) components: Components,
}

impl Broken {
    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        let Whole { links, occupied_cells, components } = &self.whole;
        size_of_val(&**links)
            + size_of_val(&**occupied_cells)
            + size_of_val(&*components.of_vertex)
            + size_of_val(&*self.joints)
            + size_of_val(&*self.sources)
            + size_of_val(&*self.corners)
            + size_of_val(&*self.neighbors)
            + self.chart.bytes()
    }
}
