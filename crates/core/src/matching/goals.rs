//! Shape matching: the rigid motion of each region, and the goal position of each vertex.
//!
//! A region moves by its centre of mass c and the rotation R of A = M⁻¹ Σ m/n (x - c) (x⁰ - c⁰)ᵀ; a vertex's goal is
//! the mean over the regions that hold it (Mueller et al. 2005, eq. 3 to 7; Rivers & James 2007, eq. 5 and 6).
//! Positions are in cells, so that the rest offsets are the whole numbers that the window sums count.

use std::sync::atomic::{AtomicUsize, Ordering};

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f32x8};

use super::cascade::{RegionTransform, VertexField, VertexUpdate};
use super::rotation::{columns, newton};
use crate::lanes::{LANES, Lanes};

/// A vector of each vertex times its weight m/n: f = (m/n) p.
pub(crate) struct Weighted<'a> {
    pub(crate) constants: &'a Lanes<6>,
    pub(crate) vectors: &'a Lanes<3>,
}

impl VertexField for Weighted<'_> {
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, block: usize) -> [f32x8<S>; 3] {
        let constants = &self.constants.blocks()[block];
        let weight = f32x8::load_array_ref(simd, &constants[0]) * f32x8::load_array_ref(simd, &constants[1]);
        self.vectors.blocks()[block].each_ref().map(|row| f32x8::load_array_ref(simd, row) * weight)
    }
}

/// The rigid motion that fits each region best. Its memory is the region's rotation: the warm start, replaced.
pub(crate) struct FitRotations<'a> {
    pub(crate) constants: &'a Lanes<6>,
    pub(crate) occupied: &'a [u8],
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
        let constants = &self.constants.blocks()[block];
        let constant = |c: usize| f32x8::load_array_ref(simd, &constants[c]);
        let (inverse_mass, d) = (constant(2), [constant(3), constant(4), constant(5)]);
        let mut mean = sums.map(|sum| sum * inverse_mass);
        for column in 0..3 {
            for row in 0..3 {
                let i = 3 + 3 * column + row;
                mean[i] = (-mean[row]).mul_add(d[column], mean[i]);
            }
        }
        let a = std::array::from_fn(|i| mean[3 + i]);
        let left = newton::solve(simd, a, self.occupied[block], quaternions);
        if left != 0 {
            self.unsettled.fetch_add(left.count_ones() as usize, Ordering::Relaxed);
        }
        let r = columns(simd, quaternions.each_ref().map(|row| f32x8::load_array_ref(simd, row)));
        let b: [f32x8<S>; 3] =
            std::array::from_fn(|row| mean[row] - (r[row] * d[0] + r[3 + row] * d[1] + r[6 + row] * d[2]));
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
        let share = f32x8::load_array_ref(simd, &self.constants.blocks()[block][1]);
        for (row, sum) in goals.iter_mut().zip(gathered) {
            (sum * share).store_array(row);
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
        let share = f32x8::load_array_ref(simd, &self.constants.blocks()[block][1]);
        let held = share.simd_gt(zero);
        let positions = &self.positions.blocks()[block];
        for (c, row) in velocities.iter_mut().enumerate() {
            let x = f32x8::load_array_ref(simd, &positions[c]);
            let v = f32x8::load_array_ref(simd, row);
            let residual = gathered[c].mul_add(share, -x);
            let gain = held.select(f32x8::splat(simd, self.gain[c]), zero);
            residual.mul_add(self.pull, v + gain).store_array(row);
        }
    }
}
