//! Integration: v += alpha (g - x)/h + h a, then x += h v (Mueller et al. 2005, eq. 9).
//!
//! A step moves a slow body by less than an ulp of its f32 positions, so each position carries the part that was
//! rounded away to the next step (Kahan 1965): a position is `positions` + `compensation`.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, dispatch, f32x8, mask32x8};

use super::momentum::{self, Components, Fields, RigidVelocity, Sums};
use crate::matching::VertexUpdate;
use crate::parallel::Executor;
use crate::simd::lanes::{Block, LANES, Lanes, Row, load, store};
use crate::simd::level;

/// v += alpha (g - x)/h + h a: the goal position g of a vertex is (1/n) Σ over its regions, which the adjoint gathers.
pub(crate) struct Accelerate<'a> {
    pub(crate) weights: &'a Lanes<2>,
    pub(crate) positions: &'a Lanes<3>,
    /// alpha/h, in 1/s.
    pub(crate) stiffness_rate: f32,
    /// h a, of the acceleration that all vertices share, in cells/s.
    pub(crate) gain: [f32; 3],
    /// The components whose momenta are summed; `None` sums nothing.
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
        let (weights, positions) = (&self.weights.blocks()[blocks.clone()], &self.positions.blocks()[blocks]);
        let zero = f32x8::splat(simd, 0.0);
        let vertices = weights.iter().zip(positions).zip(region_sums).zip(&mut *velocities);
        for (((weights, positions), region_sums), velocities) in vertices {
            let [_, share] = load(simd, weights);
            let held = share.simd_gt(zero);
            let (x, region_sums): ([f32x8<S>; 3], [f32x8<S>; 3]) =
                (load(simd, positions), load(simd, region_sums));
            let mut v: [f32x8<S>; 3] = load(simd, velocities);
            for c in 0..3 {
                let gain = held.select(f32x8::splat(simd, self.gain[c]), zero);
                let residual = region_sums[c].mul_add(share, -x[c]);
                v[c] = residual.mul_add(self.stiffness_rate, v[c] + gain);
            }
            store(v, velocities);
        }
        if let Some(components) = self.components {
            momentum::add(simd, components, first, Fields { weights, positions, velocities }, sums);
        }
    }
}

/// x += h v, after v += the rigid velocity that the component of the vertex lacks.
pub(crate) struct Advance<'a> {
    /// The lanes of each block that hold a vertex, as bits.
    pub(crate) occupied: &'a [u8],
    pub(crate) components: &'a Components,
    pub(crate) corrections: &'a [RigidVelocity],
    /// Seconds.
    pub(crate) dt: f64,
}

impl Advance<'_> {
    /// Moves all vertices.
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
                    self.correct(simd, first + at, x, v);
                    advance(simd, self.dt, x, low, v);
                }
            });
        });
    }

    #[inline(always)]
    fn correct<S: Simd>(&self, simd: S, block: usize, positions: &Block<3>, velocities: &mut Block<3>) {
        let zero = f32x8::splat(simd, 0.0);
        let held = mask32x8::from_bitmask(simd, u64::from(self.occupied[block]));
        let (linear, omega): ([f32x8<S>; 3], [f32x8<S>; 3]) = match self.components {
            Components::One => {
                let RigidVelocity { linear: [u, v, w], angular: [p, q, r] } = self.corrections[0];
                let all = |value| f32x8::splat(simd, value);
                ([all(u), all(v), all(w)], [all(p), all(q), all(r)])
            }
            components @ Components::Several(_) => {
                let (mut linear, mut angular) = ([Row::ZERO; 3], [Row::ZERO; 3]);
                for lane in 0..LANES {
                    let rigid = &self.corrections[components.of((block * LANES + lane) as u32)];
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
        for c in 0..3 {
            let (next, last) = ((c + 1) % 3, (c + 2) % 3);
            let turn = omega[next] * x[last] - omega[last] * x[next];
            v[c] += held.select(linear[c] + turn, zero);
        }
        store(v, velocities);
    }
}

/// x += dt v, dt in two parts so that its own rounding adds up to nothing either.
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
        let motion = v.mul_add(high, v.mul_add(low, f32x8::load_array_ref(simd, compensation_row)));
        let moved = x + motion;
        (motion - (moved - x)).store_array(compensation_row);
        moved.store_array(x_row);
    }
}
