//! Shape matching: the rigid motion of each region, and the goal position of each vertex.
//!
//! A region moves by its centre of mass c and the rotation R of A = M⁻¹ Σ m/n (x - c) (x⁰ - c⁰)ᵀ; a vertex's goal is
//! the mean over the regions that hold it (Mueller et al. 2005, eq. 3 to 7; Rivers & James 2007, eq. 5 and 6).
//! Positions are in cells, so that the rest offsets are the whole numbers that the window sums count.

use std::sync::atomic::{AtomicUsize, Ordering};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f32x8};

use super::cascade::{RegionTransform, VertexField, VertexUpdate};
use super::rotation::{columns, newton};
use crate::lanes::{LANES, Lanes, load, store};

/// A vector of each vertex times its weight m/n: f = (m/n) p.
pub(crate) struct Weighted<'a> {
    pub(crate) constants: &'a Lanes<6>,
    pub(crate) vectors: &'a Lanes<3>,
}

impl VertexField for Weighted<'_> {
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, block: usize) -> [f32x8<S>; 3] {
        let [mass, share] = load(simd, &self.constants.blocks()[block]);
        let weight = mass * share;
        let [x, y, z] = load(simd, &self.vectors.blocks()[block]);
        [x * weight, y * weight, z * weight]
    }
}

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
    pub(crate) fn new(simd: S, constants: &[[f32; LANES]; 6], sums: [f32x8<S>; 12]) -> Self {
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
    type Memory = [[f32; LANES]; 4];

    /// c = S/M, A = [Sx Sy Sz]/M - c dᵀ, R of A; b = c - R d and the columns of R.
    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        block: usize,
        sums: [f32x8<S>; 12],
        quaternions: &mut [[f32; LANES]; 4],
    ) -> [f32x8<S>; 12] {
        let Means { mean, central: mut a, d } = Means::new(simd, &self.constants.blocks()[block], sums);
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
        [b[0], b[1], b[2], r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]]
    }
}

/// Writes the goal positions down.
pub(crate) struct WriteGoals<'a> {
    pub(crate) constants: &'a Lanes<6>,
}

impl VertexUpdate for WriteGoals<'_> {
    type Memory = [[f32; LANES]; 3];

    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, block: usize, gathered: [f32x8<S>; 3], goals: &mut [[f32; LANES]; 3]) {
        let [_, share] = load(simd, &self.constants.blocks()[block]);
        let [x, y, z] = gathered;
        store([x * share, y * share, z * share], goals);
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
}

impl VertexUpdate for Accelerate<'_> {
    type Memory = [[f32; LANES]; 3];

    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        block: usize,
        gathered: [f32x8<S>; 3],
        velocities: &mut [[f32; LANES]; 3],
    ) {
        let zero = f32x8::splat(simd, 0.0);
        let [_, share] = load(simd, &self.constants.blocks()[block]);
        let held = share.simd_gt(zero);
        let x: [f32x8<S>; 3] = load(simd, &self.positions.blocks()[block]);
        let mut v: [f32x8<S>; 3] = load(simd, velocities);
        for c in 0..3 {
            let gain = held.select(f32x8::splat(simd, self.gain[c]), zero);
            let residual = gathered[c].mul_add(share, -x[c]);
            v[c] = residual.mul_add(self.pull, v[c] + gain);
        }
        store(v, velocities);
    }
}
