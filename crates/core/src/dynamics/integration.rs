//! Integrates the motion of the vertices: v += alpha (g - x)/h + h a, then x += h v (Müller et al. 2005, Eqs.
//! (9) and (10)). x, v and g are the position, velocity and goal position of a vertex, h is the step length,
//! a is the acceleration of all vertices, and alpha is the stiffness.
//!
//! In one step, a slow body can move by less than an ulp of its f32 positions. So the sum over the steps is
//! compensated (Kahan 1965): the rounding error of each f32 position is stored in `compensation`, and the
//! exact position is `positions` + `compensation`.

use fearless_simd::{Select, Simd, SimdBase, SimdMask, dispatch, f32x8, mask32x8};

use super::elastic_damping::Damped;
use super::momentum::{self, Components, Fields, RigidVelocity, Sums};
use crate::matching::{Factors, VertexUpdate};
use crate::parallel::Executor;
use crate::simd::lanes::{Block, LANES, Lanes, Row, load, store};
use crate::simd::level;
use crate::simd::vector::Product;

/// The vertex update v += alpha (g - x)/h + h a, after damping. The goal position g of a vertex is 1/n times a sum over
/// the n regions that contain the vertex; the adjoint of the cascade computes this sum. With stiffness factors, g is
/// the mean weighted by them, and alpha is multiplied by the factor of the vertex.
pub(crate) struct Accelerate<'a> {
    /// m and 1/n of each vertex.
    pub(crate) weights: &'a Lanes<2>,
    /// `None` if the stiffness does not vary.
    pub(crate) factors: Option<&'a Factors>,
    pub(crate) positions: &'a Lanes<3>,
    /// alpha/h, in 1/s.
    pub(crate) stiffness_rate: f32,
    /// Damping of the velocities before the step, with the connected components and, for each block, the bit mask of
    /// the lanes with a vertex. `None` without damping.
    pub(crate) damping: Option<(&'a Damped, &'a Components, &'a [u8])>,
    /// Share of each vertex in the damping; `None` if all are 1.
    pub(crate) shares: Option<&'a Lanes<1>>,
    /// h a, the velocity change of all vertices by the acceleration a, in cells/s.
    pub(crate) velocity_change: [f32; 3],
    /// Connected components whose momenta are summed after the update. If `None`, no momenta are summed.
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
        region_sums: &[Block<3>],
        velocities: &mut [Block<3>],
        sums: &mut [Sums],
    ) {
        let blocks = first..first + velocities.len();
        if let Some((Damped { keep, rigid }, components, occupied)) = self.damping {
            let positions = &self.positions.blocks()[blocks.clone()];
            for (at, (x, v)) in positions.iter().zip(&mut *velocities).enumerate() {
                let (block, rigid) = (first + at, (components, &rigid[..]));
                correct(simd, *keep, (block, occupied[block]), rigid, (x, v, self.shares));
            }
        }
        let (weights, positions) = (&self.weights.blocks()[blocks.clone()], &self.positions.blocks()[blocks]);
        let zero = f32x8::splat(simd, 0.0);
        let vertices = weights.iter().zip(positions).zip(region_sums).zip(&mut *velocities).enumerate();
        for (at, (((weights, positions), region_sums), velocities)) in vertices {
            let factors = self.factors.map(|factors| &factors.vertices.blocks()[first + at]);
            let (inverse, stiffness_rate) = inverse_and_rate(simd, weights, factors, self.stiffness_rate);
            let occupied = inverse.simd_gt(zero);
            let (x, region_sums): ([f32x8<S>; 3], [f32x8<S>; 3]) =
                (load(simd, positions), load(simd, region_sums));
            let mut v: [f32x8<S>; 3] = load(simd, velocities);
            for c in 0..3 {
                let velocity_change = occupied.select(f32x8::splat(simd, self.velocity_change[c]), zero);
                let residual = region_sums[c].times_plus(inverse, -x[c]);
                v[c] = residual.times_plus(stiffness_rate, v[c] + velocity_change);
            }
            store(v, velocities);
        }
        if let Some(components) = self.components {
            momentum::add(simd, components, first, Fields { weights, positions, velocities }, sums);
        }
    }
}

/// Returns 1/n of the vertices of a block with m and 1/n, and a rate. `factors`: the stiffness factors of the vertices,
/// with the inverse sums of the factors of their regions. With them, the latter take the place of 1/n, and the rate is
/// multiplied by the former.
#[inline(always)]
pub(super) fn inverse_and_rate<S: Simd>(
    simd: S,
    weights: &Block<2>,
    factors: Option<&Block<2>>,
    rate: f32,
) -> (f32x8<S>, f32x8<S>) {
    let rate = f32x8::splat(simd, rate);
    match factors {
        None => {
            let [_, inverse] = load(simd, weights);
            (inverse, rate)
        }
        Some(factors) => {
            let [factor, inverse] = load(simd, factors);
            (inverse, factor * rate)
        }
    }
}

