//! Damps velocities by regions: moves the velocity of each vertex towards v̄, the mean of the rigid
//! velocities of the regions that contain the vertex.
//!
//! As in Rivers & James (2007, section 5), the rigid velocity of a region is fitted with the region weights
//! of shape matching. Here the local-moment cascade sums the velocities times the lattice offsets from the
//! center vertex, so that no digits cancel far from the origin. The inertia of a region is its rest inertia,
//! rotated by the rotation of the region, so that it is never singular. A region with a plastic shape has the lever
//! arms and the inertia of this shape.

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8};

use super::integration::inverse_and_rate;
use crate::matching::{
    Factors, InverseCovariances, Matching, Means, Purpose, RegionTransform, Regions, VertexUpdate, Weighted,
    Workspace, columns, full, inverse, scale, shape, times,
};
use crate::parallel::Executor;
use crate::simd::lanes::{Block, Lanes, load, store};
use crate::simd::vector::{Product, cross, dot};

/// The region-damping stage.
#[derive(Clone, Debug)]
pub(crate) struct RegionDamper {
    /// Inverse of the rest inertia divided by the mass, for each region: xx, yy, zz, xy, xz, yz.
    inverse_inertia: Lanes<6>,
    /// k of the volume term if it counts: see [`with_bulk`](Self::with_bulk).
    bulk: f32,
}

/// The state on which region damping acts.
pub(crate) struct MovingRegions<'a> {
    /// The rotations of the last fit of shape matching.
    pub(crate) rotations: &'a Lanes<4>,
    /// S - 1 of the plastic shapes S of the regions.
    pub(crate) strains: Option<&'a Lanes<6>>,
    pub(crate) velocities: &'a mut Lanes<3>,
}

impl RegionDamper {
    /// Creates the stage for the regions of `matching`.
    pub(crate) fn new(matching: &Matching) -> Self {
        Self { inverse_inertia: matching.regions.inverse_inertia(&matching.layout), bulk: 0.0 }
    }

    /// Adds the volume term of the regions, so that the stage computes small displacements towards the goal positions
    /// from small displacements at rest: the motion of a region loses k/3 tr(δF) D.
    pub(crate) fn with_bulk(self, matching: &Matching) -> Self {
        Self { bulk: matching.regions.bulk, ..self }
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.inverse_inertia.bytes()
    }

    /// Moves the velocities v towards the mean rigid velocities of the regions: v += `fraction` (v̄ - v).
    ///
    /// `fraction` is in (0, 1]. With stiffness `factors`, v̄ is weighted by them, and the fraction of each vertex is
    /// multiplied by its own factor.
    pub(crate) fn apply(
        &self,
        matching: &Matching,
        workspace: &mut Workspace,
        executor: &Executor,
        MovingRegions { rotations, strains, velocities }: MovingRegions<'_>,
        (fraction, factors): (f32, Option<&Factors>),
    ) {
        let Matching { layout, regions, cascade } = matching;
        let Regions { constants, weights, .. } = regions;
        let field = Weighted { weights: regions.vector_weights(), vectors: velocities.blocks() };
        let inverse_inertia = &self.inverse_inertia;
        let covariances = regions.inverse_covariances.as_ref().filter(|_| self.bulk != 0.0);
        let bulk = covariances.map(|covariances| (covariances, self.bulk));
        let fit = FitVelocities { constants, inverse_inertia, bulk, rotations, strains, factors };
        cascade.forward(layout, executor, workspace, field, (&fit, ()), Purpose::Vertices);
        let update = Damp { weights, fraction, factors };
        cascade.adjoint(layout, executor, workspace, &update, velocities.blocks_mut(), &mut []);
    }
}

