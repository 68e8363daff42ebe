//! Plastic shapes of regions: the rest shape of a region changes where the region is strained beyond a limit (Müller et
//! al. 2005).
//!
//! The plastic shape S of a region is a symmetric matrix with positive eigenvalues and the determinant 1. The region is
//! fitted with the rest offsets S y in place of y = x⁰ - c⁰: R is the rotation of A Sᵀ, and the motion of the region
//! moves a vertex to R S y + c. The sums over the regions stay the same, and so do the momenta: Σ m/n S y is zero,
//! and R is optimal for the moments of x and S y. S does not change the volume of the region.
//!
//! C = M⁻¹ Σ m/n y yᵀ is the rest covariance of a region, and F = A C⁻¹ its deformation gradient, the matrix for which
//! F y is closest to x - c. F S⁻¹ is its elastic part, and E = sym(Rᵀ F S⁻¹) the stretch of this part. The strain is
//! the deviatoric part D of E, relative to the mean stretch e = tr E/3. Without it, |D| is zero, also for a region that
//! is only compressed or expanded. Where |D| exceeds the yield strain, which may vary over the regions, S moves towards
//! the present shape:
//!
//! ```text
//! k = c (1 - yield/|D|)      H = k D/2      S ← (1 + H) S (1 + H)
//! ```
//!
//! with c = 1 - exp(-creep h), at most 1/2, and |k D| at most 1/2. Then S is scaled to the determinant 1, and pulled
//! back to |S - 1| <= max. |·| is the Frobenius norm.
//!
//! Müller et al. replace S by (1 + k D) S, which is not symmetric, and divide E by the cube root of its determinant.
//! The product with 1 + H on both sides agrees with the symmetric part of theirs to first order, and is positive
//! definite for every S. Dividing by the mean stretch agrees to first order as well, needs no root, and is safe for
//! inverted regions.
//!
//! The state stores T = S - 1, which is exactly zero in a region that has never yielded.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x16};

use super::algebra::{adjugate, full, inverse, norm_squared, symmetric_product, times};
use super::bulk::{RestVolumes, VolumeTerm, divided, inflated, scaled};
use super::cascade::RegionTransform;
use super::flow::{Flow, Strain, shape};
use super::goals::{FitRotations, Means, Pair, twice_trace};
use super::rotation::columns;
use crate::simd::lanes::{Block, Lanes};
use crate::simd::vector::Product;

/// The region transform that fits a rotation to each region in its plastic shape. Its memory is the quaternion of the
/// rotation, which is first the warm start and then the result.
pub(super) struct FitPlastic<'a> {
    pub(super) fit: FitRotations<'a>,
    pub(super) volumes: RestVolumes<'a>,
    /// T of each region.
    pub(super) strains: &'a Lanes<6>,
}

/// The region transform that fits rotations as [`FitPlastic`], and then lets the plastic shapes flow. The second part
/// of its memory is T of each region.
pub(super) struct FitFlowing<'a> {
    pub(super) fit: FitRotations<'a>,
    pub(super) volumes: RestVolumes<'a>,
    pub(super) flow: Flow,
    /// Factor of the yield strain of each region; `None` if all are 1.
    pub(super) yield_factors: Option<&'a Lanes<1>>,
}

impl RegionTransform<&mut [Block<4>]> for FitPlastic<'_> {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, first: usize, sums: &mut [Block<12>], quaternions: &mut [Block<4>]) {
        for index in (0..sums.len()).step_by(2) {
            let pair = Pair::new(first, index, sums.len());
            let t = pair.load_regions(simd, self.strains);
            let regions = (&self.fit, self.volumes);
            if is_any(t) {
                fit::<S, true>(simd, regions, pair, t, sums, quaternions);
            } else {
                fit::<S, false>(simd, regions, pair, t, sums, quaternions);
            }
        }
    }
}

impl RegionTransform<(&mut [Block<4>], &mut [Block<6>])> for FitFlowing<'_> {
    #[inline(always)]
    fn apply<S: Simd>(
        &self,
        simd: S,
        first: usize,
        sums: &mut [Block<12>],
        (quaternions, strains): (&mut [Block<4>], &mut [Block<6>]),
    ) {
        for index in (0..sums.len()).step_by(2) {
            let pair = Pair::new(first, index, sums.len());
            let t = pair.load(simd, strains);
            // Most regions of a body have never yielded. They would get the same results from the first branch.
            if is_any(t) {
                self.fit_pair::<S, true>(simd, pair, t, sums, (quaternions, strains));
            } else {
                self.fit_pair::<S, false>(simd, pair, t, sums, (quaternions, strains));
            }
        }
    }
}

