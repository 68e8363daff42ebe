//! Runs the adjoint x pass, which is the last pass of the cascade, and the update of the vertices.

use std::ops::Range;

use fearless_simd::Simd;

use super::loose::Loose;
use super::plane::Scratch;
use super::transform::VertexUpdate;
use crate::lattice::Layout;
use crate::matching::windows::{Source, Window};
use crate::simd::lanes::{Block, Row};

/// Number of blocks in a batch. The sums of a batch are computed and then used for the update while they are
/// in the cache.
const BATCH: usize = 32;

/// The adjoint x pass, which computes the sum over the regions of each vertex from the output of the adjoint
/// y pass.
pub(super) struct AdjointX<'a, U> {
    pub(super) layout: &'a Layout,
    /// Windows of the passes along x.
    pub(super) x: Window<'a, 0>,
    /// Output of the adjoint y pass for all blocks.
    pub(super) source: &'a [Block<6>],
    /// `None` if there are no loose cells.
    pub(super) loose: Option<Loose<'a>>,
    pub(super) update: &'a U,
}

impl<U: VertexUpdate> AdjointX<'_, U> {
    /// Runs the adjoint x pass over `planes` and updates the vertices of these planes. The input has six
    /// components per vertex, the sums have three. `memory` has one entry for each block of `planes`.
    #[inline(always)]
    pub(super) fn run<S: Simd>(
        &self,
        simd: S,
        planes: Range<usize>,
        scratch: &mut Scratch,
        memory: &mut [U::Memory],
        tallies: &mut [U::Tally],
    ) {
        let first_block = self.layout.blocks_of(planes.clone()).start;
        let source = Source { first: 0, blocks: self.source };
        let mut region_sums = [[Row::ZERO; 3]; BATCH];
        for plane in planes {
            let blocks = self.layout.blocks_of(plane..plane + 1);
            scratch.running_adjoint_x.begin_plane(blocks.start);
            for first in blocks.clone().step_by(BATCH) {
                let batch = first..blocks.end.min(first + BATCH);
                let region_sums = &mut region_sums[..batch.len()];
                self.x.adjoint(simd, batch.clone(), source, &mut scratch.running_adjoint_x, region_sums);
                if let Some(loose) = &self.loose {
                    loose.add_fields(first, region_sums);
                }
                let memory = &mut memory[batch.start - first_block..batch.end - first_block];
                self.update.apply(simd, first, region_sums, memory, tallies);
            }
        }
    }
}
