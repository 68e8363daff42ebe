//! Lattice shape matching: windows, the moment cascade and its adjoint, rotations, goal positions.

pub(crate) mod cascade;
pub(crate) mod goals;
pub(crate) mod layout;
pub(crate) mod regions;
pub(crate) mod rotation;
mod windows;

use std::sync::atomic::AtomicUsize;

use crate::body::State;
use crate::lanes::Lanes;
use crate::lattice::Lattice;
use crate::parallel::Executor;
use cascade::Cascade;
use goals::{Accelerate, FitRotations, Weighted, WriteGoals};
use layout::Layout;
use regions::Regions;

/// The matching stage: the regions of a lattice. Its buffers are a [`Cascade`], which other stages use as well.
#[derive(Debug)]
pub(crate) struct Matching {
    pub(crate) layout: Layout,
    pub(crate) regions: Regions,
}

impl Matching {
    /// Shape matching on a lattice, with regions of half-width `half_width` in cells, at least 1.
    pub(crate) fn new(lattice: &Lattice, half_width: usize) -> Self {
        let layout = Layout::new(lattice);
        let regions = Regions::new(lattice, &layout, half_width);
        Self { layout, regions }
    }

    /// Fits a rigid motion to each region at `positions`. `rotations` are the warm start, and are replaced. Returns
    /// how many of them Newton's method left to the robust path.
    pub(crate) fn fit(
        &self,
        cascade: &mut Cascade,
        executor: &Executor,
        positions: &Lanes<3>,
        rotations: &mut Lanes<4>,
    ) -> usize {
        let constants = &self.regions.constants;
        let field = Weighted { constants, vectors: positions };
        let unsettled = AtomicUsize::new(0);
        let (occupied, reach) = (self.layout.occupied(), self.regions.half_width() as f32);
        let transform = FitRotations { constants, occupied, reach, unsettled: &unsettled };
        cascade.gather(&self.layout, executor, &field, &transform, rotations.blocks_mut());
        unsettled.into_inner()
    }

    /// Accelerates each vertex towards the goal that the motions last fitted give it.
    ///
    /// `pull` is alpha/dt in 1/s; `gain` is what each vertex gains by forces that act on all alike, in cells/s.
    pub(crate) fn accelerate(
        &self,
        cascade: &mut Cascade,
        executor: &Executor,
        state: &mut State,
        pull: f32,
        gain: [f32; 3],
    ) {
        let update =
            Accelerate { constants: &self.regions.constants, positions: &state.positions, pull, gain };
        cascade.scatter(&self.layout, executor, &update, state.velocities.blocks_mut());
    }

    /// The goal positions that the motions last fitted give.
    pub(crate) fn goals(&self, cascade: &mut Cascade, executor: &Executor, goals: &mut Lanes<3>) {
        let update = WriteGoals { constants: &self.regions.constants };
        cascade.scatter(&self.layout, executor, &update, goals.blocks_mut());
    }

    /// Memory that the regions and their layout take.
    pub(crate) fn bytes(&self) -> usize {
        self.layout.bytes() + self.regions.constants.bytes()
    }
}