/// The update x += h v, after the momentum correction: a rigid velocity of the connected component is added to v.
pub(crate) struct Advance<'a> {
    /// For each block, the bit mask of the lanes with a vertex.
    pub(crate) occupied: &'a [u8],
    pub(crate) components: &'a Components,
    /// For each component, the rigid velocity that is added to its vertices.
    pub(crate) corrections: &'a [RigidVelocity],
    /// Time step in seconds.
    pub(crate) dt: f64,
}

impl Advance<'_> {
    /// Updates the velocities and the positions of all vertices. `compensation` has the rounding errors of
    /// the positions.
    pub(crate) fn run(
        &self,
        executor: &Executor,
        positions: &mut Lanes<3>,
        compensation: &mut Lanes<3>,
        velocities: &mut Lanes<3>,
    ) {
        let arrays = (positions.blocks_mut(), compensation.blocks_mut(), velocities.blocks_mut());
        executor.chunks3(arrays, |first, positions, compensation, velocities| {
            dispatch!(level(), simd => {
                for (at, ((x, low), v)) in positions.iter_mut().zip(compensation).zip(velocities).enumerate() {
                    let occupied = self.occupied[first + at];
                    let rigid = (self.components, self.corrections);
                    correct(simd, 1.0, (first + at, occupied), rigid, (x, v, None));
                    advance(simd, self.dt, x, low, v);
                }
            });
        });
    }
}

/// Adds to the field `velocities` the rigid velocity of the component of each vertex. `occupied` has, for each block,
/// the bit mask of the lanes with a vertex, and `shares` the share of each vertex in the velocity; `None` if all are 1.
pub(crate) fn add_rigid(
    components: &Components,
    rigid: &[RigidVelocity],
    (occupied, shares): (&[u8], Option<&Lanes<1>>),
    positions: &Lanes<3>,
    velocities: &mut Lanes<3>,
) {
    let blocks = positions.blocks().iter().zip(velocities.blocks_mut()).zip(occupied).enumerate();
    dispatch!(level(), simd => {
        for (block, ((x, v), &occupied)) in blocks {
            correct(simd, 1.0, (block, occupied), (components, rigid), (x, v, shares));
        }
    });
}

/// Multiplies the velocities of a block by `keep`, and adds the rigid velocity of the component of each vertex.
/// `occupied` is the bit mask of the lanes with a vertex. With `shares`, each velocity changes by its share of this.
#[inline(always)]
fn correct<S: Simd>(
    simd: S,
    keep: f32,
    (block, occupied): (usize, u8),
    (components, rigid): (&Components, &[RigidVelocity]),
    (positions, velocities, shares): (&Block<3>, &mut Block<3>, Option<&Lanes<1>>),
) {
    let zero = f32x8::splat(simd, 0.0);
    let occupied = mask32x8::from_bitmask(simd, u64::from(occupied));
    let (linear, omega): ([f32x8<S>; 3], [f32x8<S>; 3]) = match components {
        Components::One => {
            let RigidVelocity { linear: [u, v, w], angular: [p, q, r] } = rigid[0];
            let all = |value| f32x8::splat(simd, value);
            ([all(u), all(v), all(w)], [all(p), all(q), all(r)])
        }
        components @ Components::Several(_) => {
            let (mut linear, mut angular) = ([Row::ZERO; 3], [Row::ZERO; 3]);
            for lane in 0..LANES {
                let rigid = &rigid[components.of_slot((block * LANES + lane) as u32)];
                for c in 0..3 {
                    linear[c][lane] = rigid.linear[c];
                    angular[c][lane] = rigid.angular[c];
                }
            }
            (load(simd, &linear), load(simd, &angular))
        }
    };
    let x: [f32x8<S>; 3] = load(simd, positions);
    let mut v: [f32x8<S>; 3] = load(simd, velocities);
    let share = shares.map(|shares| load(simd, &shares.blocks()[block])).map(|[share]: [f32x8<S>; 1]| share);
    for c in 0..3 {
        let (next, last) = ((c + 1) % 3, (c + 2) % 3);
        let rotational = omega[next] * x[last] - omega[last] * x[next];
        let corrected = v[c].times_plus(keep, occupied.select(linear[c] + rotational, zero));
        v[c] = share.map_or(corrected, |share| share.times_plus(corrected - v[c], v[c]));
    }
    store(v, velocities);
}

/// Computes x += dt v for a block, with compensated summation. dt is represented as the sum of two f32
/// numbers, so that the rounding error of dt does not accumulate.
#[inline(always)]
fn advance<S: Simd>(
    simd: S,
    dt: f64,
    positions: &mut Block<3>,
    compensation: &mut Block<3>,
    velocities: &Block<3>,
) {
    let high = dt as f32;
    let low = (dt - f64::from(high)) as f32;
    let (high, low) = (f32x8::splat(simd, high), f32x8::splat(simd, low));
    for ((x_row, compensation_row), v_row) in positions.iter_mut().zip(compensation).zip(velocities) {
        let x = f32x8::load_array_ref(simd, x_row);
        let v = f32x8::load_array_ref(simd, v_row);
        let motion = v.times_plus(high, v.times_plus(low, f32x8::load_array_ref(simd, compensation_row)));
        let moved = x + motion;
        (motion - (moved - x)).store_array(compensation_row);
        moved.store_array(x_row);
    }
}
