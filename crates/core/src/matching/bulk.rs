//! The volume term of the fit of regions, which gives a body its Poisson's ratio.
//!
//! C = M⁻¹ Σ m/n y yᵀ is the rest covariance of a region, F = A C⁻¹ its deformation gradient (see
//! [`plastic`](super::plastic)), t = tr C⁻¹/3 and D = C⁻¹/t. K is the cofactor matrix of F, and J = det F. Beside the
//! distance to a rigid motion, the elastic potential of a region has the term k W/t, times alpha M/dt², with
//!
//! ```text
//! W = d²/(2 (q + 4 d²))      d = J - 1      q = K : K D
//! ```
//!
//! W is half of the squared distance to the nearest map without a change of volume, to first order. It is at most
//! 1/8, so that a region that is crushed or inverted returns by its rotation, and smooth for every F. Its gradient is
//! P D with
//!
//! ```text
//! P = r (q K - d Z)      r = d/(q + 4 d²)²      Z = (K D) × F
//! ```
//!
//! where × is the product of which the cofactors are the half: 2 K = F × F. A region then moves its vertices by T = R -
//! k Y in place of R, with Y = P D. P Fᵀ is symmetric, so that the term exerts no torque. With k = 3 ν/(1 - 2 ν),
//! Poisson's ratio is ν, the shear modulus as for k = 0, and the bulk modulus 1 + k times the one for k = 0. The second
//! derivatives of W in the metric C are at most 1.76, so that alpha (1 + k) <= 1.5 keeps a step stable.
//!
//! A region that is inflated to s times its volume is σ = ∛s times as long at rest. Its potential is that of F/σ,
//! times σ², so that T = σ (R - k Y(F/σ)). Its frequencies do not depend on s.

use fearless_simd::{Select, Simd, SimdBase, f32x16};

use super::algebra::{inverse, times};
use super::cascade::RegionTransform;
use super::covariances::InverseCovariances;
use super::goals::{FitRotations, Pair, twice_trace};
use super::rotation::columns;
use crate::simd::lanes::{Block, Lanes};
use crate::simd::vector::Product;

/// Sizes q + 4 d² from here on have no volume term: their squares come near the greatest f32.
const GREATEST_SIZE: f32 = 1e15;

/// Returns k = 3 ν/(1 - 2 ν) of a Poisson's ratio ν, in [0, 0.5).
pub(crate) fn bulk_of(poisson_ratio: f64) -> f64 {
    3.0 * poisson_ratio / (1.0 - 2.0 * poisson_ratio)
}

/// The ratio s of the rest volume around each lattice vertex to its volume in the lattice.
pub(crate) enum VolumeRatios<'a> {
    /// The same around all vertices.
    Uniform(f64),
    /// One for each vertex.
    Vertices(&'a dyn Fn(usize) -> f64),
}

/// The rest volumes of the regions, and how strongly they keep them.
#[derive(Clone, Copy)]
pub(super) struct RestVolumes<'a> {
    pub(super) inverse_covariances: &'a InverseCovariances,
    /// k, or 0 without a volume term.
    pub(super) bulk: f32,
    /// σ of each region; `None` if none is inflated.
    pub(super) inflation: Option<&'a Lanes<1>>,
}

impl RestVolumes<'_> {
    /// Returns σ of the regions of two blocks; `None` if no region is inflated.
    #[inline(always)]
    pub(super) fn sigma<S: Simd>(&self, simd: S, pair: Pair) -> Option<f32x16<S>> {
        let [sigma] = pair.load_regions(simd, self.inflation?);
        Some(sigma)
    }
}

/// The region transform that fits a rotation to each region, and adds its volume term. Its memory is the quaternion
/// of the rotation, as of [`FitRotations`].
pub(super) struct FitBulk<'a> {
    pub(super) fit: FitRotations<'a>,
    pub(super) volumes: RestVolumes<'a>,
}

