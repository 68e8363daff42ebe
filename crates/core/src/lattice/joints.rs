//! The joints of a lattice.
//!
//! A *joint* is the common face of two occupied cells. Cells that touch at an edge or a corner only have no joint.

use super::broken::Joint;
use super::cells::Lattice;
use super::charts::Chart;

impl Lattice {
    /// Returns the joints, broken ones included, in order, and the cell on the upper side of each.
    pub fn joints(&self) -> impl Iterator<Item = (Joint, u32)> + '_ {
        (0..self.cells.len() as u32).flat_map(move |cell| {
            (0..3).filter_map(move |axis| Some((Joint { cell, axis }, self.cell_beyond(cell, axis, 1)?)))
        })
    }

    /// Returns the two cells of a joint; `None` if a cell has no joint there.
    pub(crate) fn joint_cells(&self, joint: Joint) -> Option<[u32; 2]> {
        Some([joint.cell, self.cell_beyond(joint.cell, joint.axis, 1)?])
    }

    /// Returns the occupied cell on the other side of a face of a cell, whether or not the joint is broken. `step`
    /// is -1 for the lower face along the axis and 1 for the upper face.
    pub(crate) fn cell_beyond(&self, cell: u32, axis: u8, step: i32) -> Option<u32> {
        self.cell_at(crate::voxel::step(self.cells[cell as usize], axis.into(), step))
    }

    /// Returns the cell on the other side of a face of a cell if an unbroken joint joins them. `side`: 0 to 5 for the
    /// face at -x, +x, -y, +y, -z, +z.
    pub(crate) fn joined_cell(&self, cell: u32, side: usize) -> Option<u32> {
        let (axis, is_upper) = ((side / 2) as u8, side % 2 == 1);
        let other = self.cell_beyond(cell, axis, if is_upper { 1 } else { -1 })?;
        let joint = Joint { cell: if is_upper { cell } else { other }, axis };
        (!self.is_broken(joint)).then_some(other)
    }

    /// Returns the broken joints, in order.
    pub fn broken_joints(&self) -> &[Joint] {
        self.broken.as_ref().map_or(&[], |broken| &broken.joints)
    }

    /// Returns whether a joint is broken.
    pub(crate) fn is_broken(&self, joint: Joint) -> bool {
        self.broken_joints().binary_search(&joint).is_ok()
    }

    /// Returns the connected component that contains a cell.
    pub(crate) fn component_of_cell(&self, cell: u32) -> u32 {
        self.components.of_vertex[self.first_corner(cell) as usize]
    }

    /// Returns the four vertices of the face of a joint, of its lower cell if the joint is broken.
    pub(crate) fn joint_corners(&self, joint: Joint) -> [u32; 4] {
        joint.corners(self.cell_corners(joint.cell))
    }

    /// Returns the number of vertices of the lattice without broken joints. The vertices from this number on are copies
    /// at grid indices of other vertices.
    pub fn whole_len(&self) -> usize {
        self.broken.as_ref().map_or(self.indices.len(), |broken| broken.whole_len)
    }

    /// Returns the vertex of the lattice without broken joints at the grid index of a vertex: the vertex itself unless
    /// it is a copy.
    ///
    /// # Panics
    ///
    /// If there is no such vertex.
    pub fn source(&self, vertex: u32) -> u32 {
        match &self.broken {
            Some(broken) if vertex as usize >= broken.whole_len => {
                broken.sources[vertex as usize - broken.whole_len]
            }
            _ => vertex,
        }
    }

    /// Returns how the vertices are stored in blocks if joints are broken.
    pub(super) fn chart(&self) -> Option<&Chart> {
        self.broken.as_ref().map(|broken| &broken.chart)
    }
}
