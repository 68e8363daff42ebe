//! Shape matching: the rigid motion of each region, and the goal position of each vertex.
//!
//! A region moves by its centre of mass c and the rotation R of A = M⁻¹ Σ m/n (x - c) (x⁰ - c⁰)ᵀ; a vertex's goal is
//! the mean over the regions that hold it (Mueller et al. 2005, eq. 3 to 7; Rivers & James 2007, eq. 5 and 6).
//! Positions are in cells, so that the rest offsets are the whole numbers that the window sums count.

use std::sync::atomic::{AtomicUsize, Ordering};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f32x8};

use super::cascade::{RegionTransform, VertexUpdate};
use super::rotation::{columns, newton};
use crate::dynamics::momentum::Components;
use crate::dynamics::momentum::sums::{self, Fields, Sums};
use crate::lanes::{Block, Lanes, load, store};

/// The sums of a region as means.
pub(crate) struct Means<S: Simd> {
    /// S/M: of positions the centre of mass, of velocities its velocity.
    pub(crate) mean: [f32x8<S>; 3],
    /// The columns of [Sx Sy Sz]/M - (S/M) dᵀ: the moments against rest offsets from the rest centroid.
    pub(crate) central: [f32x8<S>; 9],
    /// The rest centroid from the centre vertex.
    pub(crate) d: [f32x8<S>; 3],
}

impl<S: Simd> Means<S> {
    /// From the constants of a block of regions and their sums (S, Sx, Sy, Sz).
    #[inline(always)]
    pub(crate) fn new(simd: S, constants: &Block<6>, sums: [f32x8<S>; 12]) -> Self {
        let [_, _, inverse_mass, d0, d1, d2] = load(simd, constants);
        let d = [d0, d1, d2];
        let mean = [sums[0] * inverse_mass, sums[1] * inverse_mass, sums[2] * inverse_mass];
        let mut central = [inverse_mass; 9];
        for column in 0..3 {
            for row in 0..3 {
                let i = 3 * column + row;
                central[i] = (-mean[row]).mul_add(d[column], sums[3 + i] * inverse_mass);
            }
        }
        Self { mean, central, d }
    }
}

/// The rigid motion that fits each region best. Its memory is the region's rotation: the warm start, replaced.
pub(crate) struct FitRotations<'a> {
    pub(crate) constants: &'a Lanes<6>,
    pub(crate) occupied: &'a [u8],
    /// The half-width of the regions in cells.
    pub(crate) reach: f32,
    /// Counts the rotations that Newton's method left to the robust path.
    pub(crate) unsettled: &'a AtomicUsize,
}

impl RegionTransform for FitRotations<'_> {
    type Memory = Block<4>;

    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], quaternions: &mut [Block<4>]) {
        for ((block, sums), quaternions) in (first..).zip(sums).zip(quaternions) {
            self.fit(simd, block, sums, quaternions);
        }
    }
}

impl FitRotations<'_> {
    /// c = S/M, A = [Sx Sy Sz]/M - c dᵀ, R of A; b = c - R d and the columns of R.
    #[inline(always)]
    fn fit<S: Simd>(&self, simd: S, block: usize, sums: &mut Block<12>, quaternions: &mut Block<4>) {
        let Means { mean, central: mut a, d } =
            Means::new(simd, &self.constants.blocks()[block], load(simd, sums));
        // What the rounding of the sums alone may leave of a region that is collapsed to a point has no rotation.
        let noise = (mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2])
            * (8.0 * f32::EPSILON * self.reach).powi(2);
        let mut size = a[0] * a[0];
        for i in 1..9 {
            size = a[i].mul_add(a[i], size);
        }
        let collapsed = size.simd_le(noise);
        for i in 0..9 {
            a[i] = collapsed.select(f32x8::splat(simd, 0.0), a[i]);
        }
        let left = newton::solve(simd, a, self.occupied[block], quaternions);
        if left != 0 {
            self.unsettled.fetch_add(left.count_ones() as usize, Ordering::Relaxed);
        }
        let r = columns(simd, load(simd, quaternions));
        let mut b = d;
        for row in 0..3 {
            b[row] = mean[row] - (r[row] * d[0] + r[3 + row] * d[1] + r[6 + row] * d[2]);
        }
        store([b[0], b[1], b[2], r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]], sums);
    }
}

/// Writes the goal positions down.
pub(crate) struct WriteGoals<'a> {
    pub(crate) constants: &'a Lanes<6>,
}

impl VertexUpdate for WriteGoals<'_> {
    type Memory = Block<3>;
    type Tally = ();

    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        gathered: &[Block<3>],
        goals: &mut [Block<3>],
        _: &mut [()],
    ) {
        for ((block, gathered), goals) in (first..).zip(gathered).zip(goals) {
            let [_, share] = load(simd, &self.constants.blocks()[block]);
            let [x, y, z] = load(simd, gathered);
            store([x * share, y * share, z * share], goals);
        }
    }
}

/// Accelerates each vertex towards its goal: v += alpha (g - x)/dt + a dt (Mueller et al. 2005, eq. 9).
pub(crate) struct Accelerate<'a> {
    pub(crate) constants: &'a Lanes<6>,
    pub(crate) positions: &'a Lanes<3>,
    /// alpha/dt, in 1/s.
    pub(crate) pull: f32,
    /// What each vertex gains by forces that act on all alike, in cells/s.
    pub(crate) gain: [f32; 3],
    /// Which component each vertex belongs to, whose momenta are summed; `None` to sum nothing.
    pub(crate) components: Option<&'a Components>,
}

impl VertexUpdate for Accelerate<'_> {
    type Memory = Block<3>;
    type Tally = Sums;

    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        gathered: &[Block<3>],
        velocities: &mut [Block<3>],
        sums: &mut [Sums],
    ) {
        let blocks = first..first + velocities.len();
        let (constants, positions) =
            (&self.constants.blocks()[blocks.clone()], &self.positions.blocks()[blocks]);
        let zero = f32x8::splat(simd, 0.0);
        let vertices = constants.iter().zip(positions).zip(gathered).zip(&mut *velocities);
        for (((constants, positions), gathered), velocities) in vertices {
            let [_, share] = load(simd, constants);
            let held = share.simd_gt(zero);
            let (x, gathered): ([f32x8<S>; 3], [f32x8<S>; 3]) = (load(simd, positions), load(simd, gathered));
            let mut v: [f32x8<S>; 3] = load(simd, velocities);
            for c in 0..3 {
                let gain = held.select(f32x8::splat(simd, self.gain[c]), zero);
                let residual = gathered[c].mul_add(share, -x[c]);
                v[c] = residual.mul_add(self.pull, v[c] + gain);
            }
            store(v, velocities);
        }
        if let Some(components) = self.components {
            sums::add(simd, components, first, Fields { constants, positions, velocities }, sums);
        }
    }
}