impl RegionTransform<&mut [Block<4>]> for FitBulk<'_> {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], quaternions: &mut [Block<4>]) {
        for index in (0..sums.len()).step_by(2) {
            let pair = Pair::new(first, index, sums.len());
            let (inverse_mass, means) = self.fit.means(simd, pair, sums);
            let RestVolumes { inverse_covariances, bulk, .. } = self.volumes;
            let covariance = inverse_covariances.load_two(simd, pair.blocks);
            let sigma = self.volumes.sigma(simd, pair);
            // A of F/σ.
            let a = divided(simd, means.central, sigma);
            let term = match inverse_covariances.are_isotropic(pair.blocks) {
                true => VolumeTerm::of_isotropic(simd, &a, covariance[0], bulk),
                false => VolumeTerm::new(simd, &times(&a, covariance), covariance, bulk),
            };
            let q = self.fit.rotate(simd, pair, (means.mean, means.central), quaternions);
            let r = columns(simd, q);
            if let Some(potential) = self.fit.potential {
                let u = twice_trace(&a, &r) - term.energy;
                let u = sigma.map_or(u, |sigma| inflated(u, sigma, inverse(simd, covariance)));
                potential.store(&self.fit, pair, inverse_mass, means.mean, u);
            }
            let t = term.subtract_from(r);
            let t = sigma.map_or(t, |sigma| scaled(t, sigma));
            self.fit.store(simd, pair, (means.mean, means.d), t, sums);
        }
    }
}

/// Multiplies a matrix.
#[inline(always)]
pub(super) fn scaled<S: Simd>(mut matrix: [f32x16<S>; 9], factor: f32x16<S>) -> [f32x16<S>; 9] {
    for i in 0..9 {
        matrix[i] *= factor;
    }
    matrix
}

/// Divides the deformation gradients or the moments of regions by σ, if they are inflated.
#[inline(always)]
pub(super) fn divided<S: Simd>(simd: S, matrix: [f32x16<S>; 9], sigma: Option<f32x16<S>>) -> [f32x16<S>; 9] {
    sigma.map_or(matrix, |sigma| scaled(matrix, f32x16::splat(simd, 1.0) / sigma))
}

/// Returns u of [`PotentialSums::store`](super::goals::PotentialSums::store) for inflated regions with the rest
/// covariance `c`, from `u` of the regions that are as much smaller: σ² u less the change of the trace of C.
#[inline(always)]
pub(super) fn inflated<S: Simd>(u: f32x16<S>, sigma: f32x16<S>, c: [f32x16<S>; 6]) -> f32x16<S> {
    let trace = c[0] + c[1] + c[2];
    (sigma * sigma).times_plus(u - trace, trace)
}

/// The volume term of regions.
pub(super) struct VolumeTerm<S: Simd> {
    /// k Y, column by column.
    motion: [f32x16<S>; 9],
    /// 2 k W/t.
    pub(super) energy: f32x16<S>,
}

impl<S: Simd> VolumeTerm<S> {
    /// Computes the term of regions with the deformation gradient F and the inverse covariance C⁻¹. It is zero for
    /// regions without an inverse covariance. `bulk` is k.
    #[inline(always)]
    pub(super) fn new(simd: S, f: &[f32x16<S>; 9], mut covariance: [f32x16<S>; 6], bulk: f32) -> Self {
        let inverse_t = inverse_or_zero(simd, (covariance[0] + covariance[1] + covariance[2]) * (1.0 / 3.0));
        for i in 0..6 {
            covariance[i] *= inverse_t;
        }
        let cofactors = cofactors(f);
        let (p, energy) = slope(simd, f, (&cofactors, &times(&cofactors, covariance)), bulk);
        Self { motion: times(&p, covariance), energy: energy * inverse_t }
    }