/// The region transform that fits a rigid velocity to each region: the rigid velocity with the linear and
/// angular momentum of the region.
struct FitVelocities<'a> {
    /// 1/M of each region, and d, its rest centroid relative to its center vertex.
    constants: &'a Lanes<4>,
    /// As in [`RegionDamper`].
    inverse_inertia: &'a Lanes<6>,
    /// The rest covariances and k, if the volume term counts. The rotations are then the identity.
    bulk: Option<(&'a InverseCovariances, f32)>,
    rotations: &'a Lanes<4>,
    /// S - 1 of the plastic shapes S.
    strains: Option<&'a Lanes<6>>,
    factors: Option<&'a Factors>,
}

impl RegionTransform<()> for FitVelocities<'_> {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], (): ()) {
        for (block, sums) in (first..).zip(sums) {
            let motion = self.fit(simd, block, load(simd, sums));
            store(motion, sums);
            if let Some(factors) = self.factors {
                scale(simd, factors.of_regions(block), sums);
            }
        }
    }
}

impl FitVelocities<'_> {
    /// Computes the rigid velocity field of each region of a block: its value v - ω × R d at the center
    /// vertex, and its changes ω × R eⱼ per link along the axes j, with the unit vectors eⱼ.
    ///
    /// S, Sx, Sy and Sz are the sums of the velocities over the region, M is its mass, d its rest centroid, R
    /// its rotation, and J its rest inertia divided by M. v = S/M is the mean velocity. The columns Bⱼ of
    /// B = [Sx Sy Sz]/M - v dᵀ are the first moments of the velocities with respect to the rest offsets
    /// y = (i, j, k) - d. So the angular momentum divided by M is l = Σⱼ (R eⱼ) × Bⱼ, and the angular
    /// velocity is ω = R J⁻¹ Rᵀ l. With a plastic shape S, the lever arms are R S y: R S takes the place of R where it
    /// multiplies eⱼ, and the inertia of S y multiplies J. A region in its rest shape gets the same bits as without
    /// plasticity.
    #[inline(always)]
    fn fit<S: Simd>(&self, simd: S, block: usize, sums: [f32x8<S>; 12]) -> [f32x8<S>; 12] {
        let zero = f32x8::splat(simd, 0.0);
        let constants = load(simd, &self.constants.blocks()[block]);
        let Means { mean: v, central, d } = Means::new(constants, sums);
        let r: [f32x8<S>; 9] = columns(simd, load(simd, &self.rotations.blocks()[block]));
        let axes = [[r[0], r[1], r[2]], [r[3], r[4], r[5]], [r[6], r[7], r[8]]];
        let (mut inverse_inertia, mut arms) = (load(simd, &self.inverse_inertia.blocks()[block]), axes);
        if let Some(strains) = self.strains {
            let t: [f32x8<S>; 6] = load(simd, &strains.blocks()[block]);
            let mut greatest = t[0].abs();
            for i in 1..6 {
                greatest = greatest.max(t[i].abs());
            }
            let is_shaped = greatest.simd_gt(zero);
            if is_shaped.any_true() {
                let g = times(&r, shape(simd, t));
                arms = [[g[0], g[1], g[2]], [g[3], g[4], g[5]], [g[6], g[7], g[8]]];
                let plastic = inverse(simd, plastic_inertia(simd, inverse_inertia, t));
                for i in 0..6 {
                    inverse_inertia[i] = is_shaped.select(plastic[i], inverse_inertia[i]);
                }
            }
        }

        let mut angular = [zero; 3];
        for j in 0..3 {
            let moment = [central[3 * j], central[3 * j + 1], central[3 * j + 2]];
            let [x, y, z] = cross(arms[j], moment);
            angular = [angular[0] + x, angular[1] + y, angular[2] + z];
        }
        let [xx, yy, zz, xy, xz, yz] = inverse_inertia;
        let (a, b, c) = (dot(axes[0], angular), dot(axes[1], angular), dot(axes[2], angular));
        let rest_omega = [xx * a + xy * b + xz * c, xy * a + yy * b + yz * c, xz * a + yz * b + zz * c];
        let mut omega = [zero; 3];
        for c in 0..3 {
            omega[c] = axes[0][c] * rest_omega[0] + axes[1][c] * rest_omega[1] + axes[2][c] * rest_omega[2];
        }

        // The changes of the rigid velocity per link along x, y and z.
        let (mut x, mut y, mut z) = (cross(omega, arms[0]), cross(omega, arms[1]), cross(omega, arms[2]));
        if let Some((covariances, k)) = self.bulk {
            let covariance = covariances.load(simd, block);
            let gradient = times(&central, covariance);
            let t = covariance[0] + covariance[1] + covariance[2];
            // k/3 tr(δF) D with D = 3 C⁻¹/tr C⁻¹; zero for regions without an inverse covariance.
            let share = (gradient[0] + gradient[4] + gradient[8]) * k / t;
            let share = t.simd_gt(zero).select(share, zero);
            let d = full(covariance);
            for c in 0..3 {
                x[c] -= share * d[c];
                y[c] -= share * d[3 + c];
                z[c] -= share * d[6 + c];
            }
        }
        let mut b = v;
        for c in 0..3 {
            b[c] -= x[c] * d[0] + y[c] * d[1] + z[c] * d[2];
        }
        [b[0], b[1], b[2], x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]]
    }
}