impl FitFlowing<'_> {
    /// Fits the regions of two blocks, and lets their plastic shapes 1 + `t` flow. `IS_SHAPED`: whether `t` is not
    /// zero.
    #[inline(always)]
    fn fit_pair<S: Simd, const IS_SHAPED: bool>(
        &self,
        simd: S,
        pair: Pair,
        t: [f32x16<S>; 6],
        sums: &mut [Block<12>],
        (quaternions, strains): (&mut [Block<4>], &mut [Block<6>]),
    ) {
        let regions = (&self.fit, self.volumes);
        let fitted = fit::<S, IS_SHAPED>(simd, regions, pair, t, sums, quaternions);
        let mut limit = f32x16::splat(simd, self.flow.yield_strain);
        if let Some(factors) = self.yield_factors {
            let [factor] = pair.load_regions(simd, factors);
            limit *= factor;
        }
        if !fitted.may_yield::<IS_SHAPED>(simd, t, limit) {
            return;
        }
        let strain = Strain::new(simd, fitted.elastic_stretch(simd, t));
        let yields = strain.exceeds(limit);
        if yields.any_true() {
            let flowed = strain.flow(simd, t, (self.flow, limit));
            let mut new = t;
            for i in 0..6 {
                new[i] = yields.select(flowed[i], t[i]);
            }
            pair.store(simd, new, strains);
        }
    }
}

/// The fit of regions in their plastic shapes.
struct Fitted<S: Simd> {
    /// The deformation gradient F = A C⁻¹, column by column; F/σ of inflated regions.
    gradient: [f32x16<S>; 9],
    /// The rotation R of A S, column by column.
    r: [f32x16<S>; 9],
    /// G = R S, column by column.
    g: [f32x16<S>; 9],
}

/// Fits the regions of two blocks in their plastic shapes 1 + `t`, as [`FitRotations`] fits regions in their rest
/// shapes. `IS_SHAPED`: whether `t` is not zero.
#[inline(always)]
fn fit<S: Simd, const IS_SHAPED: bool>(
    simd: S,
    (fit, volumes): (&FitRotations, RestVolumes),
    pair: Pair,
    t: [f32x16<S>; 6],
    sums: &mut [Block<12>],
    quaternions: &mut [Block<4>],
) -> Fitted<S> {
    let (inverse_mass, means): (_, Means<f32x16<S>>) = fit.means(simd, pair, sums);
    let inverse_covariance = volumes.inverse_covariances.load_two(simd, pair.blocks);
    let sigma = volumes.sigma(simd, pair);
    let central = divided(simd, means.central, sigma);
    let gradient = times(&central, inverse_covariance);
    let a = if IS_SHAPED { times(&central, shape(simd, t)) } else { central };
    let r = columns(simd, fit.rotate(simd, pair, (means.mean, a), quaternions));
    // The plastic shape has the determinant 1, so that the volume term does not depend on it.
    let term =
        (volumes.bulk != 0.0).then(|| VolumeTerm::new(simd, &gradient, inverse_covariance, volumes.bulk));
    if let Some(potential) = fit.potential {
        let covariance = inverse(simd, inverse_covariance);
        let mut u = twice_trace(&a, &r) - covariance_change(covariance, t);
        if let Some(term) = &term {
            u -= term.energy;
        }
        let u = sigma.map_or(u, |sigma| inflated(u, sigma, covariance));
        potential.store(fit, pair, inverse_mass, means.mean, u);
    }
    let g = if IS_SHAPED { times(&r, shape(simd, t)) } else { r };
    let motion = term.map_or(g, |term| term.subtract_from(g));
    let motion = sigma.map_or(motion, |sigma| scaled(motion, sigma));
    fit.store(simd, pair, (means.mean, means.d), motion, sums);
    Fitted { gradient, r, g }
}

/// Returns whether any of some numbers is not zero.
#[inline(always)]
fn is_any<S: Simd>(numbers: [f32x16<S>; 6]) -> bool {
    let mut bits = numbers[0].to_bits();
    for i in 1..6 {
        bits |= numbers[i].to_bits();
    }
    bits.simd_gt(0).any_true()
}

