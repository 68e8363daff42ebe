//! Shape matching: the rigid motion of each region, and the goal position of each vertex.
//!
//! A region moves by its centre of mass c and the rotation R of A = M⁻¹ Σ m/n (x - c) (x⁰ - c⁰)ᵀ; a vertex's goal is
//! the mean over the regions that hold it (Mueller et al. 2005, eq. 3 to 7; Rivers & James 2007, eq. 5 and 6).
//! Positions are in cells, so that the rest offsets are the whole numbers that the window sums count.

use std::sync::atomic::{AtomicUsize, Ordering};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8};

use super::cascade::{RegionTransform, VertexUpdate};
use super::rotation::{columns, newton};
use crate::dynamics::energy::RegionSums;
use crate::dynamics::momentum::Components;
use crate::dynamics::momentum::sums::{self, Fields, Sums};
use crate::simd::lanes::{Block, LANES, Lanes, load, load_two, split_two, store};

/// The sums of a region as means.
pub(crate) struct Means<V> {
    /// S/M: of positions the centre of mass, of velocities its velocity.
    pub(crate) mean: [V; 3],
    /// The columns of [Sx Sy Sz]/M - (S/M) dᵀ: the moments against rest offsets from the rest centroid.
    pub(crate) central: [V; 9],
    /// The rest centroid from the centre vertex.
    pub(crate) d: [V; 3],
}

impl<V> Means<V> {
    /// From the constants of regions and their sums (S, Sx, Sy, Sz).
    #[inline(always)]
    pub(crate) fn new<S: Simd>([inverse_mass, d0, d1, d2]: [V; 4], sums: [V; 12]) -> Self
    where
        V: SimdFloat<S, Element = f32>,
    {
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
    pub(crate) constants: &'a Lanes<4>,
    pub(crate) occupied: &'a [u8],
    /// The half-width of the regions in cells.
    pub(crate) reach: f32,
    /// Counts the rotations that Newton's method left to the robust path.
    pub(crate) unsettled: &'a AtomicUsize,
    /// Where what the potential is summed from goes, if it is asked for.
    pub(crate) matched: Option<&'a RegionSums>,
}

impl RegionTransform for FitRotations<'_> {
    type Memory = Block<4>;

    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], quaternions: &mut [Block<4>]) {
        for at in (0..sums.len()).step_by(2) {
            // An odd block is fitted beside itself.
            let both = [at, (at + 1).min(sums.len() - 1)];
            self.fit(simd, both.map(|at| first + at), both, sums, quaternions);
        }
    }
}

impl FitRotations<'_> {
    /// c = S/M, A = [Sx Sy Sz]/M - c dᵀ, R of A; b = c - R d and the columns of R.
    #[inline(always)]
    fn fit<S: Simd>(
        &self,
        simd: S,
        blocks: [usize; 2],
        at: [usize; 2],
        sums: &mut [Block<12>],
        quaternions: &mut [Block<4>],
    ) {
        let constants = self.constants.blocks();
        let constants = load_two(simd, [&constants[blocks[0]], &constants[blocks[1]]]);
        let moments = load_two(simd, [&sums[at[0]], &sums[at[1]]]);
        let warm = load_two(simd, [&quaternions[at[0]], &quaternions[at[1]]]);
        let Means { mean, central: a, d } = Means::new(constants, moments);
        // What the rounding of the sums alone may leave of a region that is collapsed to a point has no rotation.
        let noise = mean[0].mul_add(mean[0], mean[1].mul_add(mean[1], mean[2] * mean[2]))
            * (8.0 * f32::EPSILON * self.reach).powi(2);
        let mut size = [a[0] * a[0], a[1] * a[1], a[2] * a[2]];
        for i in 3..9 {
            size[i % 3] = a[i].mul_add(a[i], size[i % 3]);
        }
        let collapsed = ((size[0] + size[1]) + size[2]).simd_le(noise).to_bitmask() as u16;
        let [one, other] = blocks.map(|block| u16::from(self.occupied[block]));
        let asked = one | if blocks[0] == blocks[1] { 0 } else { other << LANES };
        let (q, left) = newton::solve(simd, a, warm, asked, collapsed);
        if left != 0 {
            self.unsettled.fetch_add(left.count_ones() as usize, Ordering::Relaxed);
        }
        let r = columns(simd, q);
        if let Some(matched) = self.matched {
            let occupied = blocks.map(|block| self.occupied[block]);
            matched.take(blocks, occupied, constants[0], mean, [&a, &r]);
        }
        let mut b = d;
        for row in 0..3 {
            b[row] = mean[row] - r[row].mul_add(d[0], r[3 + row].mul_add(d[1], r[6 + row] * d[2]));
        }
        let motions = [b[0], b[1], b[2], r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]];
        let (motions, q) = (split_two(simd, motions), split_two(simd, q));
        // The first last: it is the one that was asked for where both are the same.
        for half in [1, 0] {
            store(motions[half], &mut sums[at[half]]);
            store(q[half], &mut quaternions[at[half]]);
        }
    }
}

/// Writes the goal positions down.
pub(crate) struct WriteGoals<'a> {
    pub(crate) shares: &'a Lanes<2>,
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
            let [_, share] = load(simd, &self.shares.blocks()[block]);
            let [x, y, z] = load(simd, gathered);
            store([x * share, y * share, z * share], goals);
        }
    }
}

/// Accelerates each vertex towards its goal: v += alpha (g - x)/dt + a dt (Mueller et al. 2005, eq. 9).
pub(crate) struct Accelerate<'a> {
    pub(crate) shares: &'a Lanes<2>,
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
        let (shares, positions) = (&self.shares.blocks()[blocks.clone()], &self.positions.blocks()[blocks]);
        let zero = f32x8::splat(simd, 0.0);
        let vertices = shares.iter().zip(positions).zip(gathered).zip(&mut *velocities);
        for (((shares, positions), gathered), velocities) in vertices {
            let [_, share] = load(simd, shares);
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
            sums::add(simd, components, first, Fields { shares, positions, velocities }, sums);
        }
    }
}
