//! Sums of mass, momentum and inertia over the vertices of a component, in f64 and in a fixed order.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, dispatch, f32x8, f64x4};
use nalgebra::{Matrix3, Vector3};

use super::Components;
use super::rigid::{Momentum, RigidState};
use crate::lanes::{LANES, Lanes, load};
use crate::parallel::level;

/// Sums over a component, in f64.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    mass: f64,
    /// Σ m v, Σ m x, Σ m x x v, Σ m (xx, yy, zz, xy, xz, yz).
    moments: [f64; MOMENTS],
}

const MOMENTS: usize = 15;

impl Sums {
    pub(super) fn add(&mut self, other: &Self) {
        self.mass += other.mass;
        for (sum, other) in self.moments.iter_mut().zip(other.moments) {
            *sum += other;
        }
    }

    /// As a rigid body.
    pub(super) fn rigid_state(&self) -> RigidState {
        let m = &self.moments;
        let mass = if self.mass > 0.0 { self.mass } else { 1.0 };
        let linear = Vector3::new(m[0], m[1], m[2]);
        let centre = Vector3::new(m[3], m[4], m[5]) / mass;
        let angular = Vector3::new(m[6], m[7], m[8]) - centre.cross(&linear);
        let [xx, yy, zz, xy, xz, yz] = [m[9], m[10], m[11], m[12], m[13], m[14]];
        let spread = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) - centre * centre.transpose() * mass;
        let inertia = Matrix3::identity() * spread.trace() - spread;
        RigidState {
            mass,
            centre,
            momentum: Momentum { linear: linear.into(), angular: angular.into() },
            inertia,
        }
    }
}

/// What is summed.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    pub(super) constants: &'a Lanes<6>,
    pub(super) positions: &'a Lanes<3>,
    pub(super) velocities: &'a Lanes<3>,
}

impl Fields<'_> {
    /// The sums of each component over a range of blocks.
    pub(super) fn sum(self, components: &Components, blocks: Range<usize>, sums: &mut [Sums]) {
        sums.fill(Sums::default());
        match components {
            Components::One => dispatch!(level(), simd => sums[0] = sum(simd, self, blocks)),
            Components::Several(_) => sum_by_component(self, components, blocks, sums),
        }
    }
}

/// The moments of one vertex: all but the mass are linear in m.
#[inline(always)]
fn moments<T>(m: T, [x, y, z]: [T; 3], [u, v, w]: [T; 3]) -> [T; MOMENTS]
where
    T: Copy + std::ops::Mul<Output = T> + std::ops::Sub<Output = T>,
{
    let (mx, my, mz) = (m * x, m * y, m * z);
    [
        m * u,
        m * v,
        m * w,
        mx,
        my,
        mz,
        my * w - mz * v,
        mz * u - mx * w,
        mx * v - my * u,
        mx * x,
        my * y,
        mz * z,
        mx * y,
        mx * z,
        my * z,
    ]
}

/// The sums of a range of blocks, four lanes at a time.
#[inline(always)]
fn sum<S: Simd>(simd: S, fields: Fields, blocks: Range<usize>) -> Sums {
    let mut mass = f64x4::splat(simd, 0.0);
    let mut total = [f64x4::splat(simd, 0.0); MOMENTS];
    for block in blocks {
        let [m] = load(simd, &fields.constants.blocks()[block]);
        let [x, y, z] = load(simd, &fields.positions.blocks()[block]);
        let [u, v, w] = load(simd, &fields.velocities.blocks()[block]);
        let (m, x, y, z) = (halves(simd, m), halves(simd, x), halves(simd, y), halves(simd, z));
        let (u, v, w) = (halves(simd, u), halves(simd, v), halves(simd, w));
        for half in 0..2 {
            mass += m[half];
            let moments = moments(m[half], [x[half], y[half], z[half]], [u[half], v[half], w[half]]);
            for i in 0..MOMENTS {
                total[i] += moments[i];
            }
        }
    }
    let mut sums = Sums { mass: across(mass), moments: [0.0; MOMENTS] };
    for i in 0..MOMENTS {
        sums.moments[i] = across(total[i]);
    }
    sums
}

#[inline(always)]
fn halves<S: Simd>(simd: S, row: f32x8<S>) -> [f64x4<S>; 2] {
    let (low, high) = simd.widen_f32x8(row);
    [low, high]
}

#[inline(always)]
fn across<S: Simd>(lanes: f64x4<S>) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

fn sum_by_component(fields: Fields, components: &Components, blocks: Range<usize>, sums: &mut [Sums]) {
    for slot in blocks.start * LANES..blocks.end * LANES {
        let [m, share, ..] = fields.constants.get(slot as u32);
        if share > 0.0 {
            let m = f64::from(m);
            let x = fields.positions.get(slot as u32).map(f64::from);
            let v = fields.velocities.get(slot as u32).map(f64::from);
            sums[components.of(slot as u32)].add(&Sums { mass: m, moments: moments(m, x, v) });
        }
    }
}
