//! The functions that the cascade applies to the sums of the regions and of the vertices.

use fearless_simd::Simd;

use crate::parallel::Split;
use crate::simd::lanes::Block;

/// The function that is applied to the sums of each region: the fit of a rotation or of a rigid velocity. `Memory` is
/// the data that the transform reads and writes: arrays with one entry for each block of eight regions.
pub(crate) trait RegionTransform<Memory: Split>: Sync {
    /// Replaces (S, Sx, Sy, Sz) by (b, X, Y, Z), three components each, in consecutive blocks. `first` is the
    /// index of the first block in the layout.
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], memory: Memory);
}

/// The function that is applied to the sum over the regions that contain each vertex.
pub(crate) trait VertexUpdate: Sync {
    /// Data that the update reads and writes, for each block of eight vertices.
    type Memory: Send;
    /// Result that is accumulated over the vertices of a task, such as sums of momenta.
    type Tally: Send;
    /// Updates the vertices of consecutive blocks. `first` is the index of the first block in the layout.
    /// `region_sums` is, for each vertex, Σ (b + i X + j Y + k Z) over the regions that contain the vertex.
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        region_sums: &[Block<3>],
        memory: &mut [Self::Memory],
        tallies: &mut [Self::Tally],
    );
}

/// The purpose of a call of [`Cascade::forward`](super::Cascade::forward), which determines the last pass that it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// To evaluate each vertex with [`Cascade::adjoint`](super::Cascade::adjoint) afterwards, for example its goal
    /// position. All passes up to the adjoint y pass run.
    Vertices,
    /// To compute only the memory of the transform, for example the rotation of each region. The last pass is
    /// the z pass.
    Regions,
}
