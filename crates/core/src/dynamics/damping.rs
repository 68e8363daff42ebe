//! Region damping: moves the velocities towards the averaged rigid velocities of the regions.
//!
//! As in Rivers & James (2007, section 5), the rigid velocities of the regions are averaged with the weights
//! of the shape matching. Here the local-moment cascade sums the velocities against the lattice offsets in
//! the window, so no digits cancel far from the origin. The inertia is the rest inertia, rotated by the
//! region's rotation, so it is never singular.

use fearless_simd::{Simd, SimdBase, SimdFloat, f32x8};

use crate::matching::{
    Matching, Means, Purpose, RegionTransform, Regions, VertexUpdate, Weighted, Workspace, columns,
};
use crate::parallel::Executor;
use crate::simd::lanes::{Block, Lanes, load, store};
use crate::simd::vector::{cross, dot};
use crate::state::State;

/// The stage of region damping, with the inverse rest inertia of the regions.
#[derive(Clone, Debug)]
pub(crate) struct RegionDamper {
    inverse_inertia: Lanes<6>,
}

impl RegionDamper {
    /// Creates the stage for the regions of `matching`.
    pub(crate) fn new(matching: &Matching) -> Self {
        Self { inverse_inertia: matching.regions.inverse_inertia(&matching.layout) }
    }

    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.inverse_inertia.bytes()
    }

    /// Moves the velocities towards the averaged rigid velocities of the regions: v += share (v̄ - v).
    ///
    /// v̄ is the mean rigid velocity of the regions that contain the vertex. Uses the rotations of the last
    /// fit. `share` is in (0, 1].
    pub(crate) fn apply(
        &self,
        matching: &Matching,
        workspace: &mut Workspace,
        executor: &Executor,
        state: &mut State,
        share: f32,
    ) {
        let Matching { layout, regions, cascade } = matching;
        let State { rotations, velocities, .. } = state;
        let Regions { constants, weights, .. } = regions;
        let field = Weighted { weights: weights.blocks(), vectors: velocities.blocks() };
        let fit = FitVelocities { constants, inverse_inertia: &self.inverse_inertia, rotations };
        // A vector of `()` does not allocate.
        let memory = &mut vec![(); layout.blocks()];
        cascade.forward(layout, executor, workspace, field, (&fit, memory), Purpose::Goals);
        let update = Damp { weights, share };
        cascade.adjoint(layout, executor, workspace, &update, velocities.blocks_mut(), &mut []);
    }
}

/// Fits to each region the rigid velocity that has its linear and angular momentum.
struct FitVelocities<'a> {
    constants: &'a Lanes<4>,
    inverse_inertia: &'a Lanes<6>,
    rotations: &'a Lanes<4>,
}

impl RegionTransform for FitVelocities<'_> {
    type Memory = ();

    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], _: &mut [()]) {
        for (block, sums) in (first..).zip(sums) {
            let motion = self.fit(simd, block, load(simd, sums));
            store(motion, sums);
        }
    }
}

impl FitVelocities<'_> {
    /// Computes the rigid velocity field of each region: its value v - ω x R d at the center vertex, and the
    /// columns ω x R eⱼ.
    ///
    /// v = S/M is the mean velocity. B = [Sx Sy Sz]/M - v dᵀ has the first moments of the velocities against
    /// the rest offsets y = (i, j, k) - d, so the angular momentum over M is l = Σⱼ (R eⱼ) x Bⱼ. With the
    /// rest inertia J over M, ω = R J⁻¹ Rᵀ l.
    #[inline(always)]
    fn fit<S: Simd>(&self, simd: S, block: usize, sums: [f32x8<S>; 12]) -> [f32x8<S>; 12] {
        let zero = f32x8::splat(simd, 0.0);
        let constants = load(simd, &self.constants.blocks()[block]);
        let Means { mean: v, central, d } = Means::new(constants, sums);
        let r: [f32x8<S>; 9] = columns(simd, load(simd, &self.rotations.blocks()[block]));
        let axes = [[r[0], r[1], r[2]], [r[3], r[4], r[5]], [r[6], r[7], r[8]]];

        let mut angular = [zero; 3];
        for j in 0..3 {
            let moment = [central[3 * j], central[3 * j + 1], central[3 * j + 2]];
            let [x, y, z] = cross(axes[j], moment);
            angular = [angular[0] + x, angular[1] + y, angular[2] + z];
        }
        let [xx, yy, zz, xy, xz, yz] = load(simd, &self.inverse_inertia.blocks()[block]);
        let (a, b, c) = (dot(axes[0], angular), dot(axes[1], angular), dot(axes[2], angular));
        let rest_omega = [xx * a + xy * b + xz * c, xy * a + yy * b + yz * c, xz * a + yz * b + zz * c];
        let mut omega = [zero; 3];
        for c in 0..3 {
            omega[c] = axes[0][c] * rest_omega[0] + axes[1][c] * rest_omega[1] + axes[2][c] * rest_omega[2];
        }

        let (x, y, z) = (cross(omega, axes[0]), cross(omega, axes[1]), cross(omega, axes[2]));
        let mut b = v;
        for c in 0..3 {
            b[c] -= x[c] * d[0] + y[c] * d[1] + z[c] * d[2];
        }
        [b[0], b[1], b[2], x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]]
    }
}

/// The vertex update v += share (v̄ - v), with v̄ = (1/n) Σ over the regions that contain the vertex.
struct Damp<'a> {
    weights: &'a Lanes<2>,
    share: f32,
}

impl VertexUpdate for Damp<'_> {
    type Memory = Block<3>;
    type Tally = ();

    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        region_sums: &[Block<3>],
        velocities: &mut [Block<3>],
        _: &mut [()],
    ) {
        for ((block, region_sums), velocities) in (first..).zip(region_sums).zip(velocities) {
            let [_, inverse_count] = load(simd, &self.weights.blocks()[block]);
            let region_sums: [f32x8<S>; 3] = load(simd, region_sums);
            let mut v: [f32x8<S>; 3] = load(simd, velocities);
            for c in 0..3 {
                v[c] = region_sums[c].mul_add(inverse_count, -v[c]).mul_add(self.share, v[c]);
            }
            store(v, velocities);
        }
    }
}