/// Computes the change of the trace of the covariance C of a region by its plastic shape S = 1 + T: tr(S C S) - tr C,
/// which is tr(C (2 T + T²)).
#[inline(always)]
fn covariance_change<S: Simd>(c: [f32x16<S>; 6], t: [f32x16<S>; 6]) -> f32x16<S> {
    let change = symmetric_product(&full(t), t);
    let term = |i: usize| c[i] * (t[i] + t[i] + change[i]);
    let beside = term(3) + term(4) + term(5);
    (term(0) + term(1) + term(2)) + (beside + beside)
}

/// Share by which rounding errors change the numbers of [`Fitted::may_yield`] at most: 64 units of f32 for the sums of
/// nine products and the rounding of R.
const ROUNDING: f32 = 32.0 * f32::EPSILON;

impl<S: Simd> Fitted<S> {
    /// Returns whether |D| of some region may be above `limit`. `t` is T, and `IS_SHAPED` whether it is not zero.
    ///
    /// The result uses an upper bound of |D|, which is fast to compute. For limits below about 0.003, its
    /// rounding errors exceed the limit, so that every region may yield.
    ///
    /// E - c is the symmetric part of Rᵀ(F - c G) S⁻¹ for any number c. So |E - c| is at most b = s |F - c G|, where
    /// s is an upper bound of the eigenvalues of S⁻¹. Hence |D| e is at most b, and e is at least c - b/√3. b is
    /// least for c = F:G/|G|², where F:G is the sum of the products of the entries.
    ///
    /// The greatest eigenvalue v of S⁻¹ meets v⁻² + 2 v <= |S|², because the determinant of S is 1. So v is at most |S|²/2,
    /// and, because the left side is convex, at most the tangent at v = 1.25.
    #[inline(always)]
    fn may_yield<const IS_SHAPED: bool>(&self, simd: S, t: [f32x16<S>; 6], limit: f32x16<S>) -> bool {
        let (f, g) = (&self.gradient, &self.g);
        let (mut squared, mut product) = (f[0] * f[0], f[0] * g[0]);
        for i in 1..9 {
            squared = f[i].times_plus(f[i], squared);
            product = f[i].times_plus(g[i], product);
        }
        // |G|² = |S|², and s² |G|².
        let (mut size, mut scale) = (f32x16::splat(simd, 3.0), f32x16::splat(simd, 3.0));
        if IS_SHAPED {
            size = norm_squared(shape(simd, t));
            let s = size.times_plus(1.0246, f32x16::splat(simd, -1.967)).min(size * 0.5);
            scale = s * s * size;
        }
        // b <= limit (c - b/√3), times |G|² and squared.
        let product_squared = product * product;
        let misfit = squared.times_minus(size * (1.0 + ROUNDING), product_squared);
        let limit = limit / (limit / 3.0_f32.sqrt() + 1.0);
        let exceeds = (scale * misfit).simd_gt(product_squared * (limit * limit));
        (exceeds | product.simd_lt(0.0)).any_true()
    }

