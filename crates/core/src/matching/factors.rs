//! Stiffness factors of the regions.

use crate::simd::lanes::{Block, Lanes};

/// The stiffness factors of the regions, for a body whose stiffness varies. A region of factor s pulls its vertices
/// towards its rigid motion s times as strongly.
///
/// The factors belong to regions and not to vertices: the rigid motion of a region has the momenta of its vertices, so
/// the forces of each region have no sum and no moment, whatever the factor.
#[derive(Clone, Debug)]
pub(crate) struct Factors {
    /// s of the region around each vertex, times an eighth of the filled share of a cell if the regions are cells.
    /// Zero in lanes without a region.
    pub(super) regions: Lanes<1>,
    /// S/n and 1/S of each vertex: S is the sum of the factors of the n regions that contain the vertex. S/n is the
    /// stiffness factor of the vertex, and 1/S turns a sum over the regions, weighted by s, into a mean. Zero in lanes
    /// without a vertex.
    pub vertices: Lanes<2>,
}

impl Factors {
    /// Returns s of the region around the vertex in a slot.
    pub(super) fn of_region(&self, slot: u32) -> f32 {
        self.regions.get(slot)[0]
    }

    /// Returns s of the regions of a block.
    #[inline(always)]
    pub(crate) fn of_regions(&self, block: usize) -> &Block<1> {
        &self.regions.blocks()[block]
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.regions.bytes() + self.vertices.bytes()
    }
}
