//! Lattice shape matching: windows, the moment cascade and its adjoint, rotations, goal positions.

pub(crate) mod cascade;
pub(crate) mod goals;
pub(crate) mod regions;
pub(crate) mod rotation;
pub(crate) mod windows;

use std::sync::atomic::AtomicUsize;

use crate::body::State;
use crate::dynamics::energy::RegionSums;
use crate::dynamics::momentum::Bookkeeper;
use crate::lattice::Lattice;
use crate::lattice::layout::Layout;
use crate::parallel::Executor;
use crate::simd::lanes::Lanes;
use cascade::{Cascade, Purpose};
use goals::{Accelerate, FitRotations, WriteGoals};
use regions::Regions;
use windows::Weighted;

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

    /// Gives the regions another half-width, on the same lattice.
    pub(crate) fn set_half_width(&mut self, lattice: &Lattice, half_width: usize) {
        self.regions = Regions::new(lattice, &self.layout, half_width);
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
        self.fit_summing(cascade, executor, positions, rotations, None)
    }

    /// As [`Matching::fit`]; leaves with `matched` what the potential is summed from.
    pub(crate) fn fit_summing(
        &self,
        cascade: &mut Cascade,
        executor: &Executor,
        positions: &Lanes<3>,
        rotations: &mut Lanes<4>,
        matched: Option<&RegionSums>,
    ) -> usize {
        let unsettled = AtomicUsize::new(0);
        let (field, transform) = self.fitting(positions, &unsettled);
        let transform = FitRotations { matched, ..transform };
        cascade.gather(&self.layout, executor, field, (&transform, rotations.blocks_mut()), Purpose::Scatter);
        unsettled.into_inner()
    }

    /// As [`Matching::fit`], for the rotations alone: no goals can be had from it.
    pub(crate) fn turn(
        &self,
        cascade: &mut Cascade,
        executor: &Executor,
        positions: &Lanes<3>,
        rotations: &mut Lanes<4>,
    ) {
        let unsettled = AtomicUsize::new(0);
        let (field, transform) = self.fitting(positions, &unsettled);
        cascade.gather(
            &self.layout,
            executor,
            field,
            (&transform, rotations.blocks_mut()),
            Purpose::Remember,
        );
    }

    fn fitting<'a>(
        &'a self,
        positions: &'a Lanes<3>,
        unsettled: &'a AtomicUsize,
    ) -> (Weighted<'a>, FitRotations<'a>) {
        let constants = &self.regions.constants;
        let (occupied, reach) = (self.layout.occupied(), self.regions.half_width() as f32);
        (
            Weighted { shares: self.regions.shares.blocks(), vectors: positions.blocks() },
            FitRotations { constants, occupied, reach, unsettled, matched: None },
        )
    }

    /// Accelerates each vertex towards the goal that the motions last fitted give it.
    ///
    /// `pull` is alpha/dt in 1/s; `gain` is what each vertex gains by forces that act on all alike, in cells/s.
    /// The momenta are left with the bookkeeper.
    pub(crate) fn accelerate(
        &self,
        cascade: &Cascade,
        executor: &Executor,
        state: &mut State,
        (pull, gain): (f32, [f32; 3]),
        bookkeeper: &mut Bookkeeper,
    ) {
        let (shares, positions) = (&self.regions.shares, &state.positions);
        let free = bookkeeper.any_free();
        let (components, sums) = bookkeeper.open_sums();
        let components = free.then_some(components);
        let update = Accelerate { shares, positions, pull, gain, components };
        cascade.scatter(&self.layout, executor, &update, state.velocities.blocks_mut(), sums);
        bookkeeper.close_sums();
    }

    /// The goal positions that the motions last fitted give.
    pub(crate) fn goals(&self, cascade: &Cascade, executor: &Executor, goals: &mut Lanes<3>) {
        let update = WriteGoals { shares: &self.regions.shares };
        cascade.scatter(&self.layout, executor, &update, goals.blocks_mut(), &mut []);
    }

    /// Memory that the regions and their layout take.
    pub(crate) fn bytes(&self) -> usize {
        self.layout.bytes() + self.regions.bytes()
    }
}
