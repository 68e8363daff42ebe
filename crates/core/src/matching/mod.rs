//! Lattice shape matching: windows, the moment cascade and its adjoint, rotations, goal positions.

pub(crate) mod cascade;
pub(crate) mod goals;
pub(crate) mod layout;
pub(crate) mod regions;
pub(crate) mod rotation;
mod windows;

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::lanes::Lanes;
use crate::lattice::Lattice;
use crate::parallel::Executor;
use cascade::Cascade;
use goals::{Accelerate, FitRotations, Weighted, WriteGoals};
use layout::Layout;
use regions::Regions;

/// The matching stage: the regions of a lattice and the buffers of their sums.
#[derive(Debug)]
pub(crate) struct Matching {
    pub(crate) layout: Layout,
    pub(crate) regions: Regions,
    pub(crate) cascade: Cascade,
    unsettled: AtomicUsize,
}

impl Matching {
    /// Shape matching on a lattice, with regions of half-width `half_width` in cells, at least 1.
    pub(crate) fn new(lattice: &Lattice, layout: Layout, half_width: usize) -> Self {
        let regions = Regions::new(lattice, &layout, half_width);
        let cascade = Cascade::new(&layout, half_width);
        Self { layout, regions, cascade, unsettled: AtomicUsize::new(0) }
    }

    /// Fits a rigid motion to each region at `positions`. `rotations` are the warm start, and are replaced.
    pub(crate) fn fit(&mut self, executor: &Executor, positions: &Lanes<3>, rotations: &mut Lanes<4>) {
        let Self { layout, regions, cascade, unsettled } = self;
        let constants = &regions.constants;
        let field = Weighted { constants, vectors: positions };
        let transform = FitRotations { constants, occupied: layout.occupied(), unsettled };
        cascade.gather(layout, executor, &field, &transform, rotations.blocks_mut());
    }

    /// Accelerates each vertex towards the goal that the motions last fitted give it.
    ///
    /// `pull` is alpha/dt in 1/s; `gain` is what each vertex gains by forces that act on all alike, in cells/s.
    pub(crate) fn accelerate(
        &mut self,
        executor: &Executor,
        positions: &Lanes<3>,
        velocities: &mut Lanes<3>,
        pull: f32,
        gain: [f32; 3],
    ) {
        let Self { layout, regions, cascade, .. } = self;
        let update = Accelerate { constants: &regions.constants, positions, pull, gain };
        cascade.scatter(layout, executor, &update, velocities.blocks_mut());
    }

    /// The goal positions that the motions last fitted give.
    pub(crate) fn goals(&mut self, executor: &Executor, goals: &mut Lanes<3>) {
        let Self { layout, regions, cascade, .. } = self;
        let update = WriteGoals { constants: &regions.constants };
        cascade.scatter(layout, executor, &update, goals.blocks_mut());
    }

    /// Rotations since the start that Newton's method left to the robust path.
    pub(crate) fn unsettled(&self) -> usize {
        self.unsettled.load(Ordering::Relaxed)
    }
}