/// Computes the inertia divided by the mass of regions in plastic shapes S: tr(S C S) - S C S, with the rest
/// covariance C and S = 1 + `t`. The rest inertia J = tr(C) - C gives C = tr(J)/2 - J: in contrast to C, it has an
/// inverse in regions that a crack left planar.
#[inline(always)]
fn plastic_inertia<S: Simd>(simd: S, inverse_inertia: [f32x8<S>; 6], t: [f32x8<S>; 6]) -> [f32x8<S>; 6] {
    let j = inverse(simd, inverse_inertia);
    let half_trace = (j[0] + j[1] + j[2]) * 0.5;
    let c = [half_trace - j[0], half_trace - j[1], half_trace - j[2], -j[3], -j[4], -j[5]];
    let s = shape(simd, t);
    let p = times(&times(&full(s), c), s);
    [p[4] + p[8], p[0] + p[8], p[0] + p[4], -p[3], -p[6], -p[7]]
}

/// The vertex update v += `fraction` (v̄ - v), where v̄ is 1/n times the sum of the rigid velocities of the n
/// regions that contain the vertex.
struct Damp<'a> {
    /// m and 1/n of each vertex.
    weights: &'a Lanes<2>,
    fraction: f32,
    factors: Option<&'a Factors>,
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
            let (weights, factors) = (&self.weights.blocks()[block], self.factors);
            let factors = factors.map(|factors| &factors.vertices.blocks()[block]);
            let (inverse, fraction) = inverse_and_rate(simd, weights, factors, self.fraction);
            let region_sums: [f32x8<S>; 3] = load(simd, region_sums);
            let mut v: [f32x8<S>; 3] = load(simd, velocities);
            for c in 0..3 {
                v[c] = region_sums[c].times_plus(inverse, -v[c]).times_plus(fraction, v[c]);
            }
            store(v, velocities);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Point3, Vector3};

    use super::*;
    use crate::lattice::{Joint, Lattice};
    use crate::matching::symmetric;
    use crate::state::IDENTITIES;

    /// Returns a block with random slits and the stage of plastic matching: the first one in which regions at the
    /// fronts are planar, and none is a line.
    fn slit_block() -> (Lattice, Matching) {
        let cells: Vec<[i32; 3]> = (0..4 * 4 * 4).map(|k| [k % 4, k / 4 % 4, k / 16]).collect();
        let whole = Lattice::from_cells(&cells, 1.0, Point3::origin(), false).unwrap();
        let with_slits = |seed: u64| {
            let is_slit = |(number, _): &(u64, Joint)| {
                (seed * 1000 + number).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 60 < 3
            };
            let joints = (0..).zip(whole.joints().map(|(joint, _)| joint)).filter(is_slit);
            let lattice = whole.with_broken_joints(&joints.map(|(_, joint)| joint).collect::<Vec<_>>());
            let mut matching = Matching::new(&lattice, &vec![1.0; lattice.len()].into(), 1.into());
            matching.set_covariances(true);
            (lattice, matching)
        };
        let zeros = |matching: &Matching, get: &dyn Fn(u32) -> [f32; 6]| {
            matching.layout.slots().iter().filter(|&&slot| get(slot) == [0.0; 6]).count()
        };
        let is_wanted = |(_, matching): &(Lattice, Matching)| {
            let covariances = matching.regions.inverse_covariances.as_ref().unwrap();
            let inverse_inertia = RegionDamper::new(matching).inverse_inertia;
            zeros(matching, &|slot| covariances.get(slot)) > 0
                && zeros(matching, &|slot| inverse_inertia.get(slot)) == 0
        };
        (0..1000).map(with_slits).find(is_wanted).expect("slits with planar regions at their fronts")
    }

    /// Damps velocities by the factor 1. `strain`: of all regions.
    fn damped(
        matching: &Matching,
        strain: Option<[f32; 6]>,
        velocity: impl Fn(usize) -> Vector3<f64>,
    ) -> Lanes<3> {
        let blocks = matching.layout.blocks();
        let (mut velocities, mut strains) = (Lanes::zeros(blocks), Lanes::zeros(blocks));
        for (vertex, &slot) in matching.layout.slots().iter().enumerate() {
            velocities.set(slot, velocity(vertex).map(|v| v as f32).into());
            strain.into_iter().for_each(|strain| strains.set(slot, strain));
        }
        let (rotations, executor) = (Lanes::filled(blocks, IDENTITIES), Executor::sequential());
        let data = MovingRegions {
            rotations: &rotations,
            strains: strain.map(|_| &strains),
            velocities: &mut velocities,
        };
        let mut workspace = matching.cascade.workspace();
        RegionDamper::new(matching).apply(matching, &mut workspace, &executor, data, (1.0, None));
        velocities
    }

    /// A rigid motion of a body whose plastic shapes are all the same is not damped, also at the fronts of slits.
    #[test]
    fn spin_of_a_plastic_body_with_slits_is_not_damped() {
        let (lattice, matching) = slit_block();
        let spin = Vector3::new(0.3, -0.2, 0.5);
        // S stretches along x and y + z, and has the determinant 1.
        let shape = Matrix3::<f64>::new(1.25, 0.0, 0.0, 0.0, 1.0, 0.2, 0.0, 0.2, 0.84);
        assert!((shape.determinant() - 1.0).abs() < 1e-6);
        let strain = [0.25, 0.0, -0.16, 0.0, 0.0, 0.2];
        assert!((symmetric(strain) + Matrix3::identity() - shape).norm() < 1e-6);
        for (strain, shape) in [(None, Matrix3::identity()), (Some(strain), shape)] {
            let velocity = |vertex: usize| {
                let index = Vector3::from(lattice.indices()[vertex].map(f64::from));
                spin.cross(&(shape * index)) + Vector3::new(1.0, 2.0, 3.0)
            };
            let velocities = damped(&matching, strain, velocity);
            for (vertex, &slot) in matching.layout.slots().iter().enumerate() {
                let error = (Vector3::from(velocities.get(slot).map(f64::from)) - velocity(vertex)).norm();
                // Speeds of up to 8, and sums over 27 vertices, in f32.
                assert!(error < 2e-5, "vertex {vertex}, {strain:?}: {error:e}");
            }
        }
    }

    #[test]
    fn regions_in_their_rest_shape_are_damped_as_without_plasticity() {
        let (lattice, matching) = slit_block();
        let velocity = |vertex: usize| {
            let [x, y, z] = lattice.indices()[vertex].map(f64::from);
            Vector3::new(libm::sin(x * y), libm::cos(y + 2.0 * z), libm::sin(x - z))
        };
        assert_eq!(damped(&matching, Some([0.0; 6]), velocity), damped(&matching, None, velocity));
    }
}
