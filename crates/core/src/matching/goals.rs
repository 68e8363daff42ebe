//! Shape matching: the rigid motion of each region, and the goal position of each vertex.
//!
//! The rigid motion of a region is given by its center of mass c and the rotation R of
//! A = M⁻¹ Σ m/n (x - c) (x⁰ - c⁰)ᵀ. The goal position g of a vertex is the mean of R (x⁰ - c⁰) + c over the
//! regions that contain it (Müller et al. 2005, Eqs. (3) to (7); Rivers & James 2007, Eqs. (5) and (6)).
//! Positions are in cells, so that the rest offset between two vertices is a number of links.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x16};

use super::cascade::{RegionTransform, VertexUpdate};
use super::rotation::{columns, newton};
use crate::simd::lanes::{Block, LANES, Lanes, load, load_two, split_two, store};

/// The mass-weighted means of the sums of a region.
pub(crate) struct Means<V> {
    /// S/M: the center of mass for a field of positions, its velocity for a field of velocities.
    pub(crate) mean: [V; 3],
    /// The columns of [Sx Sy Sz]/M - (S/M) dᵀ: first moments against the rest offsets from the rest centroid.
    pub(crate) central: [V; 9],
    /// Rest centroid relative to the center vertex, in cells.
    pub(crate) d: [V; 3],
}

impl<V> Means<V> {
    /// Computes the means from the constants (1/M, d) and the sums (S, Sx, Sy, Sz) of regions.
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

/// The region transform that fits a rigid motion. Its memory is the rotation: the warm start, then the
/// result.
pub(crate) struct FitRotations<'a> {
    pub(crate) constants: &'a Lanes<4>,
    /// Bit mask of the lanes with a vertex, for each block.
    pub(crate) occupied: &'a [u8],
    /// Half-width of the regions in cells.
    pub(crate) half_width: f32,
    /// Counts the rotations that do not converge in Newton's method.
    pub(crate) unconverged: &'a AtomicUsize,
    /// Receives the elastic potential; `None` if it is not needed.
    pub(crate) potential: Option<&'a PotentialSums>,
}

impl RegionTransform for FitRotations<'_> {
    type Memory = Block<4>;

    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], quaternions: &mut [Block<4>]) {
        for at in (0..sums.len()).step_by(2) {
            // The last of an odd number of blocks is paired with itself.
            let pair = [at, (at + 1).min(sums.len() - 1)];
            self.fit(simd, pair.map(|at| first + at), pair, sums, quaternions);
        }
    }
}

impl FitRotations<'_> {
    /// Fits two blocks: computes c = S/M, A = [Sx Sy Sz]/M - c dᵀ and the rotation R of A. Replaces the sums
    /// by b = c - R d and the columns of R.
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
        // A region collapsed to a point has no rotation: its A is at the level of rounding, |c| eps
        // half_width, times a margin of 8.
        let noise = mean[0].mul_add(mean[0], mean[1].mul_add(mean[1], mean[2] * mean[2]))
            * (8.0 * f32::EPSILON * self.half_width).powi(2);
        let mut norm = [a[0] * a[0], a[1] * a[1], a[2] * a[2]];
        for i in 3..9 {
            norm[i % 3] = a[i].mul_add(a[i], norm[i % 3]);
        }
        let collapsed = ((norm[0] + norm[1]) + norm[2]).simd_le(noise).to_bitmask() as u16;
        let [first, second] = blocks.map(|block| u16::from(self.occupied[block]));
        let active = first | if blocks[0] == blocks[1] { 0 } else { second << LANES };
        let (q, unconverged) = newton::solve(simd, a, warm, active, collapsed);
        if unconverged != 0 {
            self.unconverged.fetch_add(unconverged.count_ones() as usize, Ordering::Relaxed);
        }
        let r = columns(simd, q);
        if let Some(potential) = self.potential {
            let occupied = blocks.map(|block| self.occupied[block]);
            potential.store(blocks, occupied, constants[0], mean, [&a, &r]);
        }
        let mut b = d;
        for row in 0..3 {
            b[row] = mean[row] - r[row].mul_add(d[0], r[3 + row].mul_add(d[1], r[6 + row] * d[2]));
        }
        let motions = [b[0], b[1], b[2], r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]];
        let (motions, q) = (split_two(simd, motions), split_two(simd, q));
        // The first block is stored last: where both blocks are the same, only its lanes are active.
        for half in [1, 0] {
            store(motions[half], &mut sums[at[half]]);
            store(q[half], &mut quaternions[at[half]]);
        }
    }
}

/// The vertex update that writes the goal positions g = (1/n) Σ over the regions that contain the vertex.
pub(crate) struct WriteGoals<'a> {
    pub(crate) weights: &'a Lanes<2>,
}

impl VertexUpdate for WriteGoals<'_> {
    type Memory = Block<3>;
    type Tally = ();

    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        region_sums: &[Block<3>],
        goals: &mut [Block<3>],
        _: &mut [()],
    ) {
        for ((block, region_sums), goals) in (first..).zip(region_sums).zip(goals) {
            let [_, inverse_count] = load(simd, &self.weights.blocks()[block]);
            let [x, y, z] = load(simd, region_sums);
            store([x * inverse_count, y * inverse_count, z * inverse_count], goals);
        }
    }
}

/// Sums for the elastic potential of the fit, in f64, one for each block of regions. Each sum is written by
/// one thread.
#[derive(Debug)]
pub(crate) struct PotentialSums(Vec<AtomicU64>);

impl PotentialSums {
    /// Creates the sums of `blocks` blocks.
    pub(crate) fn new(blocks: usize) -> Self {
        Self((0..blocks).map(|_| AtomicU64::new(0)).collect())
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.0.as_slice())
    }

    /// Stores Σ M (c² + 2 tr(Rᵀ A)) over the regions of each of two blocks; `occupied` is the bit mask of
    /// their lanes with a vertex.
    #[inline(always)]
    fn store<S: Simd>(
        &self,
        blocks: [usize; 2],
        occupied: [u8; 2],
        inverse_mass: f32x16<S>,
        mean: [f32x16<S>; 3],
        [a, r]: [&[f32x16<S>; 9]; 2],
    ) {
        let mut trace = r[0] * a[0];
        for i in 1..9 {
            trace = r[i].mul_add(a[i], trace);
        }
        let square = mean[0].mul_add(mean[0], mean[1].mul_add(mean[1], mean[2] * mean[2]));
        let values = (square + (trace + trace)).to_array();
        let inverse_masses = inverse_mass.to_array();
        // The first block is stored last: where both blocks are the same, only its lanes are active.
        for half in [1, 0] {
            let mut sum = 0.0;
            for lane in (0..LANES).filter(|lane| occupied[half] >> lane & 1 != 0) {
                let at = half * LANES + lane;
                sum += f64::from(values[at]) / f64::from(inverse_masses[at]);
            }
            self.0[blocks[half]].store(sum.to_bits(), Ordering::Relaxed);
        }
    }

    /// Returns the sum over all blocks.
    pub(crate) fn sum(&self) -> f64 {
        self.0.iter().map(|sum| f64::from_bits(sum.load(Ordering::Relaxed))).sum()
    }
}