    /// Computes E = sym(Rᵀ F S⁻¹).
    #[inline(always)]
    fn elastic_stretch(&self, simd: S, t: [f32x16<S>; 6]) -> [f32x16<S>; 6] {
        // The inverse of a matrix of determinant 1 is its adjugate.
        let (x, r) = (times(&self.gradient, adjugate(shape(simd, t))), &self.r);
        let dot = |i: usize, j: usize| {
            r[3 * i].times_plus(x[3 * j], r[3 * i + 1].times_plus(x[3 * j + 1], r[3 * i + 2] * x[3 * j + 2]))
        };
        let mean = |i: usize, j: usize| (dot(i, j) + dot(j, i)) * 0.5;
        [dot(0, 0), dot(1, 1), dot(2, 2), mean(0, 1), mean(0, 2), mean(1, 2)]
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;
    use nalgebra::{Matrix3, Rotation3, Vector3};

    use super::*;
    use crate::matching::flow::LEAST_STRETCH;
    use crate::matching::symmetric;
    use crate::mesh::testing::Random;
    use crate::simd::level;

    /// Returns the matrix in all lanes, column by column.
    fn lanes<S: Simd>(simd: S, matrix: &Matrix3<f64>) -> [f32x16<S>; 9] {
        std::array::from_fn(|i| f32x16::splat(simd, matrix[i] as f32))
    }

    /// Returns whether the kernel takes the region for one that may yield.
    fn may_yield(gradient: &Matrix3<f64>, r: &Matrix3<f64>, t: [f32; 6], limit: f32) -> bool {
        let g = r * (Matrix3::identity() + symmetric(t));
        dispatch!(level(), simd => {
            let fitted = Fitted { gradient: lanes(simd, gradient), r: lanes(simd, r), g: lanes(simd, &g) };
            let t = t.map(|number| f32x16::splat(simd, number));
            let limit = f32x16::splat(simd, limit);
            if is_any(t) { fitted.may_yield::<true>(simd, t, limit) } else { fitted.may_yield::<false>(simd, t, limit) }
        })
    }

    /// No region whose strain exceeds the yield strain is left out, and all those far below it are.
    #[test]
    fn bound_of_the_strain_is_above_it_and_near_it() {
        let mut random = Random(7);
        let mut noise = || 2.0 * random.next() - 1.0;
        let (mut above, mut below) = (0, 0);
        for case in 0..20_000 {
            // Plastic shapes of determinant 1: none, moderate ones, large ones, and ones that are flat along an axis.
            let axis = Vector3::from_fn(|_, _| noise()).normalize();
            let flat = axis * axis.transpose();
            let mut shape = Matrix3::identity();
            if case % 4 < 3 {
                let size = [0.0, 0.1, 0.5][case % 4];
                shape += symmetric([0; 6].map(|_| (size * noise()) as f32));
                shape *= shape;
            } else {
                shape -= flat * (0.4 + 0.4 * noise());
            }
            shape /= libm::cbrt(shape.determinant());
            let entries = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
            let t = entries.map(|at| (shape - Matrix3::identity())[at] as f32);
            let shape = Matrix3::identity() + symmetric(t);
            // An elastic part with a strain, a size, and a rotation that is not the fitted one in every second case.
            // Some are strained along the axis, where F shows it least, and some are inverted.
            let strain = 0.6 * noise().powi(3);
            let mut change = Matrix3::from_fn(|_, _| strain * noise());
            let is_symmetric = case / 4 % 2 == 0;
            if is_symmetric {
                change = (change + change.transpose()) * 0.5;
            }
            if case / 8 % 2 == 0 {
                change = flat * strain;
            }
            let sign = if case / 16 % 8 == 0 { -1.0 } else { 1.0 };
            let elastic = (Matrix3::identity() + change) * (sign * (1.0 + 0.5 * noise()));
            let r = Rotation3::new(Vector3::from_fn(|_, _| 3.0 * noise())).into_inner();
            let gradient = r * elastic * shape;
            let stretch = (elastic + elastic.transpose()) * 0.5;
            let mean = stretch.trace() / 3.0;
            let strain = (stretch - Matrix3::identity() * mean).norm() / mean.max(f64::from(LEAST_STRETCH));
            for limit in [0.05, 0.5, strain as f32 * 0.9999] {
                if limit <= 0.0 || limit > 1.0 {
                    continue;
                }
                let may_yield = may_yield(&gradient, &r, t, limit);
                let limit = f64::from(limit);
                if strain > limit * (1.0 + 1e-5) {
                    above += 1;
                    assert!(may_yield, "case {case}: strain {strain}, limit {limit}");
                }
                // With the norm u of S, s <= |S|²/2 and |F - c G| <= |F - e G| <= u |D| e, so that c >= e (1 - u |D|/|S|).
                // A tenth is left for the rounding errors, which are greater for large shapes.
                let (u, size) = (shape.symmetric_eigenvalues().max(), shape.norm());
                let bound = 0.5 * size * size * u * strain;
                let least_mean = 1.0 - u * strain / size;
                if is_symmetric
                    && case % 4 < 2
                    && limit >= 0.05
                    && mean > f64::from(LEAST_STRETCH)
                    && bound < 0.9 * limit / (1.0 + limit / 3.0_f64.sqrt()) * least_mean
                {
                    below += 1;
                    assert!(!may_yield, "case {case}: strain {strain}, limit {limit}, bound {bound}");
                }
            }
        }
        assert!(above > 1000 && below > 1000, "{above} above, {below} below");
    }
}