    /// Computes the term of regions whose inverse covariances are `t` times the identity, so that D is the identity.
    /// `a` is A.
    #[inline(always)]
    fn of_isotropic(simd: S, a: &[f32x16<S>; 9], t: f32x16<S>, bulk: f32) -> Self {
        let f = scaled(*a, t);
        let cofactors = cofactors(&f);
        let (motion, energy) = slope(simd, &f, (&cofactors, &cofactors), bulk);
        Self { motion, energy: energy * inverse_or_zero(simd, t) }
    }

    /// Returns `g` - k Y.
    #[inline(always)]
    pub(super) fn subtract_from(&self, mut g: [f32x16<S>; 9]) -> [f32x16<S>; 9] {
        for i in 0..9 {
            g[i] -= self.motion[i];
        }
        g
    }
}

/// Computes k P and 2 k W from F, K, K D and k. Both are zero where numbers are too large.
#[inline(always)]
fn slope<S: Simd>(
    simd: S,
    f: &[f32x16<S>; 9],
    (cofactors, stretched): (&[f32x16<S>; 9], &[f32x16<S>; 9]),
    bulk: f32,
) -> ([f32x16<S>; 9], f32x16<S>) {
    let minus_one = f32x16::splat(simd, -1.0);
    let d = f[0]
        .times_plus(cofactors[0], f[1].times_plus(cofactors[1], f[2].times_plus(cofactors[2], minus_one)));
    let mut parts = [cofactors[0] * stretched[0], cofactors[1] * stretched[1], cofactors[2] * stretched[2]];
    for i in 3..9 {
        parts[i % 3] = cofactors[i].times_plus(stretched[i], parts[i % 3]);
    }
    let q = (parts[0] + parts[1]) + parts[2];
    let size = (d * 4.0).times_plus(d, q);
    let zero = f32x16::splat(simd, 0.0);
    // The comparison also leaves out NaN.
    let valid = size.simd_lt(f32x16::splat(simd, GREATEST_SIZE));
    let inverse = f32x16::splat(simd, 1.0) / size;
    let energy = (d * inverse) * (d * bulk);
    let kr = (d * inverse) * (inverse * bulk);
    let (along, beside) = (kr * q, kr * d);
    let mut p = crossed(stretched, f);
    for i in 0..9 {
        p[i] = valid.select(along.times_minus(cofactors[i], beside * p[i]), zero);
    }
    (p, valid.select(energy, zero))
}

/// Returns 1/t, or 0 for t = 0.
#[inline(always)]
fn inverse_or_zero<S: Simd>(simd: S, t: f32x16<S>) -> f32x16<S> {
    let zero = f32x16::splat(simd, 0.0);
    t.simd_gt(zero).select(f32x16::splat(simd, 1.0) / t, zero)
}

/// Computes the cofactor matrix of a matrix, column by column.
#[inline(always)]
fn cofactors<S: Simd>(f: &[f32x16<S>; 9]) -> [f32x16<S>; 9] {
    let mut k = *f;
    for column in 0..3 {
        let (a, b) = (3 * ((column + 1) % 3), 3 * ((column + 2) % 3));
        for row in 0..3 {
            let (i, j) = ((row + 1) % 3, (row + 2) % 3);
            k[3 * column + row] = f[a + i].times_minus(f[b + j], f[a + j] * f[b + i]);
        }
    }
    k
}

/// Computes X × F, column by column: the derivative of the cofactors of F in the direction X.
#[inline(always)]
fn crossed<S: Simd>(x: &[f32x16<S>; 9], f: &[f32x16<S>; 9]) -> [f32x16<S>; 9] {
    let mut z = *x;
    for column in 0..3 {
        let (a, b) = (3 * ((column + 1) % 3), 3 * ((column + 2) % 3));
        for row in 0..3 {
            let (i, j) = ((row + 1) % 3, (row + 2) % 3);
            let first = x[a + i].times_minus(f[b + j], x[a + j] * f[b + i]);
            let second = f[a + i].times_minus(x[b + j], f[a + j] * x[b + i]);
            z[3 * column + row] = first + second;
        }
    }
    z
}
